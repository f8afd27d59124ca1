//! Small breaks in addition to a defect of any size: a force that jumps a little, and momenta that are damped.

use std::sync::Arc;

use crate::truth_set::member::{Ellipses, Expected, Member, Step, Truth, halvings, map_of};
use crate::truth_set::random::Random;

pub const COUNT: usize = 160;

/// Damping has to come first if it exceeds the effect of the jumps by this factor.
const FAR: f64 = 1e4;

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(32, index);
    // Without damping nothing but the jumps is there to be found.
    let (jump, damping) = match index % 4 {
        0 => (random.log_between(1e-4, 1.0), 0.0),
        _ => (
            random.log_between(1e-11, 1e-3),
            random.log_between(1e-5, 0.2),
        ),
    };
    let at = random.between(-0.2, 0.2);
    let h = random.between(0.3, 0.9);
    let step: Step = Arc::new(move |h, q, p| {
        p[0] *= 1.0 - damping;
        q[0] += 0.5 * h * p[0];
        p[0] -= h * (q[0].sin() + jump * (q[0] - at).signum());
        q[0] += 0.5 * h * p[0];
    });
    let radius = random.between(0.4, 1.0);
    let on = Ellipses {
        q0: vec![random.between(-0.2, 0.2)],
        p0: vec![random.between(-0.5, 0.5)],
        radii_q: vec![radius],
        radii_p: vec![radius],
    };
    // Kicks of 2hj, over the area: a force that jumps at one position keeps closed loops.
    let of_jumps = 4.0 * h * jump / radius;
    let expected = match damping {
        0.0 => Expected::Broken { closed: Some(true) },
        // By how much all loop integrals change, closed or not.
        _ if damping > FAR * of_jumps => Expected::NotSymplectic,
        _ => Expected::Broken {
            closed: Some(false),
        },
    };
    let label = format!("jump {jump:.0e}, damping {damping:.0e}");
    let diagnostic = halvings(h, 5);
    Member::new(
        label,
        map_of(1, step),
        on.circle(),
        diagnostic,
        Truth::of(expected),
    )
}

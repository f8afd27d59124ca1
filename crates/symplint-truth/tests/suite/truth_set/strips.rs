//! Narrow strips of friction: p is damped where q is in a strip, then a symplectic step follows.
//!
//! The strip multiplies p by 1 − a w((q − c)/σ). On an ellipse with radii A and B that changes the loop integral by
//! −2 a B ∫ w((q − c)/σ) √(1 − ((q − q₀)/A)²) dq, the sum over both crossings. The samples of the loop meet a strip with tails at a few
//! places; its compact kind is wide enough for some sample of some loop.

use std::f64::consts::PI;
use std::sync::Arc;

use symplint::Diagnostic;

use crate::truth_set::member::{Expected, Member, Step, Truth, halvings, map_of};
use crate::truth_set::methods::leapfrog;
use crate::truth_set::random::Random;
use crate::truth_set::systems;

pub const COUNT: usize = 240;

/// The profile of a strip, and how far it reaches, in σ.
#[derive(Clone, Copy)]
struct Profile {
    name: &'static str,
    of: fn(f64) -> f64,
    reach: f64,
}

const PROFILES: [Profile; 4] = [
    Profile {
        name: "Gaussian",
        of: |x| (-x * x).exp(),
        reach: 6.5,
    },
    Profile {
        name: "sech²",
        of: |x| x.cosh().powi(-2),
        reach: 20.0,
    },
    Profile {
        name: "flat",
        of: |x| (-x.powi(4)).exp(),
        reach: 2.6,
    },
    Profile {
        name: "compact",
        of: |x| (1.0 - x * x).max(0.0).powi(6),
        reach: 1.0,
    },
];

/// The mean of a smooth function over [−1, 1] whose derivatives vanish at both ends.
fn mean(f: impl Fn(f64) -> f64) -> f64 {
    const POINTS: i32 = 4000;
    let at = |k: i32| f(-1.0 + (2.0 * f64::from(k) + 1.0) / f64::from(POINTS));
    (0..POINTS).map(at).sum::<f64>() / f64::from(POINTS)
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(11, index);
    let profile = PROFILES[index % PROFILES.len()];
    let system = systems::pendulum(random);
    let on = system.on.clone();
    let (q0, [radius_q, radius_p]) = (on.q0[0], [on.radii_q[0], on.radii_p[0]]);
    // Loops have 256 samples or more on a budget of 20,000, and 2048 on the default one.
    let small = random.chance(0.4);
    let least = match (small, profile.name) {
        (false, "compact") => 5e-4,
        (false, "flat") => 2e-4,
        (false, _) => 1e-4,
        (true, "compact") => 4e-3,
        (true, "flat") => 2e-3,
        (true, _) => 1e-3,
    };
    let width = random.log_between(least, 0.1);
    let place = random.between(-0.8, 0.8);
    let centre = q0 + radius_q * place;
    // 2σ are this part of the loop at each crossing.
    let sigma = PI * radius_q * (1.0 - place * place).sqrt() * width;
    let depth = random.log_between(1e-6, 0.9);
    let area = 2.0
        * profile.reach
        * mean(|x| {
            let x = profile.reach * x;
            let u = place + sigma * x / radius_q;
            (profile.of)(x) * (1.0 - u * u).max(0.0).sqrt()
        });
    let change = -2.0 * depth * radius_p * sigma * area / (PI * radius_q * radius_p);
    let leap = leapfrog(&system);
    let step: Step = Arc::new(move |h, q, p| {
        p[0] *= 1.0 - depth * (profile.of)((q[0] - centre) / sigma);
        leap(h, q, p);
    });
    let mut truth = Truth::of(Expected::Hidden(change.abs()));
    // The strip ends where the loop turns: then the sum over the midpoints is less exact.
    if (1.0 - place.abs()) * radius_q > profile.reach * sigma {
        truth.change = Some(Arc::new(move |_| change));
    }
    truth.initial = Some(on.integral());
    let diagnostic = Diagnostic {
        budget: small.then_some(20_000),
        ..halvings(random.between(0.4, 0.9) / system.omega, 8)
    };
    let label = format!(
        "{} strip of {width:.0e} of the loop, depth {depth:.0e}, change {change:.1e}{}",
        profile.name,
        if small { ", budget 20,000" } else { "" }
    );
    Member::new(label, map_of(1, step), on.circle(), diagnostic, truth)
}

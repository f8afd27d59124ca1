//! Small defects that are known exactly: momenta times 1 + δ, then a symplectic map.

use std::sync::Arc;

use crate::truth_set::member::{Expected, Member, Step, Truth, halvings, map_of};
use crate::truth_set::methods::leapfrog;
use crate::truth_set::random::Random;
use crate::truth_set::systems;

pub const COUNT: usize = 240;

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(7, index);
    let system = match random.chance(0.5) {
        true => systems::pendulum(random),
        false => {
            let dof = random.whole(1, 4);
            systems::chain(random, dof)
        }
    };
    let size = random.log_between(1e-15, 1e-3);
    let delta = random.sign() * size;
    let power = random.whole(0, 2) as i32;
    let largest = random.between(0.5, 1.0) / system.omega;
    // 1 + δ rounded to doubles.
    let law = move |h: f64| 1.0 + delta * (h / largest).powi(power) - 1.0;
    let leap = leapfrog(&system);
    let step: Step = Arc::new(move |h, q, p| {
        let factor = 1.0 + law(h);
        p.iter_mut().for_each(|p| *p *= factor);
        leap(h, q, p);
    });
    let found = law(largest).abs();
    let mut truth = Truth::of(Expected::SmallDefect(found)).with_change(law);
    truth.initial = Some(system.on.integral());
    if power > 0 && found > 1e-9 {
        truth.orders = vec![f64::from(power)];
    }
    let label = format!(
        "{} d = {}, det − 1 = {found:.0e} × h^{power}",
        system.name,
        system.dof()
    );
    let map = map_of(system.dof(), step);
    Member::new(label, map, system.on.circle(), halvings(largest, 10), truth)
}

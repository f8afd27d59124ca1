//! General systems: splittings, and Runge–Kutta methods with the order of their defect.

use crate::truth_set::member::{Expected, Member, SYMPLECTIC, Truth, halvings, map_of};
use crate::truth_set::methods::{SPLITTINGS, TABLEAUS, runge_kutta, splitting};
use crate::truth_set::random::Random;
use crate::truth_set::systems;

pub const COUNT: usize = 400;

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(6, index);
    let system = match random.whole(0, 3) {
        0 => systems::pendulum(random),
        1 => systems::henon_heiles(random),
        _ => {
            let dof = random.whole(1, 3);
            systems::chain(random, dof)
        }
    };
    let (name, step, truth) = match index % 4 {
        0 => {
            let (name, weights) = random.pick(&SPLITTINGS);
            let step = splitting(&system, weights, random.chance(0.5));
            (name, step, Truth::of(SYMPLECTIC).with_change(|_| 0.0))
        }
        _ => {
            let method = &TABLEAUS[random.whole(0, TABLEAUS.len() - 1)];
            let truth = Truth::of(Expected::NotSymplectic).with_orders(method.orders(system.dof()));
            (method.name, runge_kutta(&system, method), truth)
        }
    };
    let h = random.between(0.5, 1.0) / system.omega;
    let label = format!("{} d = {}, {name}", system.name, system.dof());
    let truth = Truth {
        initial: Some(system.on.integral()),
        ..truth
    };
    let map = map_of(system.dof(), step);
    Member::new(label, map, system.on.circle(), halvings(h, 10), truth)
}

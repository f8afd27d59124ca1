//! The same map by every rule, with few samples or many: what their errors are worth.

use symplint::Rule;
use symplint::diagnosis::SampleCount;
use symplint::rules::{Cutoffs, Piecewise, Streaming};

use crate::truth_set::member::{Expected, Member, SYMPLECTIC, Truth, halvings, map_of};
use crate::truth_set::methods::{damped, leapfrog};
use crate::truth_set::random::Random;
use crate::truth_set::systems;

pub const COUNT: usize = 320;

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(9, index);
    let system = match random.whole(0, 2) {
        0 => systems::pendulum(random),
        1 => systems::kepler(random),
        _ => {
            let dof = random.whole(1, 3);
            systems::chain(random, dof)
        }
    };
    let mut step = leapfrog(&system);
    let mut truth = Truth::of(SYMPLECTIC).with_change(|_| 0.0);
    if random.chance(0.5) {
        let factor = 1.0 - random.between(0.02, 0.2);
        step = damped(step, factor);
        truth = Truth::of(Expected::NotSymplectic).with_change(move |_| factor - 1.0);
    }
    // Steps of up to two radians deform the loop so much that few samples do not resolve it.
    let mut diagnostic = halvings(random.between(0.5, 2.0) / system.omega, 5);
    diagnostic.loops = 3;
    let rule = match index % 4 {
        0 => Rule::Pseudospectral,
        1 => Rule::FiniteDifference(Cutoffs::none()),
        2 => Rule::Piecewise(Piecewise {
            tolerance: random.log_between(1e-12, 1e-6),
            ..Piecewise::default()
        }),
        _ => Rule::Streaming(Streaming::default()),
    };
    diagnostic.rule = rule;
    let mut samples = String::new();
    if index % 4 != 2 && random.chance(0.8) {
        let count = random.log_between(32.0, 4096.0) as usize;
        diagnostic.samples = SampleCount::Fixed(count);
        samples = format!(", {count} samples");
    }
    let label = format!(
        "{} d = {}, {}{samples}",
        system.name,
        system.dof(),
        rule.kind()
    );
    truth.initial = Some(system.on.integral());
    Member::new(
        label,
        map_of(system.dof(), step),
        system.on.circle(),
        diagnostic,
        truth,
    )
}

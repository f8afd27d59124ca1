//! Single precision, and output with few digits.

use std::sync::Arc;

use symplint::Loop;

use crate::truth_set::member::{Expected, Member, Step, Subject, Truth, halvings, map_of};
use crate::truth_set::methods::{damped, leapfrog, runge_kutta, tableau};
use crate::truth_set::networks;
use crate::truth_set::random::Random;
use crate::truth_set::rounding::Rounding;
use crate::truth_set::rows::Spacing;
use crate::truth_set::systems::{self, MAX_DOF, System};

pub const COUNT: usize = 500;

/// Independent rounding errors of N samples average out to 1/√N of one; a diagnosis takes 65,536 samples at most. Integrals are
/// better than a single state by no more digits than log₁₀ √65,536.
const AVERAGED: f64 = 2.41;

/// A step that is symplectic, or one with a defect far above the rounding.
fn method(random: &mut Random, system: &System, part: f64) -> (&'static str, Step, bool) {
    if random.chance(0.6) {
        return ("leapfrog", leapfrog(system), true);
    }
    match random.chance(0.5) {
        true => {
            let factor = 1.0 - random.between(part, 0.3);
            ("damped", damped(leapfrog(system), factor), false)
        }
        false => ("euler", runge_kutta(system, tableau("euler")), false),
    }
}

/// The right verdict about a map whose states have this rounding error, as a part of the loop.
fn truth(symplectic: bool, error: f64) -> Truth {
    Truth::of(match symplectic {
        true => Expected::Symplectic {
            most_digits: -error.log10() + AVERAGED,
        },
        false => Expected::NotSymplectic,
    })
}

/// The rounding error of a state over the smallest radius of the loop.
fn relative_error(rounding: Rounding, system: &System) -> f64 {
    let on = &system.on;
    let rows = [(&on.q0, &on.radii_q), (&on.p0, &on.radii_p)];
    (rows.iter().flat_map(|(x, r)| x.iter().zip(*r)))
        .map(|(x, r)| rounding.error(x.abs() + r) / r)
        .fold(0.0, f64::max)
}

fn small_system(random: &mut Random) -> System {
    match random.whole(0, 3) {
        0 => systems::pendulum(random),
        1 => systems::kepler(random),
        _ => {
            let dof = random.whole(1, 4);
            systems::chain(random, dof)
        }
    }
}

/// States that are rounded after the step.
fn rounded(random: &mut Random) -> Member {
    let system = small_system(random);
    let rounding = match random.whole(0, 2) {
        0 => Rounding::Single,
        1 => Rounding::Decimals(random.whole(4, 10) as i32),
        _ => Rounding::Digits(random.whole(4, 10)),
    };
    let error = relative_error(rounding, &system);
    let (name, step, symplectic) = method(random, &system, (100.0 * error).clamp(0.01, 0.2));
    let exact = map_of(system.dof(), step.clone());
    let map = map_of(
        system.dof(),
        Arc::new(move |h, q, p| {
            step(h, q, p);
            rounding.state(q);
            rounding.state(p);
        }),
    );
    let label = format!(
        "{} d = {}, {name}, {rounding:?} returned",
        system.name,
        system.dof()
    );
    let h = random.between(0.4, 1.0) / system.omega;
    let truth = truth(symplectic, error);
    Member::new(label, map, system.on.circle(), halvings(h, 8), truth).in_full_precision(exact)
}

/// Forces in single precision.
fn forces(random: &mut Random) -> Member {
    let system = small_system(random);
    let mut single = system.clone();
    let force = system.force.clone();
    single.force = Arc::new(move |q, f| {
        let mut x = [0.0; MAX_DOF];
        x[..q.len()].copy_from_slice(q);
        Rounding::Single.state(&mut x);
        force(&x[..q.len()], f);
        Rounding::Single.state(f);
    });
    let choice = random.seed() as usize;
    let of = |system: &System| method(&mut Random::of(21, choice), system, 0.02);
    let (name, step, symplectic) = of(&single);
    let label = format!(
        "{} d = {}, {name}, forces in f32",
        system.name,
        system.dof()
    );
    let h = random.between(0.4, 1.0) / system.omega;
    let truth = truth(symplectic, relative_error(Rounding::Single, &system));
    let exact = map_of(system.dof(), of(&system).1);
    let map = map_of(system.dof(), step);
    Member::new(label, map, system.on.circle(), halvings(h, 8), truth).in_full_precision(exact)
}

/// A pendulum on a spring, every operation in f32 or in f64.
fn inside(random: &mut Random) -> Member {
    let (k, spring) = (random.between(0.5, 2.0), random.between(0.1, 0.5));
    let kind = random.whole(0, 3);
    let factor = 1.0 - random.between(0.02, 0.2);
    let mut system = systems::pendulum(random);
    macro_rules! step {
        ($float:ident) => {
            Arc::new(move |h: f64, q: &mut [f64], p: &mut [f64]| {
                let force = |x: $float| -(k as $float) * x.sin() - spring as $float * x;
                let (h, mut x, mut y) = (h as $float, q[0] as $float, p[0] as $float);
                match kind {
                    0 | 1 => {
                        y += 0.5 * h * force(x);
                        x += h * y;
                        y += 0.5 * h * force(x);
                    }
                    2 => {
                        y = y * factor as $float + h * force(x);
                        x += h * y;
                    }
                    _ => (x, y) = (x + h * y, y + h * force(x)),
                }
                (q[0], p[0]) = (f64::from(x), f64::from(y));
            })
        };
    }
    system.omega = (k + spring).sqrt();
    let name = ["leapfrog", "leapfrog", "damped", "euler"][kind];
    let label = format!("pendulum on a spring, {name}, all inside f32");
    let h = random.between(0.4, 1.0) / system.omega;
    let truth = truth(kind < 2, relative_error(Rounding::Single, &system));
    Member::new(
        label,
        map_of(1, step!(f32)),
        system.on.circle(),
        halvings(h, 8),
        truth,
    )
    .in_full_precision(map_of(1, step!(f64)))
}

/// Loops of another code, in files with few digits.
fn files(random: &mut Random) -> Member {
    let system = small_system(random);
    let rounding = match random.whole(0, 2) {
        0 => Rounding::Single,
        1 => Rounding::Decimals(random.whole(4, 12) as i32),
        _ => Rounding::Digits(random.whole(4, 15)),
    };
    let error = relative_error(rounding, &system);
    let (name, step, symplectic) = method(random, &system, (100.0 * error).clamp(0.01, 0.2));
    let samples = random.pick(&[128, 200, 512, 1000, 2048]);
    let h = random.between(0.4, 1.0) / system.omega;
    let on: Arc<dyn Loop> = Arc::new(system.on.circle());
    Member {
        label: format!(
            "{} d = {}, {name}, files of {samples} samples, {rounding:?}",
            system.name,
            system.dof()
        ),
        subject: Subject::Samples {
            map: map_of(system.dof(), step),
            on,
            samples,
            spacing: Spacing::Equal,
            step_sizes: vec![h, h / 2.0, h / 4.0],
            rounding,
        },
        truth: truth(symplectic, error),
    }
}

/// A network in single precision as the force of a kick.
fn network(random: &mut Random) -> Member {
    let network = networks::random(random);
    let error = f64::from(f32::EPSILON);
    let truth = truth(network.symplectic, error);
    let map = map_of(network.dof, network.single.clone());
    let exact = map_of(network.dof, network.double.clone());
    Member::new(network.label, map, network.on, halvings(0.7, 8), truth).in_full_precision(exact)
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(2, index);
    match index % 5 {
        0 => rounded(random),
        1 => forces(random),
        2 => inside(random),
        3 => files(random),
        _ => network(random),
    }
}

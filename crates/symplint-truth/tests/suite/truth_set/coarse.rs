//! Output of few levels and in any unit, and loops of a few roundings.

use std::sync::Arc;

use symplint::{Diagnostic, Loop, Rule};

use crate::truth_set::member::{Expected, Member, Step, Subject, Truth, halvings, map_of};
use crate::truth_set::methods::{damped, leapfrog, runge_kutta, tableau};
use crate::truth_set::random::Random;
use crate::truth_set::rounding::Rounding;
use crate::truth_set::rows::Spacing;
use crate::truth_set::systems::{self, MAX_DOF, System};

pub const COUNT: usize = 400;

/// As of the family of output precision: integrals are better than a state by the root of 65,536 samples.
const AVERAGED: f64 = 2.41;

/// Radians, degrees, inches in metres, and a unit that is not in use.
const UNITS: [f64; 4] = [1.0, std::f64::consts::PI / 180.0, 0.0254, 1.0 / 3.0];

const BUDGETS: [Option<usize>; 4] = [Some(200), Some(1_000), Some(20_000), None];

/// A pendulum, or coupled oscillators, on a loop of this radius.
fn system(random: &mut Random, radius: f64) -> System {
    let is_pendulum = random.chance(0.7);
    let mut system = match is_pendulum {
        true => systems::pendulum(random),
        false => systems::chain(random, 2),
    };
    let part = radius / system.on.radii_q[0];
    for radii in [&mut system.on.radii_q, &mut system.on.radii_p] {
        radii.iter_mut().for_each(|r| *r *= part);
    }
    // Quartic oscillators are too stiff there.
    if is_pendulum && random.chance(0.3) {
        system.on.q0[0] += 50.0;
    }
    system
}

/// A step that is symplectic, or one with a defect of several per cent; the same choice for the same seed.
fn method(seed: usize, system: &System) -> (&'static str, Step, bool) {
    let random = &mut Random::of(23, seed);
    match random.whole(0, 4) {
        0 => (
            "damped",
            damped(leapfrog(system), random.between(0.8, 0.9)),
            false,
        ),
        1 => ("euler", runge_kutta(system, tableau("euler")), false),
        _ => ("leapfrog", leapfrog(system), true),
    }
}

fn truth(symplectic: bool, error: f64) -> Truth {
    Truth::of(match symplectic {
        true => Expected::Symplectic {
            most_digits: -error.log10() + AVERAGED,
        },
        false => Expected::NotSymplectic,
    })
}

fn diagnostic(random: &mut Random, h: f64) -> Diagnostic {
    Diagnostic {
        budget: random.pick(&BUDGETS),
        rule: match random.whole(0, 5) {
            0 => Rule::Pseudospectral,
            1 => Rule::Piecewise(Default::default()),
            2 => Rule::Streaming(Default::default()),
            _ => Rule::Auto,
        },
        ..halvings(h, 8)
    }
}

/// A format in which the loop is 0.3 to 10 000 levels wide, or, of significant digits, about as many.
fn coarse(random: &mut Random, radius: f64) -> Rounding {
    let unit = 2.0 * radius / random.log_between(0.3, 1e4);
    let decimals = 10f64.powf(unit.log10().floor());
    match random.whole(0, 2) {
        0 => Rounding::Multiples(decimals),
        _ => Rounding::Multiples(decimals * random.pick(&UNITS)),
    }
}

/// States that are rounded after the step.
fn returned(random: &mut Random) -> Member {
    let radius = random.log_between(1e-5, 1.0);
    let system = system(random, radius);
    let rounding = coarse(random, radius);
    let (name, step, symplectic) = method(random.seed() as usize % 1000, &system);
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
        "{}, {name}, r = {radius:.1e}, {rounding:?} returned",
        system.name
    );
    let h = random.between(0.4, 1.0) / system.omega;
    let truth = truth(symplectic, rounding.error(1.0) / radius);
    let diagnostic = diagnostic(random, h);
    Member::new(label, map, system.on.circle(), diagnostic, truth).in_full_precision(exact)
}

/// Forces, or all that is returned, in single precision, in radians or degrees, on loops down to one rounding.
fn single(random: &mut Random) -> Member {
    let radius = random.log_between(1e-6, 1.0);
    let system = system(random, radius);
    let unit = random.pick(&UNITS);
    let to_single = move |values: &mut [f64]| {
        values
            .iter_mut()
            .for_each(|x| *x = unit * f64::from((*x / unit) as f32));
    };
    let mut of_single = system.clone();
    let force = system.force.clone();
    of_single.force = Arc::new(move |q, f| {
        let mut x = [0.0; MAX_DOF];
        x[..q.len()].copy_from_slice(q);
        to_single(&mut x);
        force(&x[..q.len()], f);
        to_single(f);
    });
    let seed = random.seed() as usize % 1000;
    let (name, exact, symplectic) = method(seed, &system);
    let (what, map) = match random.chance(0.5) {
        true => (
            "forces in f32",
            map_of(system.dof(), method(seed, &of_single).1),
        ),
        false => {
            let step = exact.clone();
            let rounded: Step = Arc::new(move |h, q, p| {
                step(h, q, p);
                to_single(q);
                to_single(p);
            });
            ("f32 returned", map_of(system.dof(), rounded))
        }
    };
    let label = format!(
        "{}, {name}, r = {radius:.1e}, {what}, unit {unit:.3}",
        system.name
    );
    let h = random.between(0.4, 1.0) / system.omega;
    let largest = system.on.q0.iter().fold(0.3, |m: f64, x| m.max(x.abs())) + radius;
    let truth = truth(symplectic, Rounding::Single.error(largest) / radius);
    let exact = map_of(system.dof(), exact);
    let diagnostic = diagnostic(random, h);
    Member::new(label, map, system.on.circle(), diagnostic, truth).in_full_precision(exact)
}

/// Files, each coordinate of which has few levels or many.
fn files(random: &mut Random) -> Member {
    let radius = random.log_between(1e-3, 1.0);
    let system = system(random, radius);
    let rounding = coarse(random, radius);
    let (name, step, symplectic) = method(random.seed() as usize % 1000, &system);
    let samples = random.pick(&[32, 64, 200, 1000, 4096]);
    let h = random.between(0.4, 1.0) / system.omega;
    let on: Arc<dyn Loop> = Arc::new(system.on.circle());
    Member {
        label: format!(
            "{}, {name}, files of {samples} samples, {rounding:?}",
            system.name
        ),
        subject: Subject::Samples {
            map: map_of(system.dof(), step),
            on,
            samples,
            spacing: Spacing::Equal,
            step_sizes: vec![h, h / 2.0, h / 4.0],
            rounding,
        },
        truth: truth(symplectic, rounding.error(1.0) / radius),
    }
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(13, index);
    match index % 4 {
        0 | 1 => returned(random),
        2 => single(random),
        _ => files(random),
    }
}

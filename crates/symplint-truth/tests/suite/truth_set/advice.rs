//! Maps and settings of which the first verdict is undecided, for as many reasons as there are: following the advice decides.

use std::sync::Arc;

use symplint::diagnosis::SampleCount;
use symplint::rules::Cutoffs;
use symplint::{Diagnostic, Rule};

use crate::truth_set::member::{
    Ellipses, Expected, Member, SYMPLECTIC, Step, Truth, halvings, map_of,
};
use crate::truth_set::methods::{damped, leapfrog};
use crate::truth_set::random::Random;
use crate::truth_set::systems::{self, MAX_DOF, System};
use crate::truth_set::tolerance;

pub const COUNT: usize = 320;

/// A symplectic step, or one that changes every loop integral by this factor less 1.
fn method(random: &mut Random, system: &System) -> (String, Step, Truth) {
    match random.chance(0.6) {
        true => {
            let truth = Truth::of(SYMPLECTIC).with_change(|_| 0.0);
            ("leapfrog".into(), leapfrog(system), truth)
        }
        false => {
            let factor = 1.0 - random.log_between(1e-3, 0.1);
            let truth = Truth::of(Expected::NotSymplectic).with_change(move |_| factor - 1.0);
            let name = format!("p × {factor:.4}");
            (name, damped(leapfrog(system), factor), truth)
        }
    }
}

/// A system in units of length, momentum and time that no loop of radius 1 fits.
fn si_units(random: &mut Random) -> Member {
    let system = match random.chance(0.5) {
        true => systems::kepler(random),
        false => systems::pendulum(random),
    };
    let length = random.log_between(1e6, 1e11);
    // Speeds and forces as of planets and machines: momenta are smaller numbers than positions.
    let momentum = random.log_between(1e2, 1e4);
    let time = length / momentum;
    let (name, step, truth) = method(random, &system);
    let scaled: Step = Arc::new(move |h, q, p| {
        let dof = q.len();
        let (mut x, mut y) = ([0.0; MAX_DOF], [0.0; MAX_DOF]);
        for i in 0..dof {
            (x[i], y[i]) = (q[i] / length, p[i] / momentum);
        }
        step(h / time, &mut x[..dof], &mut y[..dof]);
        for i in 0..dof {
            (q[i], p[i]) = (length * x[i], momentum * y[i]);
        }
    });
    let dof = system.dof();
    let times = |x: &[f64], unit: f64| x.iter().map(|x| x * unit).collect();
    let on = Ellipses {
        q0: times(&system.on.q0, length),
        p0: times(&system.on.p0, momentum),
        radii_q: vec![1.0; dof],
        radii_p: vec![1.0; dof],
    };
    let h = time / system.omega * random.log_between(1e-3, 1e-1);
    let diagnostic = match random.chance(0.5) {
        true => Diagnostic::around(h),
        false => halvings(h, 8),
    };
    let label = format!(
        "{} in units of {length:.0e}, {momentum:.0e}, {name}",
        system.name
    );
    Member::new(label, map_of(dof, scaled), on.circle(), diagnostic, truth)
}

/// States in single precision, on loops on which the bound is near 1e-6.
fn few_digits(random: &mut Random) -> Member {
    let system = systems::pendulum(random);
    let (name, exact, truth) = method(random, &system);
    let mut on = system.on.clone();
    let part = random.log_between(1e-3, 0.3);
    (on.radii_q[0], on.radii_p[0]) = (part * on.radii_q[0], part * on.radii_p[0]);
    let step = exact.clone();
    let rounded: Step = Arc::new(move |h, q, p| {
        step(h, q, p);
        (q[0], p[0]) = (f64::from(q[0] as f32), f64::from(p[0] as f32));
    });
    let h = random.between(0.3, 0.8) / system.omega;
    let budget = random.pick(&[2_000, 20_000]);
    let diagnostic = Diagnostic {
        budget: Some(budget),
        ..halvings(h, 4)
    };
    // The effect of rounding on the loop is not known to the last bit.
    let truth = Truth {
        change: None,
        expected: match truth.expected {
            Expected::Symplectic { .. } => Expected::Symplectic {
                most_digits: 7.0 + 2.41,
            },
            other => other,
        },
        ..truth
    };
    let label = format!("f32, loop × {part:.0e}, {name}, budget {budget}");
    Member::new(label, map_of(1, rounded), on.circle(), diagnostic, truth)
        .in_full_precision(map_of(1, exact))
}

/// Budgets from the least one on.
fn small_budget(random: &mut Random) -> Member {
    let system = systems::any(random);
    let (name, step, truth) = method(random, &system);
    let h = random.between(0.3, 1.0) / system.omega;
    let budget = random.log_between(200.0, 2e3) as usize;
    let diagnostic = Diagnostic {
        budget: Some(budget),
        ..halvings(h, 10)
    };
    let label = format!(
        "{} d = {}, {name}, budget {budget}",
        system.name,
        system.dof()
    );
    Member::new(
        label,
        map_of(system.dof(), step),
        system.on.circle(),
        diagnostic,
        truth,
    )
}

/// A kick alone, or a free flight, by a small step.
fn shear(random: &mut Random) -> Member {
    let system = systems::pendulum(random);
    let force = system.force.clone();
    let kick = random.chance(0.5);
    let step: Step = Arc::new(move |h, q, p| match kick {
        true => {
            let mut f = [0.0];
            force(q, &mut f);
            p[0] += h * f[0];
        }
        false => q[0] += h * (p[0] + 0.1 * p[0].powi(3)),
    });
    let h = random.log_between(1e-6, 0.3) / system.omega;
    let name = if kick { "a kick" } else { "a free flight" };
    let truth = Truth::of(SYMPLECTIC).with_change(|_| 0.0);
    let label = format!("{name}, h = {h:.0e}");
    Member::new(
        label,
        map_of(1, step),
        system.on.circle(),
        halvings(h, 6),
        truth,
    )
}

fn tiny_steps(random: &mut Random) -> Member {
    let system = systems::any(random);
    let (name, step, truth) = method(random, &system);
    let h = random.log_between(1e-5, 0.05) / system.omega;
    let label = format!(
        "{} d = {}, {name}, hω = {:.0e}",
        system.name,
        system.dof(),
        h * system.omega
    );
    let map = map_of(system.dof(), step);
    Member::new(label, map, system.on.circle(), halvings(h, 6), truth)
}

/// A rule or a number of samples that is too weak.
fn weak_rule(random: &mut Random) -> Member {
    let system = systems::any(random);
    let (name, step, truth) = method(random, &system);
    let h = random.between(0.3, 1.0) / system.omega;
    let mut diagnostic = halvings(h, 5);
    diagnostic.samples = SampleCount::Fixed(random.pick(&[16, 64, 256]));
    if random.chance(0.6) {
        diagnostic.rule = Rule::FiniteDifference(Cutoffs::none());
    }
    let label = format!(
        "{} d = {}, {name}, {:?}",
        system.name,
        system.dof(),
        diagnostic.samples
    );
    let map = map_of(system.dof(), step);
    Member::new(label, map, system.on.circle(), diagnostic, truth)
}

/// A loop that a step deforms by hundreds of times its size.
fn stretched(random: &mut Random) -> Member {
    let k = random.log_between(30.0, 3e3);
    let step: Step = Arc::new(move |h, q, p| {
        p[0] -= h * k * q[0].sin();
        q[0] += h * p[0];
    });
    let radius = random.between(0.5, 1.5);
    let on = Ellipses {
        q0: vec![random.between(-1.0, 1.0)],
        p0: vec![random.between(-1.0, 1.0)],
        radii_q: vec![radius],
        radii_p: vec![radius],
    };
    let truth = Truth::of(SYMPLECTIC).with_change(|_| 0.0);
    let diagnostic = Diagnostic {
        budget: Some(random.pick(&[5_000, 20_000])),
        ..halvings(1.0, 3)
    };
    Member::new(
        format!("a kick of {k:.0e}"),
        map_of(1, step),
        on.circle(),
        diagnostic,
        truth,
    )
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(33, index);
    match index % 8 {
        0 => si_units(random),
        1 => few_digits(random),
        2 => small_budget(random),
        3 => shear(random),
        4 => tiny_steps(random),
        5 => weak_rule(random),
        6 => stretched(random),
        _ => tolerance::solved(random, 1e-9, 1e-7),
    }
}

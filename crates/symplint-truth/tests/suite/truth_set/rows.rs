//! Loops of another code whose rows are not equally spaced: some were lost, the first one is repeated, or neighbours are anywhere.
//!
//! A splitting changes no loop integral, and damping all momenta by a factor changes all of them by it, whatever rows are known.

use std::f64::consts::TAU;
use std::sync::Arc;

use symplint::{FourierLoop, Loop};

use crate::truth_set::member::{Expected, Member, SYMPLECTIC, Step, Subject, Truth, map_of};
use crate::truth_set::methods::{damped, leapfrog};
use crate::truth_set::random::Random;
use crate::truth_set::rounding::Rounding;
use crate::truth_set::systems;

pub const COUNT: usize = 360;

/// The places of the rows of a loop.
#[derive(Clone, Copy, Debug)]
pub enum Spacing {
    /// s = k/N.
    Equal,
    /// s = k/(N − 1): the last row repeats the first one.
    Closed,
    /// Some rows are missing, this part of all, or one.
    Lost { part: f64, seed: u64 },
    /// Rows next to each other are missing, this part of the loop from here on.
    Run { from: f64, part: f64 },
    /// Both of these, as data of a run that was interrupted.
    ClosedRun { from: f64, part: f64 },
    /// Rows are shifted by up to this part of a cell.
    Jitter { part: f64, seed: u64 },
    /// Rows are anywhere.
    Random { seed: u64 },
    /// Rows are denser on one side, smoothly.
    Warped { by: f64 },
    /// Rows are this many times denser on a fifth of the loop.
    Dense { times: f64, from: f64 },
}

impl Spacing {
    /// The parameters of the rows, of N at equal distances.
    pub fn parameters(self, samples: usize) -> Vec<f64> {
        let n = samples as f64;
        let equal = (0..samples).map(|k| k as f64 / n);
        let is_in = |s: f64, from: f64, part: f64| (s - from).rem_euclid(1.0) < part;
        let closed = (0..samples).map(|k| k as f64 / (n - 1.0));
        match self {
            Spacing::Equal => equal.collect(),
            Spacing::Closed => closed.collect(),
            Spacing::Lost { part, seed } => {
                let random = &mut Random::of(seed, samples);
                let mut rows: Vec<f64> = equal.collect();
                for _ in 0..(part * n).ceil().max(1.0) as usize {
                    rows.remove(random.whole(0, rows.len() - 1));
                }
                rows
            }
            Spacing::Run { from, part } => equal.filter(|s| !is_in(*s, from, part)).collect(),
            Spacing::ClosedRun { from, part } => {
                let is_end = |s: f64| s == 0.0 || s == 1.0;
                closed
                    .filter(|s| is_end(*s) || !is_in(*s, from, part))
                    .collect()
            }
            Spacing::Jitter { part, seed } => {
                let random = &mut Random::of(seed, samples);
                equal.map(|s| s + part * random.unit() / n).collect()
            }
            Spacing::Random { seed } => {
                let random = &mut Random::of(seed, samples);
                let mut rows: Vec<f64> = (0..samples).map(|_| random.unit()).collect();
                rows.sort_by(f64::total_cmp);
                rows
            }
            Spacing::Warped { by } => equal.map(|s| s + by * (TAU * s).sin() / TAU).collect(),
            Spacing::Dense { times, from } => {
                // A fifth of the loop takes this part of the rows.
                let part = times * 0.2 / (times * 0.2 + 0.8);
                let at = |u: f64| match u < part {
                    true => 0.2 * u / part,
                    false => 0.2 + 0.8 * (u - part) / (1.0 - part),
                };
                equal.map(|u| from + at(u)).collect()
            }
        }
    }

    fn random(random: &mut Random) -> Self {
        let (seed, from) = (random.seed() % 1000 + 1000, random.between(0.02, 0.98));
        match random.whole(0, 8) {
            0 | 1 => Spacing::Closed,
            2 | 3 => Spacing::Lost {
                part: random.pick(&[0.0, 0.01, 0.03, 0.1]),
                seed,
            },
            4 => Spacing::Run {
                from,
                part: random.between(0.005, 0.06),
            },
            5 => Spacing::ClosedRun {
                from,
                part: random.between(0.005, 0.06),
            },
            6 => Spacing::Jitter {
                part: random.log_between(1e-6, 0.9),
                seed,
            },
            7 => Spacing::Random { seed },
            _ => match random.chance(0.5) {
                true => Spacing::Warped {
                    by: random.between(0.1, 0.7),
                },
                false => Spacing::Dense {
                    times: random.between(1.5, 6.0),
                    from,
                },
            },
        }
    }
}

/// Smooth maps.
fn smooth(random: &mut Random) -> Member {
    let system = match random.whole(0, 2) {
        0 => systems::pendulum(random),
        1 => systems::henon_heiles(random),
        _ => {
            let dof = random.whole(1, 4);
            systems::chain(random, dof)
        }
    };
    let h = random.between(0.3, 0.6) / system.omega;
    let (name, step, factor) = match random.chance(0.5) {
        true => ("leapfrog", leapfrog(&system), 1.0),
        false => {
            let factor = 1.0 - random.log_between(1e-4, 0.2);
            ("damped", damped(leapfrog(&system), factor), factor)
        }
    };
    let expected = if factor == 1.0 {
        SYMPLECTIC
    } else {
        Expected::NotSymplectic
    };
    let mut truth = Truth::of(expected).with_change(move |_| factor - 1.0);
    let on: Arc<dyn Loop> = match random.chance(0.7) {
        true => {
            truth.initial = Some(system.on.integral());
            Arc::new(system.on.circle())
        }
        false => {
            let on = &system.on;
            let scaled = |radii: &[f64]| radii.iter().map(|r| 0.7 * r).collect::<Vec<_>>();
            let radii = [scaled(&on.radii_q), scaled(&on.radii_p)];
            let found = FourierLoop::random(
                on.q0.clone(),
                on.p0.clone(),
                &radii[0],
                &radii[1],
                random.seed(),
            );
            Arc::new(found.expect("a random loop"))
        }
    };
    let samples = random.pick(&[64, 100, 256, 500, 1024, 4096]);
    let what = format!("{} d = {}, {name}", system.name, system.dof());
    of_rows(random, what, (system.dof(), step, h), on, samples, truth)
}

/// A free flight after a kick that jumps by −h J at the middle of an ellipse: the integral between the breaks grows by 2 h² J b, with the
/// radius b in p, as both breaks add −(h/2) (p₊² − p₋²).
fn jumping(random: &mut Random) -> Member {
    let jump = random.between(0.5, 1.0);
    let on = systems::pendulum(random).on;
    let (q0, radii) = (on.q0[0], [on.radii_q[0], on.radii_p[0]]);
    let jump = jump * radii[1];
    let step: Step = Arc::new(move |h, q, p| {
        p[0] -= h * (q[0] - q0) + if q[0] > q0 { h * jump } else { 0.0 };
        q[0] += h * p[0];
    });
    let law = move |h: f64| 2.0 * h * h * jump * radii[1] / on_integral(radii);
    let truth = Truth {
        initial: Some(on.integral()),
        change: Some(Arc::new(law)),
        ..Truth::of(Expected::Broken { closed: Some(true) })
    };
    let samples = random.pick(&[256, 500, 1024, 4096]);
    let h = random.between(0.4, 0.8);
    let what = format!("kick that jumps by {jump:.2}");
    of_rows(
        random,
        what,
        (1, step, h),
        Arc::new(on.circle()),
        samples,
        truth,
    )
}

fn on_integral(radii: [f64; 2]) -> f64 {
    std::f64::consts::PI * radii[0] * radii[1]
}

fn of_rows(
    random: &mut Random,
    what: String,
    (dof, step, h): (usize, Step, f64),
    on: Arc<dyn Loop>,
    samples: usize,
    truth: Truth,
) -> Member {
    let spacing = Spacing::random(random);
    Member {
        label: format!("{what}, {samples} rows, {spacing:?}"),
        subject: Subject::Samples {
            map: map_of(dof, step),
            on,
            samples,
            spacing,
            step_sizes: vec![h, h / 2.0, h / 4.0],
            rounding: Rounding::None,
        },
        truth,
    }
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(26, index);
    match index % 6 {
        5 => jumping(random),
        _ => smooth(random),
    }
}

//! Figure 8: the energy of a two-stream instability.

use std::cmp::Ordering;
use std::sync::Arc;

use rayon::prelude::*;
use serde::Serialize;
use symplint::{Ensemble, TimeAdvance};
use symplint_models::Separable;
use symplint_models::pic::{ParticleWeights, Pic1d, PicConfig, ShapeFamily, TwoStream};

use super::Item;
use super::claim::{Claim, Judgement};
use super::pic::{DEGREES, MOST_PARTICLES, SEED, STRANG};
use super::plot::{axis, series};
use super::sweep::{least_squares, step_of};
use crate::commands::Failure;
use crate::config::{Accept, Key, Section};
use crate::figure::{Figure, Panel, Scale, Style};
use crate::output::RunFolder;

pub const ITEM: Item = Item {
    id: "fig8",
    title: "two-stream instability: energy against time",
    cost: "60 s",
    keys: &[
        Key::new("particles", "10000", "number of particles"),
        Key::new("cells", "200", "cells"),
        Key::new("step_size", "0.01", "h of Strang splitting"),
        Key::new("until", "500.0", "time"),
        STRANG,
        SEED,
    ],
    run,
};

/// One moment.
#[derive(Serialize)]
struct Moment {
    degree: usize,
    time: f64,
    kinetic: f64,
    field: f64,
    energy: f64,
    energy_error: f64,
}

/// The paper's run.
const PARTICLES: usize = 10_000;
const CELLS: usize = 200;
const STEP_SIZE: f64 = 0.01;

/// Moments recorded of one run.
const MOMENTS: usize = 2000;

fn run(settings: &Section, folder: &RunFolder) -> Result<Vec<Claim>, Failure> {
    let particles = settings.whole_between("particles", 1, MOST_PARTICLES)? as usize;
    let cells = settings.whole_between("cells", 1, MOST_PARTICLES)? as usize;
    let h = settings.number("step_size", Accept::Positive)?;
    let until = settings.number("until", Accept::Positive)?;
    let steps = steps_until(settings, until, h, particles + cells)?;
    let seed = settings.whole("seed", 0)?;
    let variant = settings.choice("strang", &["position-first", "momentum-first"])?;
    // What the paper says it says of its own run, or a finer one.
    let paper = particles >= PARTICLES && cells == CELLS && h <= STEP_SIZE;
    let runs = (DEGREES.into_par_iter())
        .map(|(degree, _)| {
            let pic = Pic1d::new(PicConfig {
                weights: ParticleWeights::Equal {
                    particles,
                    density: 1.0,
                },
                cells,
                family: ShapeFamily::BSpline,
                degree,
                ..PicConfig::default()
            })?;
            let (x, v) = TwoStream::default().sample(&pic, seed)?;
            let system: Arc<dyn Separable> = Arc::new(pic);
            let map = step_of("strang", variant, &system)?;
            follow(degree, &*system, &*map, (&x, &v), h, steps)
        })
        .collect::<Result<Vec<_>, Failure>>()?;
    let mut claims = Vec::new();
    let mut panels = Vec::new();
    for ((_, name), moments) in DEGREES.into_iter().zip(&runs) {
        let errors: Vec<(f64, f64)> = moments
            .iter()
            .map(|moment| (moment.time, moment.energy_error))
            .collect();
        let drift = Drift::of(&errors);
        let claim = Claim::of_paper(
            "fig8",
            "section 5.2, figure 8",
            format!("{name} interpolation: energy is conserved well on average"),
            format!(
                "relative error {:+.1e} on average and at most {:.1e} until t = {}; its straight line rises by \
                 {:+.1e} in that time, and the error swings through {:.1e} about it",
                drift.mean,
                drift.worst,
                steps as f64 * h,
                drift.rise,
                drift.band
            ),
            drift.judgement(steps as f64 * h),
        );
        claims.push(claim.resolved_if(paper));
        panels.push(Panel {
            title: format!("{name} interpolation"),
            x: axis("time t", Scale::Linear),
            y: axis("relative energy error", Scale::Linear),
            series: vec![series("", errors, Style::Line, 0)],
            equal_aspect: false,
        });
    }
    Figure {
        title: None,
        panels,
        columns: 1,
    }
    .save(&folder.figures(), "fig8")?;
    let all: Vec<Moment> = runs.into_iter().flatten().collect();
    folder.write_csv("fig8.csv", &all)?;
    Ok(claims)
}

/// Updates of a particle or a cell at most: some two hundred times the paper's run, hours.
const MOST_UPDATES: f64 = 1e11;

/// The number of steps, if it is one that ends.
fn steps_until(
    settings: &Section,
    until: f64,
    h: f64,
    updates_per_step: usize,
) -> Result<usize, Failure> {
    let steps = (until / h).round().max(1.0);
    let most = (MOST_UPDATES / updates_per_step as f64).floor();
    // Not `steps > most`: a quotient that overflows is none either.
    if !matches!(
        steps.partial_cmp(&most),
        Some(Ordering::Less | Ordering::Equal)
    ) {
        return Err(settings
            .error(
                "until",
                format!("{steps:.3e} steps of {h} are too many"),
                format!(
                    "at most {most:.0} steps with so many particles and cells: give until = {:.4e} or less, a larger \
                     step_size, or fewer particles",
                    most * h
                ),
            )
            .into());
    }
    Ok(steps as usize)
}

/// Plasma oscillations, of period 2π/ω_p = 2π, that a run must last to say anything about drift.
const FEWEST_PERIODS: f64 = 20.0;

/// Where the energy error tends.
struct Drift {
    mean: f64,
    worst: f64,
    /// By how much its least-squares line rises over the run.
    rise: f64,
    /// Highest minus lowest distance from that line.
    band: f64,
}

impl Drift {
    fn of(errors: &[(f64, f64)]) -> Self {
        let slope = least_squares(errors);
        let range = |values: &dyn Fn(&(f64, f64)) -> f64| {
            let (low, high) = (errors.iter().map(values))
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                    (l.min(v), h.max(v))
                });
            high - low
        };
        Drift {
            mean: errors.iter().map(|p| p.1).sum::<f64>() / errors.len() as f64,
            worst: errors.iter().map(|p| p.1.abs()).fold(0.0, f64::max),
            rise: slope * range(&|p| p.0),
            band: range(&|p| p.1 - slope * p.0),
        }
    }

    /// Well on average: within a percent throughout, and no drift that stands out of the oscillations.
    fn judgement(&self, until: f64) -> Judgement {
        let periods = until / std::f64::consts::TAU;
        Judgement::of(self.worst < 1e-2 && self.rise.abs() < self.band)
            .if_resolved(periods >= FEWEST_PERIODS && self.rise.is_finite())
    }
}

/// Kinetic and field energy of one simulation, every so often.
fn follow(
    degree: usize,
    system: &dyn Separable,
    map: &dyn TimeAdvance,
    (x, v): (&[f64], &[f64]),
    h: f64,
    steps: usize,
) -> Result<Vec<Moment>, Failure> {
    let mut state = Ensemble::zeros(x.len(), 1);
    let mut block = state.block();
    for i in 0..x.len() {
        block.q.row_mut(i)[0] = x[i];
        block.p.row_mut(i)[0] = v[i];
    }
    let every = (steps / MOMENTS).max(1);
    let mut moments: Vec<Moment> = Vec::with_capacity(steps / every + 1);
    let mut initial = None;
    for step in 0..=steps {
        if step > 0 {
            state.advance(map, h)?;
        }
        if step % every == 0 {
            let (mut kinetic, mut field) = ([0.0], [0.0]);
            system.kinetic_energy(state.p(), &mut kinetic);
            system.potential_energy(state.q(), &mut field);
            let energy = kinetic[0] + field[0];
            let initial = *initial.get_or_insert(energy);
            moments.push(Moment {
                degree,
                time: step as f64 * h,
                kinetic: kinetic[0],
                field: field[0],
                energy,
                energy_error: (energy - initial) / initial,
            });
        }
    }
    Ok(moments)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(until: f64, error: impl Fn(f64) -> f64) -> Judgement {
        let moments: Vec<(f64, f64)> = (0..=2000)
            .map(|k| until * f64::from(k) / 2000.0)
            .map(|t| (t, error(t)))
            .collect();
        Drift::of(&moments).judgement(until)
    }

    #[test]
    fn oscillations_are_no_drift_and_a_drift_is_found_under_them() {
        assert_eq!(judged(500.0, |t| 1e-4 * t.sin() - 7e-5), Judgement::Holds);
        let drifting = |t: f64| 1e-4 * t.sin() + 1e-6 * t;
        assert_eq!(judged(500.0, drifting), Judgement::DoesNotHold);
        assert_eq!(judged(500.0, |t| 2e-2 * t.sin()), Judgement::DoesNotHold);
        assert_eq!(judged(10.0, |t| 1e-4 * t.sin()), Judgement::Unresolved);
    }
}

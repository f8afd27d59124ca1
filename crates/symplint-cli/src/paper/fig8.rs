//! Figure 8: the energy of a two-stream instability.

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
use super::sweep::step_of;
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

/// Moments recorded of one run.
const MOMENTS: usize = 2000;

fn run(settings: &Section, folder: &RunFolder) -> Result<Vec<Claim>, Failure> {
    let particles = settings.whole_between("particles", 1, MOST_PARTICLES)? as usize;
    let cells = settings.whole("cells", 1)? as usize;
    let h = settings.number("step_size", Accept::Positive)?;
    let steps = (settings.number("until", Accept::Positive)? / h)
        .round()
        .max(1.0) as usize;
    let seed = settings.whole("seed", 0)?;
    let variant = settings.choice("strang", &["position-first", "momentum-first"])?;
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
        let worst = errors.iter().map(|point| point.1.abs()).fold(0.0, f64::max);
        let mean = errors.iter().map(|point| point.1).sum::<f64>() / errors.len() as f64;
        claims.push(Claim {
            item: "fig8",
            place: "section 5.2, figure 8",
            says: format!("{name} interpolation: energy is conserved well on average"),
            measured: format!(
                "relative error {mean:+.1e} on average and at most {worst:.1e} until t = {}",
                steps as f64 * h
            ),
            judgement: Judgement::of(worst < 1e-2 && mean.abs() <= worst),
        });
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

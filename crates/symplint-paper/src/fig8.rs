//! Figure 8: the energy of a two-stream instability.

use std::cmp::Ordering;
use std::sync::Arc;

use rayon::prelude::*;
use serde::Serialize;
use symplint::{Ensemble, TimeAdvance};
use symplint_models::Separable;
use symplint_plasma::pic::{ParticleWeights, Pic1d, PicConfig, ShapeFamily, TwoStream};
use symplint_report::figure::{Figure, Panel, Scale, Style};
use symplint_report::plot::{axis, series};
use symplint_report::run_folder::RunFolder;

use super::claim::Claim;
use super::drift::{BLOCKS, Drift, MAX_STEADY_RISE};
use super::error::PaperError;
use super::item::Item;
use super::pic::{DEGREES, MAX_PARTICLES, SEED, STRANG};
use super::settings::{Key, SettingError, Settings};
use super::sweep::step_of;

pub const ITEM: Item = Item {
    id: "fig8",
    title: "two-stream instability: energy against time",
    cost: "12 s",
    keys: &[
        Key::whole_between(
            "particles",
            10000,
            (1, MAX_PARTICLES),
            "number of particles",
        ),
        Key::whole_between("cells", 200, (1, MAX_PARTICLES), "cells"),
        Key::positive("step_size", 0.01, "h of Strang splitting"),
        Key::positive("until", 500.0, "time"),
        STRANG,
        SEED,
    ],
    check: Some(check),
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
const END_TIME: f64 = 500.0;

/// Moments recorded of one run.
const MOMENTS: usize = 2000;

fn run(settings: &Settings, folder: &RunFolder) -> Result<Vec<Claim>, PaperError> {
    let particles = settings.count("particles");
    let cells = settings.count("cells");
    let h = settings.number("step_size");
    let steps = chosen_steps(settings)?;
    let seed = settings.whole("seed");
    let variant = settings.choice("strang");
    // The claims of the paper are about its run, or a finer one.
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
        .collect::<Result<Vec<_>, PaperError>>()?;
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
                 {:+.1e} (± {:.1e}, from {BLOCKS} block means) in that time, a drift being more than {MAX_STEADY_RISE:.0e} of the \
                 energy; field and particles exchange {:.0}% of it",
                drift.mean,
                drift.worst,
                steps as f64 * h,
                drift.rise,
                drift.error,
                100.0 * exchanged(moments)
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
    Figure::new(panels, 1).save(&folder.figures(), "fig8")?;
    let all: Vec<Moment> = runs.into_iter().flatten().collect();
    folder.write_csv("fig8.csv", &all)?;
    Ok(claims)
}

/// Most updates of a particle or a cell: some two hundred times the paper's run, hours.
const MAX_UPDATES: f64 = 1e11;

fn check(settings: &Settings) -> Result<(), SettingError> {
    chosen_steps(settings).map(|_| ())
}

fn chosen_steps(settings: &Settings) -> Result<usize, SettingError> {
    let updates_per_step = settings.count("particles") + settings.count("cells");
    let (until, h) = (settings.number("until"), settings.number("step_size"));
    steps_until(until, h, updates_per_step)
}

/// The number of steps, if it is one that ends.
fn steps_until(until: f64, h: f64, updates_per_step: usize) -> Result<usize, SettingError> {
    let steps = (until / h).round().max(1.0);
    let most = (MAX_UPDATES / updates_per_step as f64).floor();
    // Not `steps > most`: a quotient that overflows is not a valid number of steps either.
    if !matches!(
        steps.partial_cmp(&most),
        Some(Ordering::Less | Ordering::Equal)
    ) {
        // To blame is what lies farthest from the paper's run.
        let remedies = [
            (
                "until",
                until / END_TIME,
                format!("give until = {:.4e} or less", most * h),
            ),
            (
                "step_size",
                STEP_SIZE / h,
                format!("give step_size = {:.4e} or more", until / most),
            ),
            (
                "particles",
                updates_per_step as f64 / (PARTICLES + CELLS) as f64,
                "give fewer particles or cells".into(),
            ),
        ];
        let [first, rest @ ..] = &remedies;
        let (key, _, remedy) =
            (rest.iter()).fold(
                first,
                |worst, remedy| {
                    if remedy.1 > worst.1 { remedy } else { worst }
                },
            );
        return Err(SettingError::Steps {
            key,
            steps,
            step_size: h,
            remedy: format!(
                "at most {most:.1e} steps with this number of particles and cells: {remedy}"
            ),
        });
    }
    Ok(steps as usize)
}

/// The part of the energy that goes back and forth between field and particles.
fn exchanged(moments: &[Moment]) -> f64 {
    let range = (moments.iter().map(|m| m.field / m.energy))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(v), h.max(v))
        });
    range.1 - range.0
}

/// Kinetic and field energy of one simulation, every so often.
fn follow(
    degree: usize,
    system: &dyn Separable,
    map: &dyn TimeAdvance,
    (x, v): (&[f64], &[f64]),
    h: f64,
    steps: usize,
) -> Result<Vec<Moment>, PaperError> {
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

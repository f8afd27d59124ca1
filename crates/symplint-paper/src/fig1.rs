//! Figure 1: sheared loops of the nonlinear pendulum, and its energy.

use std::f64::consts::PI;
use std::sync::Arc;

use symplint::state::Rows;
use symplint::trace::Orbit;
use symplint::{Circle, Rule, Trace};
use symplint_models::systems::{Pendulum, PendulumPotential};
use symplint_models::{Hamiltonian, Separable};
use symplint_report::figure::{Figure, Panel, Scale, Style};
use symplint_report::plot::{axis, portrait, series};
use symplint_report::run_folder::RunFolder;

use super::claim::{Claim, Judgement, Origin};
use super::error::PaperError;
use super::item::Item;
use super::settings::{Key, Settings};
use super::sweep::{power_law, step_of, trend_text};

pub const ITEM: Item = Item {
    id: "fig1",
    title: "nonlinear pendulum: loops over the phase portrait, energy of an orbit",
    cost: "1 s",
    keys: &[
        Key::positive("step_size", 0.1, "h of position-first Strang splitting"),
        Key::whole("steps", 1000, 120, "steps for the energy"),
        Key::whole("samples", 2048, 3, "samples of the loop"),
    ],
    check: None,
    run,
};

/// Times, in steps, at which the loop is drawn.
const SNAPSHOTS: [usize; 4] = [0, 20, 60, 120];

/// Largest small step: the pendulum's period is above 2π.
const MAX_SMALL_STEP: f64 = 0.2;

fn run(settings: &Settings, folder: &RunFolder) -> Result<Vec<Claim>, PaperError> {
    let h = settings.number("step_size");
    let steps = settings.count("steps");
    let samples = settings.count("samples");
    let pendulum: Arc<dyn Separable> = Arc::new(Pendulum::new(PendulumPotential::Cos));
    let map = step_of("strang", "position-first", &pendulum)?;
    let circle = Circle::new(vec![PI], vec![0.5], 1.0)?;
    let energy = |q: Rows<'_>, p: Rows<'_>, out: &mut [f64]| pendulum.energy(q, p, out);
    let trace = Trace {
        rule: Rule::Pseudospectral,
        samples,
        step_size: h,
        steps,
        snapshots: SNAPSHOTS.to_vec(),
    };
    let orbit = Orbit {
        q: &[1.0],
        p: &[0.0],
        energy: &energy,
    };
    let record = trace.run(&*map, &circle, Some(orbit))?;
    folder.write_csv("fig1_energy.csv", &record.points)?;

    let mut loops = Vec::new();
    for (step, ensemble) in &record.snapshots {
        folder.write_samples(&format!("fig1_loop_{step}.csv"), ensemble)?;
        let (q, p) = (ensemble.q().row(0), ensemble.p().row(0));
        let points = q.iter().copied().zip(p.iter().copied()).collect();
        loops.push((format!("t = {}", *step as f64 * h), points));
    }
    let errors: Vec<(f64, f64)> = (record.points.iter())
        .map(|point| (point.time, point.energy_error.unwrap_or(f64::NAN)))
        .collect();
    let energy_panel = Panel {
        title: "energy from (1, 0)".into(),
        x: axis("time t", Scale::Linear),
        y: axis("relative energy error", Scale::Linear),
        series: vec![series("", errors.clone(), Style::Line, 0)],
        equal_aspect: false,
    };
    Figure::new(
        vec![
            portrait("loop around (π, ½)", &loops, Some(&energy)),
            energy_panel,
        ],
        2,
    )
    .save(&folder.figures(), "fig1")?;

    // h, h/2, h/4, h/8 over the same time; O(h^p) is about small steps.
    let mut bands = Vec::new();
    for halvings in 0..4u32 {
        let finer = Trace {
            samples: 3,
            step_size: h / f64::from(1 << halvings),
            steps: steps << halvings,
            snapshots: vec![],
            ..trace.clone()
        };
        let record = finer.run(&*map, &circle, Some(orbit))?;
        let errors = || record.points.iter().filter_map(|point| point.energy_error);
        let (low, high) = errors().fold((0.0f64, 0.0f64), |(l, h), e| (l.min(e), h.max(e)));
        bands.push((finer.step_size, high - low));
    }
    let width = power_law(&bands);

    // Bounded for ever: the second half of the time is not worse than the first.
    let worst = |part: &[(f64, f64)]| part.iter().map(|p| p.1.abs()).fold(0.0, f64::max);
    let (first, second) = errors.split_at(errors.len() / 2);
    let (first, second) = (worst(first), worst(second));
    Ok(vec![
        Claim {
            item: "fig1",
            origin: Origin::Paper,
            place: "section 3.2, figure 1b",
            says: "Strang splitting nearly conserves the energy".into(),
            measured: format!(
                "|ΔH/H| stays below {first:.1e} in the first half and {second:.1e} in the second of t ≤ {}",
                steps as f64 * h
            ),
            judgement: Judgement::of(second <= 1.05 * first && first < h * h),
        },
        Claim::of_paper(
            "fig1",
            "section 2.1",
            "the energy stays in a band of width O(h^p) about a mean value",
            format!(
                "a band of width {:.1e} with h = {h}, as {} down to h/8 (p = 2)",
                bands[0].1,
                trend_text("h", width)
            ),
            width
                .map_or(Judgement::Unresolved, |width| {
                    Judgement::of((width - 2.0).abs() < 0.1)
                })
                .if_resolved(h <= MAX_SMALL_STEP),
        ),
    ])
}

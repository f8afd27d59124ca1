//! Beyond the paper: what is conserved when linear splines break loops.
//!
//! Between the breaks the loop integral changes alike by Strang splitting and by RK2: the paper's
//! rule cannot tell them apart (section 5.2). Closing every break does, at machine precision.

use std::sync::Arc;

use serde::Serialize;
use symplint::rules::{Cutoffs, Piecewise};
use symplint::{Circle, Defect, Ensemble, LoopIntegral, Phases, Rule, TimeAdvance};
use symplint_models::Separable;
use symplint_plasma::pic::{ParticleWeights, Pic1d, PicConfig};
use symplint_report::figure::{Axis, Figure, Panel, Series, Style};
use symplint_report::plot::{error_axis, series, step_axis, uncertainty};
use symplint_report::run_folder::RunFolder;

use super::claim::{Claim, Judgement, Origin};
use super::error::PaperError;
use super::item::Item;
use super::settings::{Key, Settings};
use super::sweep::{halvings, step_of};

pub const ITEM: Item = Item {
    id: "broken-loops",
    title: "linear particle-in-cell with its breaks closed: the difference between Strang and RK2",
    cost: "4 s",
    keys: &[Key::whole_between(
        "particles",
        2,
        (1, MAX_PARTICLES),
        "number of particles in the figure",
    )],
    check: None,
    run,
};

/// Most particles of the figure: a loop of N_p particles has some 10 N_p breaks.
const MAX_PARTICLES: u64 = 1000;

/// Samples of the paper's rule.
const SAMPLES: usize = 1 << 15;

/// The step size at which more particles are examined.
const STEP_SIZE: f64 = 0.1;

const INTEGRATORS: [(&str, &str, &str); 2] = [
    ("Strang", "strang", "position-first"),
    ("RK2", "rk2", "midpoint"),
];

#[derive(Serialize)]
struct Row {
    particles: usize,
    integrator: &'static str,
    step_size: f64,
    breaks: usize,
    evaluations: usize,
    /// By the cut-off rule of the paper.
    cutoff_rule: f64,
    /// Of what is between the breaks.
    continuous: f64,
    /// With the breaks closed.
    closed: f64,
    /// The uncertainty of the estimates of the last two.
    uncertainty: f64,
}

fn run(settings: &Settings, folder: &RunFolder) -> Result<Vec<Claim>, PaperError> {
    let particles = settings.count("particles");
    let mut rows = Vec::new();
    for h in halvings(-1, -10) {
        for integrator in INTEGRATORS {
            rows.push(measure(particles, integrator, h)?);
        }
    }
    let mut more = Vec::new();
    for particles in [2, 16, 128] {
        for integrator in INTEGRATORS {
            more.push(measure(particles, integrator, STEP_SIZE)?);
        }
    }
    folder.write_csv("broken-loops.csv", &rows)?;
    folder.write_csv("broken-loops-particles.csv", &more)?;
    figure(particles, &rows).save(&folder.figures(), "broken-loops")?;
    Ok(claims(&rows, &more))
}

/// Particles spread by the golden ratio, in two streams.
fn loop_of(particles: usize) -> Result<(Arc<dyn Separable>, Circle), PaperError> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let pic = Pic1d::new(PicConfig {
        degree: 1,
        weights: ParticleWeights::Equal {
            particles,
            density: 1.0,
        },
        ..PicConfig::default()
    })?;
    let place = |a: usize| pic.length() * (0.5 + a as f64 * GOLDEN).fract();
    let velocity = |a: usize| {
        let stream = if a.is_multiple_of(2) { 3.0 } else { -3.0 };
        stream + 0.3 * (1.0 + a as f64).sin()
    };
    let x = (0..particles).map(place).collect();
    let v = (0..particles).map(velocity).collect();
    let circle = Circle::new(x, v, 1.0)?.with_phases(Phases::Equal);
    Ok((Arc::new(pic), circle))
}

fn measure(
    particles: usize,
    (integrator, name, variant): (&'static str, &str, &'static str),
    h: f64,
) -> Result<Row, PaperError> {
    let (system, circle) = loop_of(particles)?;
    let map = step_of(name, variant, &system)?;
    let rule = Rule::FiniteDifference(Cutoffs::relative(1000.0));
    let coordinates = map.capabilities().coordinates;
    let mut ensemble = Ensemble::sample(&circle, SAMPLES)?;
    let initial = LoopIntegral::in_coordinates(&ensemble, &Rule::Pseudospectral, &coordinates)?;
    ensemble.advance(&*map, h)?;
    let by_cutoffs = LoopIntegral::in_coordinates(&ensemble, &rule, &coordinates)?;
    let found = Piecewise::default().integrate(&*map, &circle, h)?;
    let continuous = Defect::between(&initial, &found.continuous)?;
    Ok(Row {
        particles,
        integrator,
        step_size: h,
        breaks: found.breaks.len(),
        evaluations: found.evaluations,
        cutoff_rule: Defect::between(&initial, &by_cutoffs)?.signed,
        continuous: continuous.signed,
        closed: Defect::between(&initial, &found.closed())?.signed,
        uncertainty: continuous.uncertainty(),
    })
}

fn figure(particles: usize, rows: &[Row]) -> Figure {
    let panel = |index: usize| {
        let (integrator, ..) = INTEGRATORS[index];
        let of = |value: fn(&Row) -> f64| -> Vec<(f64, f64)> {
            (rows.iter().filter(|row| row.integrator == integrator))
                .map(|row| (row.step_size, value(row).abs()))
                .collect()
        };
        let all: Vec<Series> = vec![
            // First, because the rule agrees with the next curve at large steps.
            series("cut-off rule", of(|row| row.cutoff_rule), Style::Points, 1),
            series(
                "between breaks",
                of(|row| row.continuous),
                Style::LineAndPoints,
                0,
            ),
            series(
                "breaks closed",
                of(|row| row.closed),
                Style::LineAndPoints,
                2,
            ),
            uncertainty(of(|row| row.uncertainty)),
        ];
        Panel {
            title: format!("{integrator}, linear splines, Nₚ = {particles}"),
            x: step_axis(),
            y: Axis {
                range: Some((1e-18, 100.0)),
                ..error_axis()
            },
            series: all,
            equal_aspect: false,
        }
    };
    Figure::new(vec![panel(0), panel(1)], 2).with_shared_legend()
}

fn claims(rows: &[Row], more: &[Row]) -> Vec<Claim> {
    let of = |name: &str| -> Vec<&Row> {
        let all = rows.iter().chain(more);
        all.filter(|row| row.integrator == name).collect()
    };
    let (strang, rk2) = (of("Strang"), of("RK2"));
    let largest = |rows: &[&Row], value: fn(&Row) -> f64| {
        rows.iter().map(|row| value(row).abs()).fold(0.0, f64::max)
    };
    let pairs = || strang.iter().zip(&rk2);
    let swept = rows.len() / 2;
    let alike = (pairs().take(swept))
        .filter(|(a, b)| (a.continuous - b.continuous).abs() < 0.1 * a.continuous.abs());
    let apart = pairs().filter(|(a, b)| b.closed.abs() > 1e3 * (a.closed.abs() + a.uncertainty));
    let (alike, apart, all) = (alike.count(), apart.count(), strang.len());
    let conserved = largest(&strang, |row| row.closed);
    vec![
        Claim {
            item: ITEM.id,
            origin: Origin::Beyond,
            place: "with section 5.2",
            says: "between the breaks Strang splitting and RK2 change the loop integral alike, up to h = ½"
                .into(),
            measured: format!(
                "within a tenth of each other at {alike} of {swept} step sizes: {:.2} and {:.2} at h = ½",
                strang[0].continuous, rk2[0].continuous
            ),
            judgement: Judgement::of(alike == swept),
        },
        Claim {
            item: ITEM.id,
            origin: Origin::Beyond,
            place: "with section 5.2",
            says: "with every break closed Strang splitting conserves the loop integral to round-off, and \
                   RK2 does not"
                .into(),
            measured: format!(
                "Strang: at most {conserved:.1e}; RK2: up to {:.1e}, more than a thousand times as much \
                 in {apart} of {all} cases",
                largest(&rk2, |row| row.closed)
            ),
            judgement: Judgement::of(conserved < 1e-12 && 4 * apart >= 3 * all),
        },
    ]
}

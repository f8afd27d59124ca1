//! Appendix B: the finite-difference rule on loops with jumps.

use std::f64::consts::{PI, TAU};

use serde::Serialize;
use symplint::{Cutoffs, Ensemble, LoopIntegral, Rule};

use super::Item;
use super::claim::{Claim, Judgement, Origin};
use super::plot::{axis, reference_slope, series};
use super::sweep::{doublings, power_law, trend_text};
use crate::commands::Failure;
use crate::config::{Accept, Key, Section};
use crate::figure::{Figure, Panel, Scale, Style};
use crate::output::RunFolder;

pub const ITEM: Item = Item {
    id: "appendix-b",
    title: "convergence of the finite-difference rule on a loop with jumps",
    cost: "1 s",
    keys: &[
        Key::new("from", "\"2^7\"", "fewest samples, made odd"),
        Key::new("to", "\"2^20\"", "most samples, made odd"),
        Key::new("cutoff", "40.0", "λ_q = λ_p"),
    ],
    run,
};

/// Jumps of q by 1 at s = 0.3 and of p by −1/2 at s = 0.8.
fn q(s: f64) -> f64 {
    (TAU * s).sin() - s + if s > 0.3 { 1.0 } else { 0.0 }
}

fn p(s: f64) -> f64 {
    1.0 + s * (1.0 - s) - if s > 0.8 { 0.5 } else { 0.0 }
}

/// ∫ p q' ds without the jumps, q' = 2π cos 2πs − 1: the smooth part of p gives
/// −1/π − 7/6, its step −½ [sin 2πs − s] from 0.8 to 1.
fn exact() -> f64 {
    -1.0 / PI - 7.0 / 6.0 - 0.5 * (-(TAU * 0.8).sin() - 0.2)
}

/// The bound of theorem 2, with L_q = 2π + 1, TV(p) = 1/2 + 1/2 + 1/2 (the jump back at s = 1 is the third) and
/// two omitted cells of |p| ≤ 5/4, one for the jump of q and two for those of p.
fn bound(samples: f64) -> f64 {
    (TAU + 1.0) / samples * (1.5 + 3.0 * 1.25)
}

#[derive(Serialize)]
struct Row {
    samples: usize,
    measured: f64,
    exact: f64,
    error: f64,
    bound: f64,
    omitted_cells: usize,
}

fn run(settings: &Section, folder: &RunFolder) -> Result<Vec<Claim>, Failure> {
    let (from, to) = (settings.whole("from", 3)?, settings.whole("to", 3)?);
    let rule = Rule::FiniteDifference(Cutoffs::relative(
        settings.number("cutoff", Accept::Positive)?,
    ));
    let mut rows = Vec::new();
    for count in doublings(from, to) {
        let samples = count | 1;
        let mut ensemble = Ensemble::zeros(1, samples);
        let mut block = ensemble.block();
        for k in 0..samples {
            let s = k as f64 / samples as f64;
            block.q.row_mut(0)[k] = q(s);
            block.p.row_mut(0)[k] = p(s);
        }
        let integral = LoopIntegral::of(&ensemble, &rule)?;
        rows.push(Row {
            samples,
            measured: integral.value,
            exact: exact(),
            error: (integral.value - exact()).abs(),
            bound: bound(samples as f64),
            omitted_cells: integral.omitted.map_or(0, |cells| cells.len()),
        });
    }
    folder.write_csv("appendix_b.csv", &rows)?;
    let errors: Vec<(f64, f64)> = rows
        .iter()
        .map(|row| (row.samples as f64, row.error))
        .collect();
    let bounds: Vec<(f64, f64)> = rows
        .iter()
        .map(|row| (row.samples as f64, row.bound))
        .collect();
    let rate = power_law(&errors);
    let below = rows.iter().all(|row| row.error <= row.bound);
    Figure {
        title: None,
        panels: vec![Panel {
            title: "finite-difference rule, jumps left out".into(),
            x: axis("samples Nₛ", Scale::Log2),
            y: axis("error of ∮ p dq", Scale::Log10),
            series: vec![
                series("error", errors.clone(), Style::LineAndPoints, 0),
                series("bound of theorem 2", bounds, Style::Line, 1),
                reference_slope(&errors, -1.0, "N"),
            ],
            equal_aspect: false,
        }],
        columns: 1,
    }
    .save(&folder.figures(), "appendix_b")?;
    Ok(vec![Claim {
        item: "appendix-b",
        origin: Origin::Paper,
        place: "appendix B, theorem 2",
        says: "with the jump cells left out the error is below L_q (TV(p) + #O ‖p‖∞)/N".into(),
        measured: format!(
            "error as {}, {} the bound at every N; {} cells left out",
            trend_text("N", rate),
            if below { "below" } else { "not below" },
            rows.last().map_or(0, |row| row.omitted_cells)
        ),
        judgement: rate.map_or(Judgement::Unresolved, |rate| {
            Judgement::of(below && (rate + 1.0).abs() < 0.1)
        }),
    }])
}

//! Appendix B: the finite-difference rule on loops with jumps.

use std::f64::consts::{PI, TAU};

use serde::Serialize;
use symplint::rules::{Cutoff, Cutoffs};
use symplint::{Ensemble, LoopIntegral, Rule};
use symplint_report::figure::{Figure, Panel, Scale, Style};
use symplint_report::plot::{axis, reference_slope, series};
use symplint_report::run_folder::RunFolder;

use super::claim::{Claim, Judgement, Origin};
use super::error::PaperError;
use super::item::Item;
use super::settings::{Key, Settings};
use super::sweep::{doublings, power_law, trend_text};

pub const ITEM: Item = Item {
    id: "appendix-b",
    title: "convergence of the finite-difference rule on a loop with jumps",
    cost: "1 s",
    keys: &[
        Key::whole("from", 1 << 7, 3, "fewest samples, made odd"),
        Key::whole("to", 1 << 20, 3, "most samples, made odd"),
        Key::positive("cutoff", 40.0, "λ_q = λ_p"),
    ],
    check: None,
    run,
};

/// Jumps of q by 1 at s = 0.3 and of p by −1/2 at s = 0.8.
pub(super) fn q(s: f64) -> f64 {
    (TAU * s).sin() - s + if s > 0.3 { 1.0 } else { 0.0 }
}

pub(super) fn p(s: f64) -> f64 {
    1.0 + s * (1.0 - s) - if s > 0.8 { 0.5 } else { 0.0 }
}

/// ∫ p q' ds without the jumps, q' = 2π cos 2πs − 1: the smooth part of p gives
/// −1/π − 7/6, its step −½ [sin 2πs − s] from 0.8 to 1.
pub(super) fn exact() -> f64 {
    -1.0 / PI - 7.0 / 6.0 - 0.5 * (-(TAU * 0.8).sin() - 0.2)
}

/// The bound of theorem 2, with L_q = 2π + 1, TV(p) = 1/2 + 1/2 + 1/2 (the jump back at s = 1 is the third) and
/// two omitted cells of |p| ≤ 5/4, one for the jump of q and two for those of p.
pub(super) fn bound(samples: f64) -> f64 {
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

fn run(settings: &Settings, folder: &RunFolder) -> Result<Vec<Claim>, PaperError> {
    let (from, to) = (settings.whole("from"), settings.whole("to"));
    let rule = Rule::FiniteDifference(Cutoffs::relative(settings.number("cutoff")));
    let mut rows = Vec::new();
    for count in doublings(from, to) {
        let samples = count | 1;
        let integral = integral(samples, &rule)?;
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
    Figure::new(
        vec![Panel {
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
        1,
    )
    .save(&folder.figures(), "appendix_b")?;
    let [detected, q_kept, p_kept] = detection(settings.number("cutoff"))?;
    Ok(vec![
        Claim {
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
        },
        detected,
        q_kept,
        p_kept,
    ])
}

/// The integral of the loop from `samples` samples.
fn integral(samples: usize, rule: &Rule) -> Result<LoopIntegral, PaperError> {
    let mut ensemble = Ensemble::zeros(1, samples);
    let mut block = ensemble.block();
    for k in 0..samples {
        let s = k as f64 / samples as f64;
        block.q.row_mut(0)[k] = q(s);
        block.p.row_mut(0)[k] = p(s);
    }
    Ok(LoopIntegral::of(&ensemble, rule)?)
}

/// Judges the number of samples from which jumps are found, and what jumps do that are not.
fn detection(lambda: f64) -> Result<[Claim; 3], PaperError> {
    const JUMPS: usize = 3;
    const MAX_SAMPLES: usize = 4001;
    let claim = |says: &str, measured, judgement| {
        Claim::of_paper("appendix-b", "appendix B", says, measured, judgement)
    };
    // N > (τ + M)/δ, with ‖q‖∞ and ‖p‖∞ from a fine grid; M and δ of q are 2π + 1 and 1, of p 1 and ½.
    let largest = |f: fn(f64) -> f64| {
        (0..10_000)
            .map(|k| f(f64::from(k) / 1e4).abs())
            .fold(0.0, f64::max)
    };
    let (tau_q, tau_p) = (lambda * largest(q), lambda * largest(p));
    let enough = (tau_q + TAU + 1.0).max((tau_p + 1.0) / 0.5);
    let rule = Rule::FiniteDifference(Cutoffs::relative(lambda));
    let mut last_miss = 0;
    for samples in (11..MAX_SAMPLES).step_by(2) {
        let omitted = integral(samples, &rule)?
            .omitted
            .map_or(0, |cells| cells.len());
        if omitted != JUMPS {
            last_miss = samples;
        }
    }
    let detected = claim(
        "jump detection is reliable once N > (τ + M)/δ",
        format!(
            "that is N > {enough:.0} here; of the odd numbers up to {MAX_SAMPLES} the last to miss a jump is {last_miss}"
        ),
        Judgement::of((last_miss as f64) <= enough)
            .if_resolved(tau_q > TAU + 1.0 && tau_p > 1.0 && 2.0 * enough < MAX_SAMPLES as f64),
    );
    let kept = |q: Cutoff, p: Cutoff| -> Result<Vec<(f64, f64)>, PaperError> {
        let rule = Rule::FiniteDifference(Cutoffs { q, p });
        (9..=17)
            .map(|m| {
                let samples = (1usize << m) + 1;
                let error = (integral(samples, &rule)?.value - exact()).abs();
                Ok((samples as f64, error))
            })
            .collect()
    };
    let (all, found) = (Cutoff::Absolute(f64::INFINITY), Cutoff::Absolute(50.0));
    let with_q = kept(all, all)?;
    let with_p = kept(found, all)?;
    let last = |curve: &[(f64, f64)]| curve.last().map_or(f64::NAN, |point| point.1);
    let (rate_q, rate_p) = (power_law(&with_q), power_law(&with_p));
    Ok([
        detected,
        claim(
            "a jump of q that is not left out costs O(1)",
            format!(
                "error {:.2} with 2^17 samples, as {}",
                last(&with_q),
                trend_text("N", rate_q)
            ),
            rate_q.map_or(Judgement::Unresolved, |rate| {
                Judgement::of(rate.abs() < 0.1)
            }),
        ),
        claim(
            "a jump of p alone that is not left out keeps to first order",
            format!(
                "error {:.1e} with 2^17 samples, as {}",
                last(&with_p),
                trend_text("N", rate_p)
            ),
            rate_p.map_or(Judgement::Unresolved, |rate| {
                Judgement::of((rate + 1.0).abs() < 0.1)
            }),
        ),
    ])
}

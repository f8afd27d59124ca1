//! Section 4.2: where |q| breaks the loop, and what many steps add up to.
//!
//! Every step breaks the loop anew, and every jump of 2h in p that is left behind continues to widen in q by
//! 2h² a step, which the integral without the jumps misses: n steps miss O(n²h²), not O(nh²).

use serde::Serialize;
use symplint::diagnosis::SampleCount;
use symplint::rules::Cutoffs;
use symplint::trace::TracePoint;
use symplint::{Circle, Diagnostic, Rule, TimeAdvance, Trace};
use symplint_report::run_folder::RunFolder;

use super::claim::{Claim, Judgement};
use super::error::PaperError;
use super::sweep::{halvings, power_law, trend_text};

/// A splitting with its name.
pub type NamedMap = (String, Box<dyn TimeAdvance>);

/// The time T of the runs, and the finest step size, 2^-6, whose jumps of h² still stand out of the samples.
const TIME: f64 = 1.0;
const FINEST: i32 = -6;

#[derive(Serialize)]
struct Row {
    integrator: String,
    step_size: f64,
    steps: usize,
    time: f64,
    signed_defect: f64,
}

/// Judges that defects of O(h²) in one step add up to O(nh²).
pub fn accumulated(
    maps: &[NamedMap],
    circle: &Circle,
    cutoffs: Cutoffs,
    samples: usize,
    folder: &RunFolder,
) -> Result<Claim, PaperError> {
    let mut rows = Vec::new();
    let mut texts = Vec::new();
    let mut rates = Vec::new();
    for (name, map) in maps {
        let step_sizes = halvings(-2, FINEST);
        let mut of_map: Vec<Row> = Vec::new();
        for &step_size in &step_sizes {
            of_map.extend(steps((name, &**map), circle, cutoffs, samples, step_size)?);
        }
        let finest = step_sizes.last().copied().unwrap_or(TIME);
        let at_end: Vec<(f64, f64)> = (of_map.iter())
            .filter(|row| row.time == TIME)
            .map(|row| (row.step_size, row.signed_defect.abs()))
            .collect();
        let in_steps: Vec<(f64, f64)> = (of_map.iter())
            // The first steps have their own closed forms.
            .filter(|row| row.step_size == finest && row.steps >= 4)
            .map(|row| (row.steps as f64, row.signed_defect.abs()))
            .collect();
        let (of_h, of_n) = (power_law(&at_end), power_law(&in_steps));
        texts.push(format!(
            "{name}: {:+.2e} after T = {TIME} with h = 2^{FINEST}, as {} at fixed T and {} at fixed h",
            of_map.last().map_or(f64::NAN, |row| row.signed_defect),
            trend_text("h", of_h),
            trend_text("n", of_n)
        ));
        rates.push(of_h);
        rows.extend(of_map);
    }
    folder.write_csv("closed_forms_accumulated.csv", &rows)?;
    let known: Vec<f64> = rates.iter().copied().flatten().collect();
    Ok(Claim::of_paper(
        "closed-forms",
        "section 4.2",
        "one-step defects of O(h²) may add up to O(nh²), which is O(Th) over a fixed time",
        texts.join("; "),
        Judgement::of(
            // None piles up faster, and one does as fast as that.
            known.iter().all(|rate| *rate > 0.8)
                && known.iter().any(|rate| (rate - 1.0).abs() < 0.2),
        )
        .if_resolved(known.len() == maps.len() && samples >= 1 << 18),
    ))
}

/// The defects of all steps of one size up to [`TIME`].
fn steps(
    (name, map): (&str, &dyn TimeAdvance),
    circle: &Circle,
    cutoffs: Cutoffs,
    samples: usize,
    step_size: f64,
) -> Result<Vec<Row>, PaperError> {
    let trace = Trace {
        rule: Rule::FiniteDifference(cutoffs),
        samples,
        step_size,
        steps: (TIME / step_size).round() as usize,
        snapshots: vec![],
    };
    let record = trace.run(map, circle, None)?;
    let row = |point: &TracePoint| Row {
        integrator: name.to_owned(),
        step_size,
        steps: point.step,
        time: point.time,
        signed_defect: point.signed_defect,
    };
    Ok(record.points.iter().skip(1).map(row).collect())
}

/// Judges where the first step breaks the loop: on the line q + c h p = 0.
pub fn break_line(
    (name, map): &NamedMap,
    circle: &Circle,
    line: &'static str,
    c: f64,
) -> Result<Claim, PaperError> {
    let diagnostic = Diagnostic {
        rule: Rule::FiniteDifference(Cutoffs::none()),
        samples: SampleCount::Fixed(1023),
        step_sizes: halvings(0, -6),
        loops: 1,
        ..Diagnostic::default()
    };
    let diagnosis = diagnostic.run(&**map, circle)?;
    // One break at most for each step size, in the order of these.
    let found = diagnosis.evidence.breaks.len();
    let off = (diagnosis.evidence.breaks.iter().zip(&diagnostic.step_sizes))
        .map(|(found, h)| {
            let (q, p) = (found.found.s * std::f64::consts::TAU).sin_cos();
            (q + c * h * p).abs()
        })
        .fold(0.0, f64::max);
    Ok(Claim::of_paper(
        "closed-forms",
        "section 4.2",
        format!("{name} breaks the loop where {line}"),
        format!(
            "breaks followed at {found} of 7 step sizes from 1 to 2^-6, off that line by at most {off:.0e}"
        ),
        Judgement::of(off < 1e-11).if_resolved(found == diagnostic.step_sizes.len()),
    ))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use symplint::rules::Cutoff;
    use symplint_models::Separable;
    use symplint_models::systems::AbsoluteValue;

    use super::super::sweep::step_of;
    use super::*;

    /// The jumps of the exact flow for h → 0: a state that crosses q = 0 upwards at time t from
    /// (q0, p0) on the circle ends with p = p0 + 2t − T between jumps that fill the width 2(T − t) dt of q;
    /// the same again downwards.
    fn missed() -> f64 {
        const N: i32 = 2000;
        let at = |t: f64| {
            // (p0 t + t²/2)² + p0² = 1.
            let (a, b, c) = (1.0 + t * t, t.powi(3), t.powi(4) / 4.0 - 1.0);
            let p0 = (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
            (p0 + 2.0 * t - TIME) * 2.0 * (TIME - t)
        };
        let sum: f64 = (0..N)
            .map(|k| at(TIME * (f64::from(k) + 0.5) / f64::from(N)))
            .sum();
        2.0 * sum * TIME / f64::from(N) / std::f64::consts::PI
    }

    #[test]
    fn defects_add_up_to_what_the_widened_jumps_hold() {
        let circle = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
        let sharp: Arc<dyn Separable> = Arc::new(AbsoluteValue::new(0.0).unwrap());
        let cutoffs = Cutoffs {
            q: Cutoff::Absolute(50.0),
            p: Cutoff::Absolute(f64::INFINITY),
        };
        let map = step_of("strang", "position-first", &sharp).unwrap();
        let rows = steps(("strang", &*map), &circle, cutoffs, 1 << 16, 2f64.powi(-4)).unwrap();
        let measured = rows.last().unwrap().signed_defect;
        assert!(
            (measured / missed() - 1.0).abs() < 0.05,
            "{measured} {}",
            missed()
        );
    }
}

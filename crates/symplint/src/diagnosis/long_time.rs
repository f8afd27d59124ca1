//! Many steps: does a defect stay bounded, or does it grow?
//!
//! A method that is conjugate to a symplectic one, Φ = χ⁻¹ ∘ Ψ ∘ χ, changes loop integrals in every
//! step, but n steps change them no more than one: Φⁿ = χ⁻¹ ∘ Ψⁿ ∘ χ. Its defect wanders and returns. That
//! of other methods adds up (HLW, chapter VI.8, on conjugate symplecticity).

use serde::Serialize;

use super::probe::{Method, Probe};
use super::streamed::fits;
use crate::error::Error;
use crate::rules::Rule;
use crate::trace::{Trace, TracePoint};
use crate::verdict::Verdict;

/// What becomes of a defect in many steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Growth {
    /// No step shows a defect of 1e-11 or more.
    None,
    /// It stays of one size and returns: the method may be conjugate to a symplectic one.
    Bounded,
    /// It adds up.
    Grows,
    /// The steps that the samples resolve do not tell.
    Undecided,
}

/// The given loop after many steps of the largest size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LongTime {
    /// Step size h.
    pub step_size: f64,
    /// Steps that the samples resolve; from there on the loop is too folded.
    pub steps: usize,
    /// What becomes of the defect.
    pub growth: Growth,
    /// Largest |E| of the first quarter of the steps.
    pub early: f64,
    /// Largest |E| of the last quarter.
    pub late: f64,
    /// Smallest |E| of the second half.
    pub least: f64,
}

/// Steps below which nothing is said.
const FEWEST: usize = 16;

/// A quadrature error above this part of the largest defect so far ends the trace.
const RESOLVED: f64 = 0.1;

/// A defect that adds up is four times as large in the last quarter as in the first.
const GROWN: f64 = 2.5;

/// One that stays of one size varies by less than this.
const STAYED: f64 = 1.8;

/// It returns to this part of its largest value.
const RETURNS: f64 = 0.5;

/// Follows the loop of a probe, and adds what it says to the evidence. A probe that streams because its samples
/// do not fit into memory cannot be followed: `None`, with a line that says so.
pub(super) fn follow(
    probe: &Probe<'_>,
    h: f64,
    steps: usize,
    verdict: &mut Verdict,
) -> Result<Option<LongTime>, Error> {
    let dof = probe.subject.phase_loop.dof();
    // A loop folds: what one step resolves, many do not.
    let samples = probe.samples().max(FOLDED / dof.max(1));
    if matches!(probe.method, Method::Streaming(..)) && !fits(dof, samples) {
        let line =
            format!("Many steps were left out: {samples} samples would have to stay in memory.");
        verdict.evidence.push(line);
        return Ok(None);
    }
    let trace = Trace {
        rule: Rule::Pseudospectral,
        samples,
        step_size: h,
        steps,
        snapshots: Vec::new(),
    };
    let record = trace.run_with(
        probe.subject.evaluator,
        probe.subject.phase_loop,
        None,
        &|_| {},
    )?;
    let found = judge(h, &record.points[1..]);
    verdict.evidence.push(found.to_string());
    Ok(Some(found))
}

/// Samples of a loop of one degree of freedom at least.
const FOLDED: usize = 1 << 13;

fn judge(h: f64, points: &[TracePoint]) -> LongTime {
    let mut largest = 0.0f64;
    let resolved = points.iter().take_while(|point| {
        largest = largest.max(point.defect);
        (point.quadrature_error).is_some_and(|error| error <= (RESOLVED * largest).max(1e-12))
    });
    let defects: Vec<f64> = resolved.map(|point| point.defect).collect();
    let max = |part: &[f64]| part.iter().copied().fold(0.0, f64::max);
    let n = defects.len();
    let early = max(&defects[..n / 4]);
    let late = max(&defects[n - n / 4..]);
    let least = defects[n / 2..]
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min);
    let growth = if n < FEWEST {
        Growth::Undecided
    } else if max(&defects) < 1e-11 {
        Growth::None
    } else if late > GROWN * early {
        Growth::Grows
    } else if late < STAYED * early && least < RETURNS * max(&defects) {
        Growth::Bounded
    } else {
        Growth::Undecided
    };
    LongTime {
        step_size: h,
        steps: n,
        growth,
        early,
        late,
        least: if least.is_finite() { least } else { 0.0 },
    }
}

impl std::fmt::Display for LongTime {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let LongTime {
            steps,
            early,
            late,
            least,
            ..
        } = self;
        match self.growth {
            Growth::None => write!(f, "No defect adds up in {steps} steps."),
            Growth::Bounded => write!(
                f,
                "In {steps} steps the defect stays bounded, {early:.1e} at first and {late:.1e} at last, and \
                 returns to {least:.1e}: as that of a method conjugate to a symplectic one."
            ),
            Growth::Grows => write!(
                f,
                "In {steps} steps the defect adds up, from {early:.1e} in the first quarter to {late:.1e} in \
                 the last."
            ),
            Growth::Undecided => write!(
                f,
                "The samples resolve {steps} steps, which do not tell whether the defect adds up: take a \
                 smaller loop or more samples."
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grown(law: impl Fn(f64) -> f64, steps: usize) -> Growth {
        let points: Vec<TracePoint> = (1..=steps)
            .map(|step| TracePoint {
                step,
                time: step as f64,
                integral: 1.0,
                signed_defect: law(step as f64),
                defect: law(step as f64).abs(),
                quadrature_error: Some(1e-14),
                energy: None,
                energy_error: None,
            })
            .collect();
        judge(1.0, &points).growth
    }

    #[test]
    fn what_wanders_is_told_from_what_adds_up() {
        assert_eq!(grown(|n| 1e-3 * (0.37 * n).sin(), 200), Growth::Bounded);
        assert_eq!(
            grown(|n| 1e-3 * (1.0 - (0.37 * n).cos()), 200),
            Growth::Bounded
        );
        assert_eq!(grown(|n| 1e-5 * n, 200), Growth::Grows);
        assert_eq!(
            grown(|n| 1e-4 * (0.37 * n).sin() + 1e-5 * n, 400),
            Growth::Grows
        );
        assert_eq!(grown(|_| 1e-15, 200), Growth::None);
        assert_eq!(grown(|n| 1e-5 * n, 10), Growth::Undecided);
    }
}

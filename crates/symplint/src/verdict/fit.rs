//! The order of a defect.

use serde::Serialize;

use super::LoopEvidence;

/// A power law |quantity| ~ against^slope over a range.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fit {
    /// What was fitted.
    pub quantity: &'static str,
    /// Against what.
    pub against: &'static str,
    /// Which loop.
    #[serde(rename = "loop")]
    pub loop_index: usize,
    /// Exponent.
    pub slope: f64,
    /// Half the spread of the slopes between neighbouring points.
    pub uncertainty: f64,
    /// Smallest abscissa used.
    pub from: f64,
    /// Largest abscissa used.
    pub to: f64,
}

impl Fit {
    /// The order that the slope stands for: the whole number within 0.15, else the slope itself to
    /// two decimals.
    pub fn order(&self) -> f64 {
        let whole = self.slope.round();
        if (self.slope - whole).abs() <= 0.15 {
            whole
        } else {
            (self.slope * 100.0).round() / 100.0
        }
    }
}

/// Points of a fit at most: those of the smallest steps, where the leading term rules.
const MOST_POINTS: usize = 4;

/// A defect must exceed its uncertainty by this factor to fix a slope.
const CLEAR: f64 = 50.0;

/// Fits the defect's power of h where it is clear of its uncertainty and keeps its sign, at the
/// smallest such steps. `None` with fewer than two clear points.
pub(super) fn fit_order(evidence: &LoopEvidence) -> Option<Fit> {
    let mut clear: Vec<(f64, f64)> = (evidence.steps.iter())
        .filter(|step| step.defect.magnitude() > CLEAR * step.defect.uncertainty())
        .map(|step| (step.step_size.abs(), step.defect.signed))
        .collect();
    clear.sort_by(|a, b| a.0.total_cmp(&b.0));
    clear.dedup_by(|a, b| a.0 == b.0);
    let sign = clear.first()?.1.signum();
    let points: Vec<(f64, f64)> = (clear.into_iter())
        .take_while(|point| point.1.signum() == sign)
        .take(MOST_POINTS)
        .map(|(h, defect)| (h.ln(), defect.abs().ln()))
        .collect();
    if points.len() < 2 {
        return None;
    }
    let local: Vec<f64> = (points.windows(2))
        .map(|w| (w[1].1 - w[0].1) / (w[1].0 - w[0].0))
        .collect();
    let (low, high) = local
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &s| {
            (l.min(s), h.max(s))
        });
    // The smallest steps are nearest to the limit: its slope is what the two lowest say.
    Some(Fit {
        quantity: "defect",
        against: "step_size",
        loop_index: evidence.index,
        slope: local[0],
        uncertainty: (high - low) / 2.0,
        from: points[0].0.exp(),
        to: points[points.len() - 1].0.exp(),
    })
}

//! Flat records of what was measured, as tables and reports show them.

use serde::{Deserialize, Serialize};

use super::StepEvidence;
use crate::breaks::Break;
use crate::rules::RuleKind;

/// Which sweep a point belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sweep {
    /// Over the step size h.
    StepSize,
    /// Over the number of samples N_s.
    Samples,
}

/// The loop integral before and after one step of size h.
///
/// `initial` and `advanced` are loop integrals; defects and errors are relative to |`initial`|.
/// A quantity that a rule does not give is `None`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Point {
    /// The sweep.
    pub sweep: Sweep,
    /// Which loop: 0 is the given one, the others are random.
    #[serde(rename = "loop")]
    pub loop_index: usize,
    /// Step size h; NaN (in reports `null`) if it was not stated.
    pub step_size: f64,
    /// Samples N_s; by the piecewise rule, the states that make up the integral.
    pub samples: usize,
    /// The rule.
    pub rule: RuleKind,
    /// I(0).
    pub initial: f64,
    /// I(h); of a broken loop the absolutely continuous part, as far as the rule gives it.
    #[serde(rename = "final")]
    pub advanced: f64,
    /// (I(h) − I(0)) / |I(0)|.
    pub signed_defect: f64,
    /// |I(h) − I(0)| / |I(0)|.
    pub defect: f64,
    /// Estimate of the quadrature error of both integrals, relative to |I(0)|.
    pub quadrature_error: Option<f64>,
    /// Round-off of both integrals, relative to |I(0)|.
    pub roundoff: f64,
    /// Cells that the finite-difference rule left out of the advanced loop, over all degrees of freedom.
    pub omitted_cells: Option<usize>,
    /// Breaks of the advanced loop.
    pub jumps: Option<usize>,
    /// Contribution of the segments that close the breaks.
    pub chord: Option<f64>,
    /// |E| of the integral whose breaks are closed.
    pub closed_defect: Option<f64>,
    /// How smooth the advanced loop is, by the decay of the Fourier coefficients of its samples: the Sobolev
    /// exponent s of H^s, about ½ at jumps and 3/2 at kinks. If the coefficients fall to round-off, it is a
    /// lower bound.
    pub regularity: Option<f64>,
    /// States that the map advanced for this point.
    pub evaluations: usize,
}

impl Point {
    /// The record of a step of a loop.
    pub(crate) fn new(sweep: Sweep, loop_index: usize, step: &StepEvidence) -> Self {
        let breaks = (step.jumping.map(|jumping| jumping.confirmed))
            .or(step.closing.map(|closing| closing.breaks));
        Point {
            sweep,
            loop_index,
            step_size: step.step_size.unwrap_or(f64::NAN),
            samples: step.samples,
            rule: step.rule,
            initial: step.initial,
            advanced: step.advanced,
            signed_defect: step.defect.signed,
            defect: step.defect.magnitude(),
            quadrature_error: step.defect.quadrature_error,
            roundoff: step.defect.roundoff,
            omitted_cells: step.omitted_cells,
            jumps: breaks,
            chord: step.closing.map(|closing| closing.chord),
            closed_defect: step.closing.map(|closing| closing.closed.magnitude()),
            regularity: step.regularity,
            evaluations: step.evaluations,
        }
    }
}

/// A break, and the advanced loop that has it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoopBreak {
    /// Which loop: 0 is the given one, the others are random.
    #[serde(rename = "loop")]
    pub loop_index: usize,
    /// Step size h; `None` if it was not stated.
    pub step_size: Option<f64>,
    /// Its place and the jumps of the coordinates.
    #[serde(flatten)]
    pub found: Break,
}

//! One measured point of a sweep, as reports carry it.

use serde::Serialize;

use super::probe::{Measured, Probe};

/// Which sweep a point belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
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
/// What a rule does not give is `None`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// The sweep.
    pub sweep: Sweep,
    /// Which loop: 0 is the given one, the others are random.
    #[serde(rename = "loop")]
    pub loop_index: usize,
    /// Step size h.
    pub step_size: f64,
    /// Samples N_s; by the piecewise rule, the states that make up the integral.
    pub samples: usize,
    /// Name of the rule.
    pub rule: &'static str,
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
    /// exponent s of H^s, about ½ at jumps and 3/2 at kinks. Where the coefficients fall to round-off it is a
    /// lower bound.
    pub regularity: Option<f64>,
    /// Single states that make up this point: those that the map had to advance, the search for breaks
    /// aside.
    pub evaluations: usize,
}

impl Point {
    pub(super) fn new(sweep: Sweep, probe: &Probe<'_>, h: f64, measured: &Measured) -> Self {
        let defect = &measured.defect;
        Point {
            sweep,
            loop_index: probe.index,
            step_size: h,
            samples: measured.samples,
            rule: probe.rule_name(),
            initial: probe.initial.value,
            advanced: measured.integral.value,
            signed_defect: defect.signed,
            defect: defect.magnitude(),
            quadrature_error: defect.quadrature_error,
            roundoff: defect.roundoff,
            omitted_cells: measured.integral.omitted.as_ref().map(Vec::len),
            jumps: measured.closing.map(|closing| closing.breaks),
            chord: measured.closing.map(|closing| closing.chord),
            closed_defect: (measured.closing).map(|closing| closing.closed.magnitude()),
            regularity: measured.regularity,
            evaluations: measured.evaluations,
        }
    }
}

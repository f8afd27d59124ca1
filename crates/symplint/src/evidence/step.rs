//! What one step of one loop showed.

use serde::{Deserialize, Serialize};

use super::Motion;
use crate::breaks::Break;
use crate::rules::{Defect, RuleKind};
use crate::signal::{SIGNIFICANT, UNEXPLAINED};

/// The loop integral before and after one step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StepEvidence {
    /// Step size h; `None` if it was not stated.
    pub step_size: Option<f64>,
    /// Samples N_s; by the piecewise rule, the states that make up the integral.
    pub samples: usize,
    /// The rule.
    pub rule: RuleKind,
    /// I(0).
    pub initial: f64,
    /// I(h); of a broken loop the absolutely continuous part, as far as the rule gives it.
    pub advanced: f64,
    /// Change of the loop integral.
    pub defect: Defect,
    /// The largest break of the advanced loop that is known.
    pub jump: Option<Break>,
    /// What closing the breaks gives, if all of them are known.
    pub closing: Option<ClosedBreaks>,
    /// Those of its breaks at which rounding decides on which side of them a state is.
    #[serde(default)]
    pub flickering: usize,
    /// What jumps of the size of the largest break could change the integral by, relative as the defect is: of each break,
    /// |Δq| times half the range of p and |Δp| times half the range of q. 0 without a break.
    #[serde(default)]
    pub reach_of_jumps: f64,
    /// Cells that jump, for samples that cannot be looked at in between.
    pub jumping: Option<JumpingCells>,
    /// A position that jumps by its whole range, as one in a periodic box does.
    pub wrap: Option<Wrap>,
    /// Cells that the finite-difference rule left out of the advanced loop, over all degrees of freedom.
    pub omitted_cells: Option<usize>,
    /// Cells of the map's grid, or half periods of a position, between neighbouring samples at most; 0 for a
    /// map with neither.
    pub cells_apart: f64,
    /// Sobolev exponent of the advanced loop: about ½ at jumps and 3/2 at kinks.
    pub regularity: Option<f64>,
    /// Whether the loop has a feature that is narrower than the distance of its samples.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub has_feature: bool,
    /// How the step moves the loop: of a map, at the largest step size.
    pub motion: Option<Motion>,
    /// States that the map advanced for this point.
    pub evaluations: usize,
}

/// A loop whose breaks are closed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClosedBreaks {
    /// Breaks.
    pub breaks: usize,
    /// The contribution of the closing segments to the loop integral.
    pub chord: f64,
    /// Change of the closed loop integral.
    pub closed: Defect,
    /// What curves other than straight segments could contribute where the breaks begin, relative as the defect is: the
    /// products of the jumps in q and in p. A closed integral that changes by not much more does not count as evidence.
    #[serde(default)]
    pub bend: f64,
    /// Whether the closing segments are straight after the whole step, as its substeps are not known: a step may bend
    /// what closes a break.
    #[serde(default)]
    pub straight: bool,
}

/// Cells of a sampled loop in which a coordinate jumps, as far as samples can tell.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JumpingCells {
    /// Cells that look like jumps.
    pub cells: usize,
    /// Those of them that keep their size from every fourth to every sample.
    pub confirmed: usize,
    /// The largest confirmed jump, as a part of the range of its coordinate; 0 if none is confirmed.
    pub largest: f64,
}

/// A position that jumps by its whole range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wrap {
    /// Degree of freedom.
    pub dof: usize,
    /// The range, which a period would have to be.
    pub period: f64,
}

/// Samples further apart than this many cells of the map's grid, or half periods, do not resolve them: what
/// they show is not the map. Nyquist's limit: two samples to a cell.
pub(crate) const MAX_CELLS_BETWEEN_SAMPLES: f64 = 0.5;

/// A bound on the defect above this is too weak to call a map symplectic. Conventional: single precision
/// gives bounds of 1e-7 and should pass.
pub(crate) const MAX_BOUND_ON_DEFECT: f64 = 1e-6;

impl ClosedBreaks {
    /// Whether the closed integral changes, however the breaks are closed: what other curves than straight segments could
    /// make is a part of its uncertainty then.
    pub fn is_changed(&self) -> bool {
        // Of a step without substeps, the curve that closes a break is not known.
        !self.straight
            && self.closed.magnitude() > SIGNIFICANT * (self.closed.uncertainty() + self.bend)
    }
}

impl StepEvidence {
    /// Whether the samples are too far apart to resolve the grid of the map, or a period.
    pub fn misses_the_grid(&self) -> bool {
        self.cells_apart > MAX_CELLS_BETWEEN_SAMPLES
    }

    /// Whether the defect is significant.
    pub fn is_significant(&self) -> bool {
        !self.misses_the_grid() && self.defect.magnitude() > SIGNIFICANT * self.defect.uncertainty()
    }

    /// Whether the defect is more than its uncertainty explains.
    pub fn is_unexplained(&self) -> bool {
        self.defect.magnitude() > UNEXPLAINED * self.defect.uncertainty()
    }

    /// The largest defect that the step may have.
    pub fn bound(&self) -> f64 {
        self.defect.magnitude() + self.defect.uncertainty()
    }

    /// Whether it bounds the defect well enough to call a map symplectic.
    pub fn is_bounded(&self) -> bool {
        // Not `bound > …`: a bound that is not a number is not valid.
        matches!(self.bound(), 0.0..=MAX_BOUND_ON_DEFECT)
    }
}

//! The verdict: what the defects say, and when they say nothing.
//!
//! A symplectic map conserves the loop integral of every closed loop exactly, at every step
//! size. So one defect beyond all doubt is proof that a map is not symplectic, and so is one
//! break; the absence of both, however, only bounds the defect for the loops and steps
//! that were tried.

mod fit;
mod jacobian;
mod judge;
mod words;

pub use fit::Fit;
pub(crate) use fit::fit_order;
pub use jacobian::{
    Agreement, Inconclusive, JacobianFinding, JacobianVerdict, compare_jacobian, judge_jacobian,
};
pub use judge::judge;
pub(crate) use judge::{LEAST_DEFORMATION, SMALL, TREND};
pub(crate) use words::{capitalised, short, size};

use serde::Serialize;

use crate::breaks::Break;
use crate::error::Error;
use crate::rules::Defect;

/// The four answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum VerdictKind {
    /// No defect was found, down to the stated number of digits.
    Symplectic,
    /// The map is discontinuous: it breaks loops.
    BrokenLoops,
    /// The loop integral changes beyond all doubt.
    NotSymplectic,
    /// The numbers do not decide.
    Undecided,
}

impl std::fmt::Display for VerdictKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            VerdictKind::Symplectic => "symplectic",
            VerdictKind::BrokenLoops => "broken-loops",
            VerdictKind::NotSymplectic => "not-symplectic",
            VerdictKind::Undecided => "undecided",
        })
    }
}

/// A verdict with the numbers that led to it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The answer.
    pub kind: VerdictKind,
    /// Digits to which the loop integral is conserved, where the verdict is symplectic.
    pub digits: Option<f64>,
    /// k of defect ~ h^k, where the defects have a trend that is a whole number within its uncertainty or 0.15.
    pub order: Option<f64>,
    /// One sentence.
    pub summary: String,
    /// The numbers behind it.
    pub evidence: Vec<String>,
    /// What to do next.
    pub advice: Vec<String>,
}

impl Verdict {
    /// The answer in a few words: `symplectic to 14.2 digits`, `not-symplectic, defect of order h^3`.
    pub fn headline(&self) -> String {
        let mut text = self.kind.to_string();
        if let Some(digits) = self.digits {
            text += &format!(" to {digits} digits");
        }
        if let Some(order) = self.order {
            text += &format!(", defect of order h^{order}");
        }
        text
    }
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.headline(), self.summary)
    }
}

/// What one loop showed.
#[derive(Clone, Debug)]
pub struct LoopEvidence {
    /// 0 is the given loop, the others are random.
    pub index: usize,
    /// Equispaced samples that were looked at: what is narrower than their distance was not seen.
    pub samples: usize,
    /// Whether the integrals are those of the piecewise rule.
    pub piecewise: bool,
    /// Whether it winds round the period of a position: it cannot be contracted, and a symplectic map may
    /// change its integral (by the flux, of a map that is not exact).
    pub winds: bool,
    /// Step by step.
    pub steps: Vec<StepEvidence>,
    /// Why there are none.
    pub failure: Option<Error>,
}

/// What one step of one loop showed.
#[derive(Clone, Copy, Debug)]
pub struct StepEvidence {
    /// Step size h.
    pub step_size: f64,
    /// Change of the loop integral.
    pub defect: Defect,
    /// A break of the advanced loop, the largest that is known.
    pub found: Option<Break>,
    /// What closing the breaks gives, where all of them are known.
    pub closing: Option<Closing>,
    /// Cells of the map's grid, or half periods of a position, between neighbouring samples at most; 0 for a
    /// map with neither.
    pub cells_apart: f64,
}

/// A loop whose breaks are closed.
#[derive(Clone, Copy, Debug)]
pub struct Closing {
    /// Breaks.
    pub breaks: usize,
    /// What the closing segments contribute to the loop integral.
    pub chord: f64,
    /// Change of the closed loop integral.
    pub closed: Defect,
}

/// A defect this many times its uncertainty is beyond doubt.
pub(crate) const BEYOND_DOUBT: f64 = 10.0;

/// A defect this many times its uncertainty is not explained by it.
pub(crate) const UNEXPLAINED: f64 = 3.0;

/// Samples further apart than this many cells of the map's grid, or half periods, do not see them: what
/// they show is not the map.
pub(crate) const MOST_CELLS_APART: f64 = 0.5;

/// A bound on the defect above this is too weak to call a map symplectic.
pub(crate) const WEAKEST_BOUND: f64 = 1e-6;

impl LoopEvidence {
    /// No steps yet.
    pub fn new(index: usize, samples: usize) -> Self {
        LoopEvidence {
            index,
            samples,
            piecewise: false,
            winds: false,
            steps: Vec::new(),
            failure: None,
        }
    }

    /// A random loop on which the map failed.
    pub fn failed(index: usize, failure: Error) -> Self {
        LoopEvidence {
            failure: Some(failure),
            ..Self::new(index, 0)
        }
    }

    /// Whether it bounds the defect well enough to testify for a map.
    fn testifies(&self) -> bool {
        !self.steps.is_empty() && self.weak_step().is_none()
    }

    /// Whether a step broke the loop or changed its integral beyond doubt.
    pub fn shows_defect(&self) -> bool {
        (self.steps.iter()).any(|step| step.found.is_some() || step.is_beyond_doubt())
    }

    /// A step that bounds the defect too weakly to call a map symplectic.
    pub(crate) fn weak_step(&self) -> Option<&StepEvidence> {
        // Not `bound > …`: a bound that is no number is no bound.
        (self.steps.iter()).find(|step| !matches!(step.bound(), 0.0..=WEAKEST_BOUND))
    }
}

impl StepEvidence {
    /// Whether the samples miss the grid of the map.
    fn misses_the_grid(&self) -> bool {
        self.cells_apart > MOST_CELLS_APART
    }

    pub(crate) fn is_beyond_doubt(&self) -> bool {
        !self.misses_the_grid()
            && self.defect.magnitude() > BEYOND_DOUBT * self.defect.uncertainty()
    }

    pub(crate) fn is_unexplained(&self) -> bool {
        self.defect.magnitude() > UNEXPLAINED * self.defect.uncertainty()
    }

    /// The largest defect that the step may have.
    pub(crate) fn bound(&self) -> f64 {
        self.defect.magnitude() + self.defect.uncertainty()
    }
}

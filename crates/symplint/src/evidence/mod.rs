//! Measurements, without conclusions.
//!
//! A diagnosis fills one [`Evidence`], [`judge`](crate::verdict::judge) reads it. It is serialisable: a verdict
//! can be reached again from a file.

mod break_sides;
mod checks;
mod localisation;
mod long_time;
mod motion;
mod picture;
mod point;
mod preserved_form;
mod step;
mod structure;
mod survey;

pub use break_sides::{BreakAlongFlow, BreakSides, CoordinateAtBreak, PositionAtBreak};
pub use checks::{Check, Evaluations, Omission, OmissionReason};
pub use localisation::{Contraction, Localisation, Sector, SubstepDefect};
pub use long_time::{EnergyInTime, LongTime, LoopAtStep};
pub(crate) use motion::{
    MAX_ROUNDING_CHANGE, MIN_DEFORMATION, MIN_PHASE_ADVANCE, defect_of_order_4,
};
pub use motion::{Motion, Reach};
pub use picture::LoopPicture;
pub use point::{LoopBreak, Point, Sweep};
pub use preserved_form::{DigitsOfMatrix, FormEntry, FormOnLoop, PreservedForm};
pub(crate) use preserved_form::{monomial, uncertain_part};
pub use step::{ClosedBreaks, JumpingCells, StepEvidence, Wrap};
pub(crate) use step::{MAX_BOUND_ON_DEFECT, MAX_CELLS_BETWEEN_SAMPLES};
pub use structure::{EnergyAtStep, EnergyChange, ReturnDefect, StructureEvidence};
pub use survey::{
    HeldCoordinate, OutputFormat, OutputPrecision, Rank, Scatter, ScatterKind, SingularJacobian,
    Survey, WrongPeriod,
};

use serde::{Deserialize, Serialize};

use crate::breaks::Break;
use crate::jacobian::{JacobianDecay, JacobianEvidence};
use crate::rules::RuleKind;

/// Fewer samples than this do not show whether a loop is smooth.
pub(crate) const MIN_SAMPLES_OF_SHAPE: usize = 32;

/// Step sizes at which a loop has a significant defect, at least, if its defect is to show how it depends on h.
pub(crate) const MIN_STEP_SIZES_OF_LAW: usize = 3;

/// The largest of these step sizes over the smallest, at least. Two halvings, with room for step sizes that are rounded.
pub(crate) const MIN_RANGE_OF_LAW: f64 = 3.9;

/// All measurements of one map, or of loops that another code advanced.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Evidence {
    /// The origin of the advanced states.
    pub origin: Origin,
    /// The loops, the given one first.
    pub loops: Vec<LoopEvidence>,
    /// The given loop with different numbers of samples, where such a sweep was asked for.
    pub sample_sweep: Vec<StepEvidence>,
    /// The breaks that were found: all of the given loop at the largest step size, by the piecewise
    /// rule; else the largest one of each advanced loop.
    pub breaks: Vec<LoopBreak>,
    /// Both sides of a break.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub break_sides: Option<BreakSides>,
    /// Degrees of freedom in groups of similar action, the largest first, if there are several.
    #[serde(default)]
    pub groups: Vec<DofGroup>,
    /// Results about the map apart from loop integrals.
    pub survey: Survey,
    /// Defects of the substeps of the map and of parts of a loop.
    pub localisation: Option<Localisation>,
    /// The place of the change of the integral of the loop with the largest defect, if the Jacobian does not show it.
    #[serde(default)]
    pub contraction: Option<Contraction>,
    /// A random loop after a larger step, or a larger one for a map without a step size, if the others move little.
    #[serde(default)]
    pub reach: Option<Reach>,
    /// The largest radii of the loops, of a position and of a momentum, if the verdict is about loops of this size: of a map
    /// without a step size, or that moves them little.
    #[serde(default)]
    pub radii: Option<[f64; 2]>,
    /// The order of the method as the user states it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected_order: Option<usize>,
    /// The given loop after many steps.
    pub long_time: Option<LongTime>,
    /// The integral of the given loop at up to 200 numbers of steps, as far as its samples resolve it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub loop_at_steps: Vec<LoopAtStep>,
    /// The Jacobian of the largest step at points of the given loop.
    pub jacobian: Option<JacobianEvidence>,
    /// How the largest defect of the Jacobian falls with the step size. Measured if a loop has a defect at three step sizes,
    /// as a witness for the order of the defect.
    #[serde(default)]
    pub jacobian_decay: Option<JacobianDecay>,
    /// Another constant two-form that a map which is not symplectic may preserve.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preserved_form: Option<PreservedForm>,
    /// Whether steps back undo a step.
    #[serde(default)]
    pub structure: Option<StructureEvidence>,
    /// The given loop before and after the largest step. A [`Diagnosis`](crate::Diagnosis) holds it next to the evidence.
    #[serde(skip)]
    pub picture: Option<LoopPicture>,
    /// Measurements that were asked for and not made.
    pub omissions: Vec<Omission>,
    /// Evaluations of the map.
    pub evaluations: Evaluations,
}

/// Where advanced states come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// A map, which can be evaluated anywhere.
    #[default]
    Map,
    /// Files or arrays: the states of the samples and no others.
    Samples,
}

/// Which loop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LoopKind {
    /// The loop that the user gave.
    #[default]
    Given,
    /// A random loop of its size round its centre, in the degrees of freedom that it moves.
    Random,
    /// A random loop that moves the degrees of freedom that the given loop leaves at rest, too.
    Extended,
    /// A random loop in a group of degrees of freedom of similar action alone.
    Group,
    /// A random loop that winds round the period of a position.
    Winding,
    /// The given loop after one step: of a map that projects onto a manifold, it lies there.
    Image,
}

/// Degrees of freedom of similar action: light bodies and heavy bodies, for example. A loop integral is a sum
/// of actions, in which small ones are lost: each group has its own loops and tangent vectors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DofGroup {
    /// Which, in ascending order.
    pub dofs: Vec<usize>,
    /// Their largest action, weight × radius in q × radius in p, as a part of the largest one of all.
    pub action: f64,
}

/// What one loop showed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LoopEvidence {
    /// 0 is the given loop.
    pub index: usize,
    /// Which loop it is.
    pub kind: LoopKind,
    /// The group of degrees of freedom that it moves alone.
    #[serde(default)]
    pub group: Option<usize>,
    /// The rule that integrated it.
    pub rule: RuleKind,
    /// Equispaced samples: features narrower than their distance are not resolved.
    pub samples: usize,
    /// Whether a position gains whole periods round the loop: the loop cannot be contracted then, and a
    /// symplectic map may change its integral (by the flux, of a map that is not exact).
    pub winds: bool,
    /// The degrees of freedom whose positions do.
    #[serde(default)]
    pub wound: Vec<usize>,
    /// A break of the loop before any step: it is not closed, or not unwrapped.
    pub broken_before: Option<Break>,
    /// A position that jumps by its whole range before any step.
    pub wrap_before: Option<Wrap>,
    /// Mean distance of neighbouring samples over that of samples sorted along the loop, for loops of another
    /// code, before the step or after one: 1 for rows in order.
    pub shuffled: Option<f64>,
    /// The number of the last row of a loop of another code, counted from 0, if it repeats the first one: it was left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeated_row: Option<usize>,
    /// The widest gap between neighbouring rows of a loop of another code, as a part of its length, if they are not equally
    /// spaced.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub widest_gap: Option<f64>,
    /// Step by step.
    pub steps: Vec<StepEvidence>,
    /// The error of the map, if there are no steps.
    pub failure: Option<String>,
}

impl Evidence {
    /// All points, flat, as tables and reports show them: the sweep over step sizes loop by loop, then
    /// the sweep over samples.
    pub fn points(&self) -> Vec<Point> {
        let of_loops = self.loops.iter().flat_map(|of_loop| {
            let point = |step| Point::new(Sweep::StepSize, of_loop.index, step);
            of_loop.steps.iter().map(point)
        });
        let of_samples = (self.sample_sweep.iter()).map(|step| Point::new(Sweep::Samples, 0, step));
        of_loops.chain(of_samples).collect()
    }

    /// What of a check the budget did not allow.
    pub(crate) fn missing(&self, check: Check) -> usize {
        let missing = self.omissions.iter().map(|of| of.missing(check));
        missing.sum()
    }
}

impl LoopEvidence {
    /// A loop on which nothing was measured yet.
    pub fn new(index: usize, kind: LoopKind) -> Self {
        LoopEvidence {
            index,
            kind,
            ..LoopEvidence::default()
        }
    }

    /// Whether a step broke the loop or changed its integral significantly.
    pub fn shows_defect(&self) -> bool {
        self.is_broken() || self.steps.iter().any(StepEvidence::is_significant)
    }

    /// Whether some step breaks the loop.
    pub fn is_broken(&self) -> bool {
        self.steps.iter().any(|step| step.jump.is_some())
    }

    /// A step that bounds the defect too weakly to call a map symplectic.
    pub fn weak_step(&self) -> Option<&StepEvidence> {
        (self.steps.iter()).find(|step| !step.is_bounded())
    }

    /// Whether every step bounds the defect well enough to count for a map.
    pub fn is_bounded(&self) -> bool {
        !self.steps.is_empty() && self.weak_step().is_none()
    }

    /// What no defect exceeds of loops that bound one: the given loop, and others that do not wind.
    pub(crate) fn bound_of(loops: &[LoopEvidence]) -> f64 {
        let (given, others) = loops.split_at(loops.len().min(1));
        let others = others.iter().filter(|found| !found.winds);
        (given.iter().chain(others))
            .filter(|found| found.is_bounded())
            .flat_map(|found| &found.steps)
            .map(StepEvidence::bound)
            .fold(f64::EPSILON, f64::max)
    }
}

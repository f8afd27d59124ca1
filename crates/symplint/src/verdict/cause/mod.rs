//! The likeliest cause of a failure, and what to do about it.

mod blocks;
mod breaks;
mod changes;
mod form;
mod order;

pub(super) use breaks::JumpLaw;

use serde::Serialize;

use super::advice::Advice;
use super::findings::Finding;
use super::order::Fit;
use super::properties::Property;
use crate::evidence::Evidence;
use crate::jacobian::JacobianEvidence;
use crate::text::plain_numbers;

/// The likeliest cause of a verdict that is not `symplectic`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Cause {
    /// Which.
    pub kind: CauseKind,
    /// The evidence for it, in one or two sentences.
    pub text: String,
    /// What to do about it. The advice of the verdict begins with it.
    pub remedy: String,
    /// The setting that makes the map symplectic, if there is one: `weight = [1, 3]`.
    pub setting: Option<String>,
    /// Digits to which the map is symplectic with this setting, if that was tried.
    pub digits: Option<f64>,
}

/// The causes that symplint distinguishes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum CauseKind {
    /// A solver inside the map stops at a tolerance, and rounding decides after how many iterations.
    SolverTolerance,
    /// A coordinate is set to a bound, or a particle stopped, beyond a threshold.
    Clipped,
    /// A position is wrapped into a periodic box, or an angle into a turn.
    Period,
    /// A particle is reflected.
    Wall,
    /// The step chooses its own length: both sides of a break lie on one trajectory.
    ChosenStepLength,
    /// A force jumps: at a cut-off, a cell face, a switch.
    ForceJump,
    /// A choice inside the step, such as a number of substeps, differs from state to state.
    ChoiceInside,
    /// An iteration inside the step does not converge at the larger step sizes.
    NoConvergence,
    /// The step projects, as one does that removes the motion of the centre of mass.
    Projection,
    /// The step gives the same result for every step size: a right-hand side is not a step.
    IgnoresStepSize,
    /// All areas change their sign: q and p are swapped.
    Swapped,
    /// All areas change by one factor: friction, or momenta in units that change.
    Friction,
    /// A linear map whose matrix was rounded to few digits.
    RoundedMatrix,
    /// The map is symplectic with other weights of the momenta: velocities are given, or momenta in other units.
    VelocitiesForMomenta,
    /// The map is symplectic if the sign of some pair (q, p) is changed.
    SignOfAPair,
    /// The map is symplectic if each q is paired with another p.
    PairsPermuted,
    /// The map is symplectic with the canonical momenta of a magnetic field, uniform or a polynomial in q.
    KineticMomenta,
    /// The map is linear, as one of fields (E, B), and symplectic with the vector potential instead of B.
    Fields,
    /// The map preserves another constant two-form.
    OtherForm,
    /// A kick by a force that is not a gradient.
    ForceWithCurl,
    /// A drift by a velocity that is not a gradient.
    VelocityWithCurl,
    /// Some momenta are damped, or changed by functions of momenta.
    PartialFriction,
    /// An explicit Runge–Kutta method, or an implicit one whose equations are solved by few fixed-point iterations.
    FewIterations,
    /// One of many substeps, or few of them, change loop integrals.
    Substep,
    /// The defect is the same at all step sizes: a part of the step that does not depend on h changes areas.
    IndependentOfStepSize,
    /// The defect falls more slowly with h than the defects of a method of the stated order do.
    OrderBelowMethod,
    /// The map preserves no constant two-form, or none with constant weights.
    NoForm,
}

/// The input of the search for a cause.
pub(super) struct Clues<'a> {
    pub evidence: &'a Evidence,
    pub properties: &'a [Property],
    /// Findings and advice of the verdict before its cause is known.
    pub findings: &'a [Finding],
    pub advice: &'a [Advice],
    /// k of defect ~ h^k.
    pub order: Option<f64>,
    /// The laws of the loops.
    pub fits: &'a [Fit],
    /// How the jumps of loops depend on the step size.
    pub law: Option<JumpLaw>,
}

impl Clues<'_> {
    /// The causes of breaks, those that the evidence tells most surely first.
    const OF_BREAKS: [fn(&Self) -> Option<Cause>; 7] = [
        Self::solver_tolerance,
        Self::clipped,
        Self::period,
        Self::wall,
        Self::chosen_step_length,
        Self::force_jump,
        Self::choice_inside,
    ];

    /// The causes of changes of loop integrals, those that the evidence shows most surely first.
    const OF_CHANGES: [fn(&Self) -> Option<Cause>; 16] = [
        Self::ignores_step_size,
        Self::rounded_matrix,
        Self::swapped,
        Self::clipped_on_loop,
        Self::projection,
        Self::no_convergence,
        Self::other_form,
        Self::friction,
        Self::solver_tolerance,
        Self::own_step_length,
        Self::part_of_step,
        Self::substep,
        Self::order_below_method,
        Self::level_of_a_tolerance,
        Self::independent_of_step_size,
        Self::no_form,
    ];

    /// Why loops break.
    pub fn of_breaks(&self) -> Option<Cause> {
        let mut cause = Self::OF_BREAKS.iter().find_map(|cause| cause(self))?;
        // A wall or a force does not explain a defect of the Jacobian.
        let jacobian = self.evidence.jacobian.as_ref();
        if matches!(cause.kind, CauseKind::Wall | CauseKind::ForceJump)
            && jacobian.is_some_and(JacobianEvidence::shows_defect)
        {
            cause.text += " The step also changes areas next to the jump, as its Jacobian shows.";
            cause.remedy = format!(
                "First find what changes areas next to the jump: friction, a reflection that changes |p|, a method that is not \
                 symplectic. {}",
                cause.remedy
            );
        }
        Some(cause)
    }

    /// Why loop integrals change.
    pub fn of_changes(&self) -> Option<Cause> {
        Self::OF_CHANGES.iter().find_map(|cause| cause(self))
    }
}

impl Cause {
    /// What its text is about, as a heading: a likely cause, or that other variables do not help.
    pub fn heading(&self) -> &'static str {
        match self.kind {
            CauseKind::NoForm => "Variables",
            _ => "Cause",
        }
    }

    /// Whether blocks of the defect of the Jacobian show it, so that its text has them.
    pub(super) fn is_of_blocks(&self) -> bool {
        matches!(
            self.kind,
            CauseKind::ForceWithCurl
                | CauseKind::VelocityWithCurl
                | CauseKind::PartialFriction
                | CauseKind::FewIterations
        )
    }

    /// A coordinate that has one value at some `states`.
    fn clipped(states: &str, coordinate: char, dof: usize) -> Self {
        let name = format!("{coordinate}[{dof}]");
        let instead = match coordinate {
            'q' => {
                ". A wall that reflects particles (q → 2·wall − q, p → −p) keeps their area, but still breaks loops that reach it"
            }
            _ => "",
        };
        Cause::new(
            CauseKind::Clipped,
            format!(
                "{states}, though they differ before it. The step limits or sets {name} there, and the area of these states is lost (det M \
                 = 0)."
            ),
            format!(
                "Find where the step sets {name}: a wall, an absorbing boundary, a clamp, a limit. Move the loop away from it, until no \
                 state reaches it in the largest step{instead}."
            ),
        )
    }

    /// Without a setting.
    fn new(kind: CauseKind, text: String, remedy: impl Into<String>) -> Self {
        Cause {
            kind,
            text: plain_numbers(&text),
            remedy: plain_numbers(&remedy.into()),
            setting: None,
            digits: None,
        }
    }
}

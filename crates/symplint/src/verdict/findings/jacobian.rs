//! The sentences about a Jacobian test.

use std::fmt::{Display, Formatter, Result};

use crate::jacobian::{JacobianMethod, TangentRejection};
use crate::text::{loop_name, short, size};
use crate::verdict::jacobian::{Agreement, InconclusiveReason, JacobianFinding, JacobianVerdict};

impl Display for JacobianFinding {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self.step_size {
            Some(h) => write!(f, "At h = {} the Jacobian", size(h))?,
            None => f.write_str("The Jacobian")?,
        }
        let of_loop = match self.loop_index {
            0 => String::new(),
            index => format!(", on {}", loop_name(index)),
        };
        write!(
            f,
            " {}{of_loop} ({}). {}",
            self.verdict, self.method, self.agreement
        )?;
        match self.verdict {
            JacobianVerdict::Undecided {
                reason: InconclusiveReason::WeakBound { .. },
            } => f.write_str(
                " Derivatives amplify the noise of a map; loop integrals average it and bound the defect \
                 better.",
            ),
            _ => Ok(()),
        }
    }
}

impl Display for JacobianVerdict {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            JacobianVerdict::SymplecticAlmostEverywhere { digits } => {
                write!(f, "satisfies MᵀJM = J to {digits} digits")
            }
            JacobianVerdict::NotSymplectic { worst } => {
                write!(
                    f,
                    "violates MᵀJM = J by {:.3e} ± {:.1e} at s = {:.6}",
                    worst.signed, worst.uncertainty, worst.s
                )?;
                match worst.dofs {
                    None => Ok(()),
                    Some((i, j)) if i == j => write!(f, ", in q[{i}] and p[{i}]"),
                    Some((i, j)) => write!(f, ", between (q[{i}], p[{i}]) and (q[{j}], p[{j}])"),
                }
            }
            JacobianVerdict::Undecided { reason } => {
                write!(f, "gives no verdict: {reason}")
            }
        }
    }
}

impl Display for InconclusiveReason {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            InconclusiveReason::NoPoints => f.write_str(
                "the budget left no evaluations for differences; correct the tangent map or give a larger \
                 budget",
            ),
            InconclusiveReason::NoDerivative { points, of } => write!(
                f,
                "the map has no derivative at {points} of {of} points; take another loop"
            ),
            InconclusiveReason::LittleDeformation { deformation } => write!(
                f,
                "the step is small: it deforms tangent vectors by {} of their size, and every accurate method is nearly symplectic then. \
                 Take a larger step",
                short(*deformation)
            ),
            InconclusiveReason::WeakBound { bound, noise } => write!(
                f,
                "differences only show that the defect is below {bound:.1e}, as the map has noise of {noise:.1e} of the loop's size; take \
                 a larger loop or double precision"
            ),
            InconclusiveReason::Unexplained { worst } => write!(
                f,
                "the defect of {:.1e} at s = {:.6} exceeds its uncertainty of {:.1e} but is not \
                 significant; take a larger step or another loop",
                worst.magnitude(),
                worst.s,
                worst.uncertainty
            ),
        }
    }
}

impl Display for Agreement {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        f.write_str(match self {
            Agreement::Symplectic => "Loops and Jacobian agree.",
            Agreement::NotSymplectic => "Loops and Jacobian agree.",
            Agreement::NotSymplecticBetweenBreaks => {
                "Loops and Jacobian agree that the map is not symplectic: it is discontinuous, and it does \
                 not conserve the form between its jumps either."
            }
            Agreement::BreaksAlone => {
                "Both are right: a map that breaks loops can have a symplectic Jacobian almost \
                 everywhere, as derivatives do not detect jumps. Only the jumps break loops."
            }
            Agreement::BelowBoundOfLoops { bound } => {
                return write!(
                    f,
                    "They do not contradict each other: the loops show that the change is below {bound:.1e}, and the defect of the \
                     Jacobian is smaller."
                );
            }
            Agreement::HiddenFromLoops => {
                "Trust the Jacobian: a loop integral changes by the average of the defect over the area within the loop. Parts of opposite \
                 sign cancel, for example by a symmetry of the loop, and a loop that does not move these degrees of freedom does not show \
                 the defect. Try loops without symmetry through this point."
            }
            Agreement::HiddenFromJacobian { full, bound } => {
                let mut text = String::from(
                    "Trust the loops: derivatives were taken at a few points only. Other points inside the loop or on it can make the change, \
                     or jumps that the samples do not show as breaks",
                );
                if !full {
                    text += ", or a defect in directions that random pairs mix with too many others";
                }
                if let Some(bound) = bound {
                    text += &format!(". The Jacobian does not show a defect below {bound:.1e}");
                }
                return write!(f, "{text}. Try more points and more samples.");
            }
            Agreement::OnlyJacobianDecides => {
                "The loops are not enough for a verdict. The Jacobian shows a defect, so the map is probably not symplectic."
            }
            Agreement::LoopsUndecided => {
                "The loops are not enough for a verdict, and derivatives do not detect jumps. Follow the advice."
            }
            Agreement::JacobianUndecided => "The verdict rests on the loops only.",
        })
    }
}

impl Display for JacobianMethod {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            JacobianMethod::TangentMap => f.write_str("exact derivatives"),
            JacobianMethod::CentralDifferences { rejected: None } => {
                f.write_str("central differences")
            }
            JacobianMethod::CentralDifferences {
                rejected: Some(reason),
            } => write!(f, "central differences: {reason}"),
        }
    }
}

impl Display for TangentRejection {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            TangentRejection::WrongDerivative {
                s,
                difference,
                uncertainty,
            } => write!(
                f,
                "the tangent map is not used, as it is not the derivative of the map: they differ by \
                 {difference:.1e} ± {uncertainty:.1e} at s = {s:.6}"
            ),
            TangentRejection::WrongState { s, difference } => write!(
                f,
                "the tangent map is not used, as it does not advance states as the map does: they differ \
                 by {difference:.1e} at s = {s:.6}"
            ),
            TangentRejection::Unchecked => f.write_str(
                "the tangent map is not used, as differences converge at no point to check it",
            ),
        }
    }
}

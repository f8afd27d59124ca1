//! What a Jacobian test found, and what it makes of it.

use serde::Serialize;

use super::method::JacobianMethod;
use crate::verdict::{BEYOND_DOUBT, LEAST_DEFORMATION, UNEXPLAINED, WEAKEST_BOUND, short};

/// The change of the symplectic form on two tangent vectors,
/// (ω(DΦ u, DΦ v) − ω(u, v)) / (‖u‖ ‖v‖), with ‖u‖² = Σ |w_i| r_qi r_pi (x_i² + y_i²) for
/// u = Σ x_i r_qi ∂/∂q_i + y_i r_pi ∂/∂p_i.
///
/// Here r is half the range of a coordinate on the loop and w_i the weight of p_i. So the number does
/// not depend on units, and of a map of one degree of freedom it is det DΦ − 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TangentDefect {
    /// The loop parameter of the point, in [0, 1).
    pub s: f64,
    /// The change with its sign.
    pub signed: f64,
    /// Half the width of the interval in which the true one lies, by the estimates: truncation of the
    /// differences, noise of the map and round-off; round-off alone with a tangent map.
    pub uncertainty: f64,
    /// The degrees of freedom of u and of v; `None` where u and v move all of them.
    pub dofs: Option<(usize, usize)>,
}

impl TangentDefect {
    /// Its size.
    pub fn magnitude(&self) -> f64 {
        self.signed.abs()
    }

    /// Whether it is a defect of the map for sure, by derivatives of this method.
    pub(super) fn is_beyond_doubt(&self, method: JacobianMethod) -> bool {
        self.magnitude() > (method.least_defect()).max(BEYOND_DOUBT * self.uncertainty)
    }

    /// The largest change that there may be.
    pub(super) fn bound(&self) -> f64 {
        self.magnitude() + self.uncertainty
    }
}

/// What was found at one point of the loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct JacobianPoint {
    /// The loop parameter, in [0, 1).
    pub s: f64,
    /// The largest defect of a pair of tangent vectors, of those beyond doubt if there is one; `None`
    /// where the map is not differentiable.
    pub worst: Option<TangentDefect>,
    /// What no pair that was tried exceeds, its uncertainty included; `None` likewise.
    pub bound: Option<f64>,
}

/// Why a Jacobian test has no answer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "why")]
pub enum Doubt {
    /// Derivatives are not had at half the points or more: jumps or kinks are everywhere.
    NotDifferentiable {
        /// Points without a derivative.
        points: usize,
        /// All points.
        of: usize,
    },
    /// The step hardly deforms anything; nothing could come of it.
    LittleDeformation {
        /// Largest change of a component of a tangent vector, relative to the vector.
        deformation: f64,
    },
    /// Truncation or noise of the map, of single precision for one, leave but a weak bound.
    WeakBound {
        /// What the defect does not exceed.
        bound: f64,
        /// Noise of one coordinate relative to its size on the loop.
        noise: f64,
    },
    /// A defect that its uncertainty does not explain, and too small against it to be sure.
    Unexplained {
        /// The defect.
        worst: TangentDefect,
    },
}

impl std::fmt::Display for Doubt {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Doubt::NotDifferentiable { points, of } => write!(
                f,
                "the map has no derivative at {points} of {of} points, as far as can be told; \
                 take another loop"
            ),
            Doubt::LittleDeformation { deformation } => write!(
                f,
                "the step deforms tangent vectors by only {} of their size; take a larger step",
                short(*deformation)
            ),
            Doubt::WeakBound { bound, noise } => write!(
                f,
                "derivatives only bound the defect by {bound:.1e}, with a noise of the map of \
                 {noise:.1e} of the loop's size; take a larger loop or double precision"
            ),
            Doubt::Unexplained { worst } => write!(
                f,
                "a defect of {:.1e} at s = {:.6} is more than its uncertainty of {:.1e} explains and \
                 too little to be sure; take a larger step or another loop",
                worst.magnitude(),
                worst.s,
                worst.uncertainty
            ),
        }
    }
}

/// The answer of a Jacobian test alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum JacobianVerdict {
    /// No pair of tangent vectors has a defect, at the points where the map is differentiable. That
    /// says nothing of jumps.
    SymplecticAlmostEverywhere {
        /// Digits to which the form is kept.
        digits: f64,
    },
    /// A pair of tangent vectors has a defect beyond doubt.
    NotSymplectic {
        /// The largest one.
        worst: TangentDefect,
    },
    /// The numbers do not decide.
    CannotTell {
        /// Why, and what to change.
        doubt: Doubt,
    },
}

impl std::fmt::Display for JacobianVerdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            JacobianVerdict::SymplecticAlmostEverywhere { digits } => {
                write!(f, "symplectic almost everywhere to {digits} digits")
            }
            JacobianVerdict::NotSymplectic { worst } => {
                write!(
                    f,
                    "not symplectic by {:.3e} ± {:.1e} at s = {:.6}",
                    worst.signed, worst.uncertainty, worst.s
                )?;
                match worst.dofs {
                    None => Ok(()),
                    Some((i, j)) if i == j => write!(f, ", in degree of freedom {i}"),
                    Some((i, j)) => write!(f, ", between degrees of freedom {i} and {j}"),
                }
            }
            JacobianVerdict::CannotTell { doubt } => write!(f, "cannot tell: {doubt}"),
        }
    }
}

/// The outcome of a [`JacobianTest`](crate::JacobianTest).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JacobianReport {
    /// Step size h.
    pub step_size: f64,
    /// How derivatives were had.
    pub method: JacobianMethod,
    /// The answer.
    pub verdict: JacobianVerdict,
    /// Point by point.
    pub points: Vec<JacobianPoint>,
    /// Points at which the map has no derivative, on the scale of the differences, or of the last digit of
    /// the state with a tangent map.
    pub not_differentiable: usize,
    /// Whether all pairs of unit vectors were tried, and not only random ones.
    pub full: bool,
    /// The largest defect of all points, of those beyond doubt if there is one; with the degrees of freedom
    /// that carry it, if it is beyond doubt.
    pub worst: Option<TangentDefect>,
    /// What no pair that was tried exceeds, its uncertainty included; `None` without a point.
    pub bound: Option<f64>,
    /// Largest change of a component of a tangent vector whose components are at most 1.
    pub deformation: f64,
    /// Noise of the map: of one coordinate, relative to its size on the loop.
    pub noise: f64,
    /// Single states that the map advanced, with a tangent vector or without.
    pub evaluations: usize,
}

impl JacobianReport {
    /// The answer from everything else in the report.
    pub(super) fn judged(mut self) -> Self {
        self.verdict = self.judge();
        self
    }

    fn judge(&self) -> JacobianVerdict {
        let cannot_tell = |doubt| JacobianVerdict::CannotTell { doubt };
        let (Some(worst), Some(bound)) = (self.worst, self.bound) else {
            return cannot_tell(self.without_derivative());
        };
        if worst.is_beyond_doubt(self.method) {
            return JacobianVerdict::NotSymplectic { worst };
        }
        if 2 * self.not_differentiable >= self.points.len() {
            return cannot_tell(self.without_derivative());
        }
        if self.deformation < LEAST_DEFORMATION {
            return cannot_tell(Doubt::LittleDeformation {
                deformation: self.deformation,
            });
        }
        if worst.magnitude() > (self.method.least_defect()).max(UNEXPLAINED * worst.uncertainty) {
            return cannot_tell(Doubt::Unexplained { worst });
        }
        // Not `bound > …`: a bound that is no number is no bound.
        if !matches!(bound, 0.0..=WEAKEST_BOUND) {
            return cannot_tell(Doubt::WeakBound {
                bound,
                noise: self.noise,
            });
        }
        JacobianVerdict::SymplecticAlmostEverywhere {
            digits: (-bound.max(f64::EPSILON).log10() * 10.0).floor() / 10.0,
        }
    }

    fn without_derivative(&self) -> Doubt {
        Doubt::NotDifferentiable {
            points: self.not_differentiable,
            of: self.points.len(),
        }
    }
}

/// The largest defect of those beyond doubt, or else of all; the first of equals.
pub(super) fn worst(
    method: JacobianMethod,
    defects: impl Iterator<Item = TangentDefect>,
) -> Option<TangentDefect> {
    let rank = |defect: &TangentDefect| (defect.is_beyond_doubt(method), defect.magnitude());
    defects.reduce(|best, next| {
        let ((sure, size), (best_sure, best_size)) = (rank(&next), rank(&best));
        // A defect that is no number is worse than any other.
        if (sure, size) > (best_sure, best_size) || size.is_nan() {
            next
        } else {
            best
        }
    })
}

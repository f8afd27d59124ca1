//! The measurement of a Jacobian test.

use serde::{Deserialize, Serialize};

use super::constants::CONSTANTS;
use crate::signal::{NEGLIGIBLE, SIGNIFICANT};

/// By which method a Jacobian test computes derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum JacobianMethod {
    /// The map's own [`TangentMap`](crate::map::TangentMap), exact up to round-off, and found to agree with
    /// central differences.
    TangentMap,
    /// Central differences, extrapolated.
    CentralDifferences {
        /// Why the tangent map is not used, if the map has one.
        rejected: Option<TangentRejection>,
    },
}

/// Why the tangent map of a map is not used.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "why")]
pub enum TangentRejection {
    /// It is not the derivative of the map: differences disagree.
    WrongDerivative {
        /// The loop parameter of the point.
        s: f64,
        /// The largest difference of a component, in units of the loop.
        difference: f64,
        /// The part of it that the uncertainty of both explains.
        uncertainty: f64,
    },
    /// It does not advance states as the map does.
    WrongState {
        /// The loop parameter of the point.
        s: f64,
        /// The largest difference of a coordinate, in units of the loop.
        difference: f64,
    },
    /// Differences converge at no point, so that there is nothing to compare with.
    Unchecked,
}

impl JacobianMethod {
    /// The smallest defect that derivatives of this method attribute to the map. Smaller ones can be noise of
    /// the map that differences enlarge, or the residual of stages that are solved to round-off, which no
    /// trial of a tangent map shows.
    pub(crate) fn least_defect(self) -> f64 {
        match self {
            JacobianMethod::TangentMap => CONSTANTS.least_defect_of_tangents,
            JacobianMethod::CentralDifferences { .. } => CONSTANTS.least_defect_of_differences,
        }
    }
}

/// The change of the symplectic form on two tangent vectors,
/// (ω(DΦ u, DΦ v) − ω(u, v)) / (‖u‖ ‖v‖), with ‖u‖² = Σ |w_i| r_qi r_pi (x_i² + y_i²) for
/// u = Σ x_i r_qi ∂/∂q_i + y_i r_pi ∂/∂p_i.
///
/// Here r is half the range of a coordinate on the loop and w_i the weight of p_i. So the number does
/// not depend on units, and of a map of one degree of freedom it is det DΦ − 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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

    /// The largest change that there may be.
    pub(super) fn bound(&self) -> f64 {
        self.magnitude() + self.uncertainty
    }

    /// Whether it is larger than noise makes it, by derivatives of this method. It rules which of several
    /// defects is kept, and which one is traced to its degrees of freedom.
    pub(super) fn is_significant(&self, method: JacobianMethod) -> bool {
        self.magnitude() > (method.least_defect()).max(SIGNIFICANT * self.uncertainty)
    }

    /// The largest of the significant ones, or else of all; the first of equals.
    pub(super) fn worst(
        method: JacobianMethod,
        defects: impl Iterator<Item = TangentDefect>,
    ) -> Option<TangentDefect> {
        let rank = |defect: &TangentDefect| (defect.is_significant(method), defect.magnitude());
        defects.reduce(|best, next| {
            if rank(&next) > rank(&best) {
                next
            } else {
                best
            }
        })
    }
}

/// The largest defect of a Jacobian test, and the largest one at the same point and along the same tangent vectors after a
/// smaller step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JacobianDecay {
    /// The larger and the smaller step size.
    pub step_sizes: [f64; 2],
    /// The defects, in the same order.
    pub defects: [TangentDefect; 2],
}

/// The measurement at one point of the loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JacobianPoint {
    /// The loop parameter, in [0, 1).
    pub s: f64,
    /// The largest defect of a pair of tangent vectors, of the significant ones if there is one; `None`
    /// where the map is not differentiable.
    pub worst: Option<TangentDefect>,
    /// What no pair that was tried exceeds, its uncertainty included; `None` where the map is not differentiable.
    pub bound: Option<f64>,
}

impl JacobianEvidence {
    /// The largest defect of a point along its tangent vectors, before it is traced to degrees of freedom: which point, and
    /// the defect.
    pub(crate) fn worst_point(&self) -> Option<(usize, TangentDefect)> {
        let worst = TangentDefect::worst(self.method, self.points.iter().filter_map(|p| p.worst))?;
        let point = (self.points.iter()).position(|point| point.worst == Some(worst))?;
        Some((point, worst))
    }

    /// Whether the largest defect is significant.
    pub(crate) fn shows_defect(&self) -> bool {
        self.worst
            .is_some_and(|worst| worst.is_significant(self.method))
    }
}

/// How a map changes volumes and areas, from all columns of its Jacobian at the points of a test.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VolumeEvidence {
    /// det DΦ − 1 at the point where its magnitude is largest, of the significant ones if there is one.
    pub determinant: TangentDefect,
    /// The factor c of ω(DΦ u, DΦ v) = c ω(u, v): its mean over all points and degrees of freedom.
    pub factor: f64,
    /// Half the width of the interval in which the factor lies.
    pub factor_uncertainty: f64,
    /// The largest (ω(DΦ u, DΦ v) − c ω(u, v)) / (‖u‖ ‖v‖) of any point and pair of unit vectors, as of a [`TangentDefect`]: zero
    /// if the map is conformally symplectic.
    pub from_conformal: TangentDefect,
}

/// Which coordinates a defect concerns: the blocks of an antisymmetric matrix, with errors, at all points of a test.
///
/// An entry is significant if it is larger than noise makes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BlockDefects {
    /// The largest significant entry of two positions, of a position and a momentum, and of two momenta; 0 without a significant one.
    pub sizes: [f64; 3],
    /// What no entry of these blocks exceeds, its uncertainty included.
    pub bounds: [f64; 3],
    /// The degrees of freedom of significant entries.
    pub dofs: Vec<usize>,
    /// What no entry exceeds that has another degree of freedom; 0 if there are no others.
    pub bound_of_others: f64,
}

/// The defect of a Jacobian M by blocks, in units of the loop. A defect at the beginning of a step is seen in the first matrix as it is, and
/// one at the end in the second.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DefectBlocks {
    /// Of MᵀJM − J: the form on two unit vectors before the step.
    pub before: BlockDefects,
    /// Of MJ⁻¹Mᵀ − J⁻¹: the Poisson brackets of two coordinates after the step.
    pub after: BlockDefects,
    /// The part of the brackets after the step that is left across the direction in which time moves states: 0 if only the length of the
    /// step differs from state to state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub across_time: Option<f64>,
}

impl BlockDefects {
    /// The largest entry.
    pub(crate) fn largest(&self) -> f64 {
        self.sizes.into_iter().fold(0.0, f64::max)
    }

    /// Whether the entries of positions, of both and of momenta are 0.
    pub(crate) fn zeros(&self) -> [bool; 3] {
        let least = NEGLIGIBLE * self.largest();
        std::array::from_fn(|k| self.sizes[k] == 0.0 && self.bounds[k] <= least)
    }

    /// The degrees of freedom that carry the whole defect, if there are others.
    pub(crate) fn carriers(&self) -> Option<&[usize]> {
        let others = self.bound_of_others;
        (others > 0.0 && others <= NEGLIGIBLE * self.largest()).then_some(&self.dofs)
    }
}

/// The measurement of a [`JacobianTest`](crate::JacobianTest). All numbers are finite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JacobianEvidence {
    /// Step size h; `None` for a map without one.
    pub step_size: Option<f64>,
    /// Number of the loop on which the points are.
    #[serde(default, skip_serializing_if = "is_given")]
    pub loop_index: usize,
    /// How derivatives were computed.
    pub method: JacobianMethod,
    /// Point by point.
    pub points: Vec<JacobianPoint>,
    /// Points at which the map has no derivative, on the scale of the differences, or of the last digit of
    /// the state with a tangent map.
    pub not_differentiable: usize,
    /// Whether all pairs of unit vectors were tried, and not only random ones.
    pub full: bool,
    /// Whether states and tangent vectors were those of the manifold on which the map acts; in full, the vectors
    /// are a basis of its tangent space then.
    #[serde(default)]
    pub projected: bool,
    /// The largest defect of all points, of the significant ones if there is one; with the degrees of freedom
    /// that carry it, if it is significant.
    pub worst: Option<TangentDefect>,
    /// What no pair that was tried exceeds, its uncertainty included; `None` without a point.
    pub bound: Option<f64>,
    /// The same for pairs in each group of degrees of freedom of similar action, the largest actions first; `bound` is
    /// that of the first.
    #[serde(default)]
    pub bounds_of_groups: Vec<Option<f64>>,
    /// Volumes and areas, if the test is full and the map acts on no manifold.
    #[serde(default)]
    pub volume: Option<VolumeEvidence>,
    /// The defect by blocks, if it is significant, the test is full, and there are several degrees of freedom.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blocks: Option<DefectBlocks>,
    /// Largest change of a component of a tangent vector whose components are at most 1, where the map is
    /// differentiable.
    pub deformation: f64,
    /// Noise of the map: of one coordinate, relative to its size on the loop.
    pub noise: f64,
    /// Evaluations made, with a tangent vector or without.
    pub evaluations: usize,
}

/// Whether a loop is the given one.
pub(crate) fn is_given(index: &usize) -> bool {
    *index == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_significant_defect_is_preferred_to_a_larger_one_of_noise() {
        let defect = |signed, uncertainty| TangentDefect {
            s: 0.0,
            signed,
            uncertainty,
            dofs: None,
        };
        let noise = defect(1e-3, 1e-3);
        let differences = JacobianMethod::CentralDifferences { rejected: None };
        let tangents = JacobianMethod::TangentMap;
        for (method, found, preferred) in [
            (differences, defect(-1e-6, 0.99e-7), true),
            (differences, defect(-1e-6, 1.01e-7), false),
            (differences, defect(1.01e-10, 1e-15), true),
            (differences, defect(0.99e-10, 1e-15), false),
            (tangents, defect(1.01e-12, 1e-15), true),
            (tangents, defect(0.99e-12, 1e-15), false),
        ] {
            for defects in [[noise, found], [found, noise]] {
                let worst = TangentDefect::worst(method, defects.into_iter());
                assert_eq!(worst, Some(if preferred { found } else { noise }));
            }
        }
    }
}

//! How derivatives are computed: by the tangent map, or by differences and why.

use serde::{Deserialize, Serialize};

/// By which method a Jacobian test computes derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum JacobianMethod {
    /// The map's own [`TangentMap`](crate::TangentMap), exact up to round-off, and found to agree with
    /// central differences.
    TangentMap,
    /// Central differences, extrapolated.
    CentralDifferences {
        /// Why the tangent map is not used, where the map has one.
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
        /// What the uncertainty of both explains of it.
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
            JacobianMethod::TangentMap => 1e-12,
            JacobianMethod::CentralDifferences { .. } => 1e-10,
        }
    }
}

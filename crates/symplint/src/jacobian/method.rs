//! How derivatives were had: by the tangent map, or by differences and why.

use serde::Serialize;

/// By which method a Jacobian test has its derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum JacobianMethod {
    /// The map's own [`TangentMap`](crate::TangentMap), exact but for round-off, and found to agree with
    /// central differences.
    TangentMap,
    /// Central differences, extrapolated.
    CentralDifferences {
        /// Why the tangent map is not used, where the map has one.
        rejected: Option<TangentDoubt>,
    },
}

/// Why the tangent map of a map is not used.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "why")]
pub enum TangentDoubt {
    /// It is not the derivative of the map: a tangent vector comes out other than by differences.
    OtherDerivative {
        /// The loop parameter of the point.
        s: f64,
        /// The largest difference of a component, in units of the loop.
        off: f64,
        /// What the uncertainty of both explains of it.
        uncertainty: f64,
    },
    /// It does not advance states as the map does.
    OtherState {
        /// The loop parameter of the point.
        s: f64,
        /// The largest difference of a coordinate, in units of the loop.
        off: f64,
    },
    /// Differences converge at no point, so that there is nothing to compare with.
    Unchecked,
}

impl JacobianMethod {
    /// A smaller defect is none of the map's own: noise of a map that differences enlarge, or what is left
    /// of stages that are solved to round-off, which no trial of a tangent map shows.
    pub(super) fn least_defect(self) -> f64 {
        match self {
            JacobianMethod::TangentMap => 1e-12,
            JacobianMethod::CentralDifferences { .. } => 1e-10,
        }
    }
}

impl std::fmt::Display for JacobianMethod {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            JacobianMethod::TangentMap => f.write_str("tangent map"),
            JacobianMethod::CentralDifferences { rejected: None } => {
                f.write_str("central differences")
            }
            JacobianMethod::CentralDifferences {
                rejected: Some(doubt),
            } => write!(f, "central differences: {doubt}"),
        }
    }
}

impl std::fmt::Display for TangentDoubt {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            TangentDoubt::OtherDerivative {
                s,
                off,
                uncertainty,
            } => write!(
                f,
                "the map's tangent map is not its derivative, off by {off:.1e} ± {uncertainty:.1e} at \
                 s = {s:.6}, and is not used"
            ),
            TangentDoubt::OtherState { s, off } => write!(
                f,
                "the map's tangent map advances states otherwise than the map, off by {off:.1e} at \
                 s = {s:.6}, and is not used"
            ),
            TangentDoubt::Unchecked => f.write_str(
                "the map's tangent map is not used, as there is no point at which differences converge \
                 to check it",
            ),
        }
    }
}

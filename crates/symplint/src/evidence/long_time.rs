//! The defect in many steps.

use serde::{Deserialize, Serialize};

/// The given loop after many steps of the largest size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LongTime {
    /// Step size h; `None` for a map without one.
    pub step_size: Option<f64>,
    /// Steps that were asked for.
    pub asked: usize,
    /// Steps that the samples resolve; from there on the loop is folded too finely for them.
    pub steps: usize,
    /// Samples of the loop.
    pub samples: usize,
    /// Largest |E| of all these steps.
    pub largest: f64,
    /// Largest |E| of the first quarter of the steps.
    pub early: f64,
    /// Largest |E| of the last quarter.
    pub late: f64,
    /// Smallest |E| of the second half.
    pub least: f64,
    /// The a of |E| ~ n^a, from the second and the last quarter.
    #[serde(default)]
    pub exponent: Option<f64>,
    /// The relative change of the area of the loop after these steps.
    #[serde(default)]
    pub change: f64,
    /// The same as the first half of the steps predicts it, with its error.
    #[serde(default)]
    pub predicted: Option<[f64; 2]>,
}

//! The defect, and the energy, in many steps.

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
    /// The energy of the states of the loop, if the map has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy: Option<EnergyInTime>,
}

/// The integral of the given loop after a number of steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LoopAtStep {
    /// The number of steps.
    pub step: usize,
    /// The relative change of the integral since the beginning.
    pub defect: f64,
    /// The uncertainty of the change: quadrature error and rounding. `None` if it is unknown.
    pub uncertainty: Option<f64>,
}

/// How the energies of the states of a loop change in many steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct EnergyInTime {
    /// All steps that were made.
    pub steps: usize,
    /// Largest |H(n) − H(0)| of any state in the first quarter of the steps.
    pub early: f64,
    /// The same in the last quarter.
    pub late: f64,
    /// The largest |H(n) − H(0)| of each state in all steps, in the mean over the states.
    pub most: f64,
    /// The least |H(n) − H(0)| of each state in the second half of the steps, in the mean over the states.
    pub least: f64,
    /// H(n) − H(0) after all steps, in the mean over the states.
    pub change: f64,
}

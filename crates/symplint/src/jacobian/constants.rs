//! The numbers that decide in a Jacobian test.
//!
//! Lengths and components are in units of the loop: half the range of a coordinate on it.

/// See [`CONSTANTS`]. The test set that calibrated values refer to are the tests of the Jacobian in this crate
/// and in `symplint-models`: closed forms, dual numbers, and all systems with all integrators.
pub(super) struct Constants {
    /// The smallest defect that a tangent map attributes to its map. Calibrated: the residual of implicit
    /// stages that are solved to round-off, which no trial shows, makes 2e-13.
    pub least_defect_of_tangents: f64,
    /// The smallest defect that differences attribute to a map. Calibrated: errors of a smooth map in double
    /// precision are below 1e-11.
    pub least_defect_of_differences: f64,
    /// Times that each tangent vector is advanced: as it is, and in pairs from states nudged to either side.
    pub trials: usize,
    /// Relative size of the nudges of a state, in units of the machine epsilon.
    pub nudge: f64,
    /// Tangent map and differences disagree where they differ by more than this many times the sum of their
    /// errors.
    pub disagreement: f64,
    /// The largest distance of a difference: what the displaced states stay within, while smooth maps are
    /// still resolved by a few powers of it.
    pub first_distance: f64,
    /// Ratio of successive distances. With larger ones smooth maps lose a digit.
    pub ratio: f64,
    /// Powers of t² that extrapolation removes at most.
    pub deepest: usize,
    /// Distances that every derivative has: they give smooth maps all digits.
    pub first_levels: usize,
    /// Distances of a derivative that needs more: down to 2^-19, which is left between the many breaks of a map
    /// of many degrees of freedom.
    pub levels: usize,
    /// Noise of an extrapolated difference at distance t, times t: the coefficients of the extrapolation
    /// enlarge it by less than this.
    pub gain: f64,
    /// A derivative with a larger error, relative to its largest component, has not converged.
    pub unresolved: f64,
    /// Unless noise explains it: truncation may be this many times the noise, as it is chosen to balance the
    /// noise at the next distance, and is itself estimated from noisy entries.
    pub noise_in_truncation: f64,
    /// Values in an ensemble of displaced states, unless one point needs more: 128 MiB.
    pub batch_values: usize,
}

/// The thresholds of a Jacobian test.
pub(super) const CONSTANTS: Constants = Constants {
    least_defect_of_tangents: 1e-12,
    least_defect_of_differences: 1e-10,
    trials: 7,
    nudge: 2.0,
    disagreement: 3.0,
    first_distance: 0.125,
    ratio: 4.0,
    deepest: 4,
    first_levels: 6,
    levels: 9,
    gain: 2.0,
    unresolved: 1e-6,
    noise_in_truncation: 16.0,
    batch_values: 1 << 24,
};

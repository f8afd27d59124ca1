//! The numbers that the judge decides by. Those that measuring needs, too, stand in `evidence/step.rs`.

/// A step that advances the motions on its loops by less than this, in radians, tests nothing: the defect of a method
/// of order 4 is about θ^6/100, and has to stand clear of round-off. Methods of order 8 and more need steps of a
/// radian to show one; the findings tell θ.
pub(super) const LEAST_PHASE_ADVANCE: f64 = 0.05;

/// A kick or a free flight alone, or a Jacobian, that deforms a loop, or tangent vectors, by less than this part of
/// their size tests nothing. Calibrated on the truth table: explicit midpoint and Heun steps of all its systems show
/// a defect from 0.2 on.
pub(super) const LEAST_DEFORMATION: f64 = 0.2;

/// Advice to take steps more than this many times as large is none: such a small phase advance may be rounding, which
/// makes 1e-8 of a shear that is one in neither coordinate.
pub(super) const MOST_LARGER: f64 = 1e6;

/// A defect below this without a law in h has to be confirmed, at a second step size or by
/// [`FAR`]: rounding inside a map can be systematic to some units in the last place.
pub(super) const SMALL: f64 = 1e-10;

/// One defect this many times its uncertainty confirms itself. Conventional: ten times the ratio that is
/// asked of two step sizes.
pub(super) const FAR: f64 = 100.0;

/// Slopes of the defect against h below this do not show a trend: half of the lowest order that a consistent method
/// can have.
pub(super) const TREND: f64 = 0.5;

/// Jumps of sampled loops below this part of a coordinate's range may be single precision inside a step, or a
/// solver that stops at a tolerance: ten units in the last place of single precision.
pub(super) const LEAST_SAMPLED_JUMP: f64 = 1e-6;

/// Neighbouring rows of a file this many times as far apart as rows sorted along the loop are shuffled: rows in
/// order have a ratio of 1, shuffled ones of a third of their number.
pub(super) const SHUFFLED: f64 = 4.0;

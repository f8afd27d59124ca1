//! The numbers that the judge decides by. Those that measuring needs, too, stand in `evidence/step.rs` and
//! `evidence/motion.rs`.

/// No advice is given to take steps more than this many times as large: such a small phase advance may be rounding, which
/// makes 1e-8 of a shear that is one in neither coordinate.
pub(super) const MAX_STEP_FACTOR: f64 = 1e6;

/// A defect below this without a law in h has to be confirmed, at a second step size or by
/// exceeding [`CERTAIN`](crate::signal::CERTAIN) uncertainties: rounding inside a map can be systematic to some units in the last place.
pub(super) const MAX_UNCONFIRMED_DEFECT: f64 = 1e-10;

/// Radii whose ratio differs by this factor from the ratio of the motion are not in its units. Conventional: loops that
/// people choose are within a factor of a hundred.
pub(super) const MIN_UNBALANCED_RATIO: f64 = 1e3;

/// A defect of the Jacobian below this may come from a solver that stops at a tolerance. Conventional: the loosest
/// tolerance in use.
pub(super) const MAX_SOLVER_TOLERANCE: f64 = 1e-5;

/// An error at one state in N is met by this many times N states. Derived: random states all miss it with the probability e⁻⁷, one in a
/// thousand.
pub(super) const STATES_PER_ERROR: usize = 7;

/// Slopes of the defect against h below this do not show a trend: half of the lowest order that a consistent method
/// can have.
pub(super) const MIN_TREND: f64 = 0.5;

/// Jumps of sampled loops below this part of a coordinate's range may be single precision inside a step, or a
/// solver that stops at a tolerance: ten units in the last place of single precision.
pub(super) const MIN_SAMPLED_JUMP: f64 = 1e-6;

/// Breaks at which rounding decides on which side of them a state is, as a part of all, that point to a solver.
/// Calibrated: fixed-point and Newton iterations to tolerances of 1e-5 to 1e-9 have 0.3 to 1 of them, forces that jump
/// none, but where a loop grazes what breaks it.
pub(super) const MIN_FLICKERING_PART: f64 = 0.125;

/// Neighbouring rows of a file this many times as far apart as rows sorted along the loop are shuffled: rows in
/// order have a ratio of 1, shuffled ones of a third of their number.
pub(super) const MIN_SHUFFLED_RATIO: f64 = 4.0;

// The order of a defect.

/// Points of a fit at most: those of the smallest steps, where the leading terms rule.
pub(super) const MAX_POINTS: usize = 6;

/// A mean slope less certain than this says nothing: slopes that differ by more change from one order to the next.
pub(super) const MAX_ERROR_OF_SLOPE: f64 = 0.4;

/// A step that deforms a loop by this multiple of its size takes it where the map is another one: where the bound is weak, a smaller
/// loop tells more than a better known one.
pub(super) const MAX_DEFORMATION: f64 = 100.0;

/// A defect must exceed its uncertainty by this factor for the range to begin there: one halving then
/// gives a slope to 0.03.
pub(super) const MIN_DEFECT_OVER_UNCERTAINTY: f64 = 50.0;

/// A law may miss a point by this part of its scale: terms that were left out.
pub(super) const MAX_RELATIVE_MISFIT: f64 = 0.02;

/// Orders of methods that one can meet.
pub(super) const MAX_ORDER: f64 = 14.0;

/// A slope this near to a whole number stands for it. Conventional.
pub(super) const MAX_DISTANCE_TO_WHOLE: f64 = 0.15;

// Many steps.

/// Steps below which nothing is said: four in each quarter.
pub(super) const MIN_STEPS: usize = 16;

/// Defects below this are round-off that adds up.
pub(super) const MAX_ROUND_OFF_DEFECT: f64 = 1e-11;

/// A defect that adds up linearly is four times as large in the last quarter as in the first; this much is
/// taken for growth.
pub(super) const MIN_GROWTH: f64 = 2.5;

/// A defect that stays of one size varies by less than this from the first to the last quarter.
pub(super) const MAX_VARIATION: f64 = 1.8;

/// A bounded defect returns to this part of its largest value.
pub(super) const MAX_RETURN: f64 = 0.5;

/// Energies that stay beyond this part of their largest change have drifted away. Conventional: a quarter of an oscillation, whose
/// second half is above 0.7, has not.
pub(super) const MIN_DRIFT: f64 = 0.8;

//! The numbers that decide how a budget is spent, and when a loop is resolved.
//!
//! None of them reaches the judge: they decide what is measured, and what it costs; docs/budget.md has what comes of
//! them. Those that say neither a derivation nor a test are conventional, round numbers that worked.

// Budgets.

/// The budget where none is given: enough for fine resolution of every system of the models.
pub(super) const DEFAULT_BUDGET: usize = 1_000_000;

/// The smallest budget that a diagnosis can do something with: the checks of the map, one loop at
/// two step sizes, and a random loop.
pub(crate) const MIN_BUDGET: usize = 200;

/// Loops at most: each is sampled and advanced separately, and listed in the evidence.
pub const MAX_LOOPS: usize = 10_000;

/// Where doubling begins at the latest in one degree of freedom: samples of small systems cost nothing, and features
/// narrower than a cell of the loop are not resolved.
pub(super) const FINE_SAMPLES: usize = 1 << 11;

/// Samples that tell whether a map rounds, where more are planned: enough for any smooth loop.
pub(super) const SAMPLES_OF_ROUNDING_TEST: usize = 256;

/// Samples from which doubling begins where a map rounds. Derived: with eight step sizes and seven random loops they take
/// less than 50,000 evaluations; more gain a digit for each hundredfold.
pub(super) const MAX_ROUNDED_SAMPLES: f64 = 2048.0;

/// The blocks of a defect may take one in this number of the evaluations made so far. Conventional: they name its cause.
pub(super) const DIVISOR_OF_BLOCKS: usize = 2;

/// Degrees of freedom up to which blocks are measured. Derived: the brackets of all coordinates take less than a second then.
pub(super) const MAX_DOF_OF_BLOCKS: usize = 200;

/// A second step size of the Jacobian may take one in this number of the evaluations made so far.
pub(super) const DIVISOR_OF_DECAY: usize = 15;

/// The first samples of all loops and step sizes take one in this number of evaluations of the budget.
pub(super) const DIVISOR_OF_FIRST_SAMPLES: usize = 3;

/// The samples of one loop may take one in this number of evaluations of the budget, if their number is given; fewer are taken
/// if it is more.
pub(super) const DIVISOR_OF_GIVEN_SAMPLES: usize = 4;

/// Equispaced samples of the given loop may take one in this number of evaluations of a tight budget: pieces resolve the rest
/// with fewer evaluations.
pub(super) const DIVISOR_OF_TIGHT_SAMPLES: usize = 16;

/// One in this number of evaluations of a budget is kept while the given loop is resolved: enough for a second step size or a
/// random loop, if samples resolve it.
pub(super) const DIVISOR_OF_RESERVE: usize = 8;

/// Budgets below this are tight: every evaluation is counted on.
pub(super) const TIGHT_BUDGET: usize = 20_000;

/// States that are advanced again at the beginning: eight find a state that samples share, or an order that
/// matters; a tight budget, or states so large that few fit into memory, have four.
pub(super) const PURITY_SAMPLES: [usize; 2] = [4, 16];

/// States that are taken out of the largest batch of a loop and advanced again, at most: a batch of eight has another order and
/// other neighbours.
pub(super) const MAX_WITNESSES: usize = 8;

/// Evaluations of the budget for each of these states: all of them take about 2% of a budget.
pub(super) const BUDGET_PER_WITNESS: usize = 250;

/// The Jacobian may take one in this number of evaluations of a small budget.
pub(super) const DIVISOR_OF_JACOBIAN: usize = 5;

/// Evaluations that the Jacobian may take in a small budget: two points in two degrees of freedom. Conventional.
pub(super) const MAX_SMALL_JACOBIAN: usize = 200;

/// The same for a budget of which this part is more than [`MAX_SMALL_JACOBIAN`].
pub(super) const DIVISOR_OF_LARGE_JACOBIAN: usize = 20;

/// The test of steps back may take one in this number of evaluations of a budget if the user did not ask for it: smaller budgets leave
/// it out.
pub(super) const DIVISOR_OF_STRUCTURE: usize = 50;

/// One in this number of evaluations of a budget is kept to test whether the states that show a defect lie in the domain of the map.
pub(super) const DIVISOR_OF_DOMAIN: usize = 10;

/// Evaluations that contracting a loop takes, about: twelve halvings of the disc, of which the boundaries come near to
/// one or two singular points.
pub(super) const EVALUATIONS_OF_CONTRACTION: usize = 6_000;

/// Coordinates that the map advances for the Jacobian at most: in many degrees of freedom fewer tangent vectors have
/// to do.
pub(super) const MAX_JACOBIAN_COORDINATES: usize = 1 << 19;

/// Evaluations that the Jacobian may take in any number of degrees of freedom: some pairs at two points.
pub(super) const MAX_LARGE_JACOBIAN: usize = 400;

/// The tolerance of the piecewise rule in a tight budget: integrals to about nine digits for fewer evaluations.
/// Calibrated on the test `cubic_particles_are_symplectic_to_eight_digits_on_a_budget` in `symplint-cli`.
pub(super) const TIGHT_TOLERANCE: f64 = 1e-9;

// Rules and samples.

/// Sobolev exponents of loops with kinks: more than the ½ of a jump, for which there is a separate search, and so few
/// that no analytic loop has them. Derived: a kink has 3/2, and estimates are
/// good to 0.2 (tests in `pseudospectral/regularity.rs`).
pub(super) const MIN_EXPONENT_OF_KINKS: f64 = 1.0;

/// The other end of the range. Derived: analytic loops have 6 and more (as above).
pub(super) const MAX_EXPONENT_OF_KINKS: f64 = 4.5;

/// Exponents from N and 2N samples that differ by less are taken for one.
pub(super) const MAX_DIFFERENCE_OF_EXPONENTS: f64 = 0.1;

/// Coordinates that the piecewise rule may have the map advance for one loop integral, if the user did not choose that
/// rule.
pub(super) const MAX_PIECEWISE_COORDINATES: usize = 1 << 25;

/// Fewer evaluations than this are not worth beginning pieces with: a first look and one break.
pub(super) const MIN_PIECEWISE_EVALUATIONS: usize = 150;

/// Coordinates that the map may be made to advance for one loop integral of the streaming rule, if the user did not give
/// the number of samples: a thousand samples in a million degrees of freedom.
pub(super) const MAX_STREAMED_COORDINATES: usize = 1 << 30;

// Convergence.

/// A quadrature error of this size is as good as round-off.
pub(super) const MAX_RESOLVED_ERROR: f64 = 1e-14;

/// Twice the samples that gain less than this factor are limited by noise: smooth loops gain far more,
/// kinked ones 4 or more, jumps 2, noise of the states √2.
pub(super) const MAX_GAIN_OF_NOISE: f64 = 1.7;

/// Twice the samples that gain less than this factor may have met a feature with one sample: between the 2 of its part of the sum
/// and the 4 of kinks.
pub(super) const MAX_GAIN_OF_SPIKES: f64 = 3.0;

/// An estimate of the quadrature error that is at most this multiple of what rounding of the samples makes of an
/// integral is of rounding alone. Calibrated: pendula in single precision and with three to nine decimals have 0.3 to 3.
pub(super) const MAX_ERROR_IN_ROUNDINGS: f64 = 8.0;

/// Above this an error that does not fall is not yet noise: the loop is steep somewhere.
pub(super) const MAX_NOISE: f64 = 1e-5;

// Features that samples do not resolve.

/// A feature exceeds the median along the loop by this factor: the largest of 65,536 normally distributed values exceeds it by
/// less than 7, and rounding, whose unit changes by factors of two along the loop, by as much again.
pub(super) const MIN_OVER_MEDIAN: f64 = 32.0;

/// A feature exceeds the rounding of its coordinate by this factor.
pub(super) const MIN_OVER_ROUNDING: f64 = 256.0;

/// Features at which the Jacobian is tested, those of different loops first. Conventional.
pub(super) const MAX_FEATURES: usize = 3;

/// States for the Jacobian at a feature are displaced by this part of what they are elsewhere: by 1e-4 of the size of the loop at most, the
/// width of the narrowest strips that samples meet now and then. Rounding leaves 10 digits of the differences there.
pub(super) const DISPLACEMENT_AT_FEATURE: f64 = 1e-3;

/// One in this number of the samples that resolve a loop shows where it is roughest after a step: rounding does not hide their upper
/// modes yet.
pub(super) const DIVISOR_OF_ROUGHNESS: usize = 4;

/// Distance of states that share a feature with one of them: far below the width of a feature that matters, and so small that the
/// curvature of the loop, (2π)² of the square, is below 1e-12.
pub(super) const DISTANCE_BESIDE_FEATURE: f64 = 1e-7;

// Evaluations that are missing.

/// Samples that miss the grid may miss the steepest slopes: neighbours are taken to be this many times as far apart as
/// they are, with samples up to the number in the same row. Calibrated: cubic and quadratic particle-in-cell plasmas and
/// interpolated pendula, as the test `following_the_advice_decides` has them.
pub(super) const SLOPE_MARGINS: [(usize, f64); 3] = [(32, 4.0), (64, 2.0), (usize::MAX, 1.25)];

/// Where samples resolve the grid of the map and the bound is weak: two doublings, which gain two digits at kinks and
/// more on smooth loops.
pub(super) const FACTOR_OF_TWO_DOUBLINGS: f64 = 4.0;

/// Neighbours that a step of a continuous map moves apart by more than this factor are at a break, which pieces find:
/// it needs no more samples. Calibrated: the steepest of the plasmas has 8.1.
pub(super) const MAX_STRETCH: f64 = 12.0;

/// A budget in which pieces resolve a loop with kinks or steep slopes, and the Jacobian and random loops have their
/// parts. Calibrated: one loop takes up to 900 evaluations.
pub(super) const MIN_BUDGET_OF_PIECES: usize = 2_000;

// Many steps.

/// A quadrature error above this part of the largest defect so far ends the trace.
pub(super) const MAX_ERROR_OVER_DEFECT: f64 = 0.1;

/// Quadrature errors below this are good enough, however small the defects are.
pub(super) const MAX_SUFFICIENT_ERROR: f64 = 1e-12;

/// A loop folds: what one step resolves, many do not. Samples of a loop of one degree of freedom at least.
pub(super) const MIN_FOLDED_SAMPLES: usize = 1 << 13;

// Memory.

/// Memory of the largest ensemble that is chosen without being asked for; samples before and after a step make two of
/// them.
pub(super) const MAX_BYTES: usize = 512 << 20;

// Steps back.

/// States that a step and a step back should return, in a tight budget, or if few states fit into memory, and in others.
/// Conventional.
pub(super) const STATES_OF_RETURN: [usize; 2] = [2, 16];

/// Those of them that are moved by a rounding and tested once more.
pub(super) const STATES_OF_ROUNDING: [usize; 2] = [2, 4];

/// Step sizes below the largest one at which the change of the energy is measured. Conventional: the third step from the largest one is
/// small enough for the order of most methods.
pub(super) const STEP_SIZES_OF_ENERGY: usize = 4;

// Step sizes.

/// The step size with which a map is called that has none.
pub(super) const STEP_SIZE_OF_MAP: f64 = 1.0;

/// The phase advance of the motions on the loop by the largest step size, in radians, to a factor of two: the defects of
/// methods that are not symplectic are large there, and methods still work.
pub(super) const WANTED_PHASE_ADVANCE: f64 = 1.0;

/// Step sizes that are tried for it. Conventional: from any size two or three are enough where the map works, and
/// failures halve the way back.
pub(super) const MAX_TRIED_STEP_SIZES: usize = 12;

/// Samples that are advanced for each: an emittance needs three.
pub(super) const SAMPLES_PER_STEP_SIZE: usize = 8;

/// Step sizes, each half of the one before: an order needs some that are clear of round-off.
pub(super) const DEFAULT_STEP_SIZES: i32 = 8;

// Beyond the given loop and step sizes.

/// The factor between the sizes of larger loops. Conventional: two octaves.
pub(super) const FACTOR_OF_LARGER_LOOPS: f64 = 4.0;

/// Larger loops at most. Conventional: up to 64 times the radii of the given loop.
pub(super) const MAX_LARGER_LOOPS: usize = 3;

/// A larger step that breaks its loop is halved at most this number of times. Conventional: from a radian to a thirtieth of one.
pub(super) const MAX_HALVINGS: usize = 6;

//! All numbers that decide in a test of a force or a vector field.

/// Roundings of the terms of one state. Calibrated: sums over many coordinates in double precision scatter by less.
pub(super) const ROUNDINGS_OF_TERMS: f64 = 4.0;

/// Noise of a state below this many roundings of its terms is rounding in double precision, which is independent from state to state.
/// Calibrated: forces between tens of particles have 1 to 10.
pub(super) const MAX_ROUNDING_NOISE: f64 = 64.0;

/// Antisymmetric parts below this are not attributed to a force: constants of a force are rounded, too. Derived: about a
/// hundred roundings.
pub(super) const MIN_CURL: f64 = 2e-14;

/// Digits that a gradient has at least. Conventional: forces that are a gradient to fewer digits heat a simulation visibly.
pub(super) const MIN_DIGITS: f64 = 3.0;

/// The bound on λ from L loops is enlarged by 1 plus this over L². Calibrated: no force of the truth set claims more digits than a tenth of
/// its λ has.
pub(super) const ALLOWANCE_OF_ONE_LOOP: f64 = 8.0;

/// Samples of a loop at first: a loop on which a force is nearly linear has few modes.
pub(super) const FIRST_SAMPLES: usize = 32;

/// Samples of a small ellipse at first.
pub(super) const FIRST_SAMPLES_OF_PAIR: usize = 16;

/// Samples of a contractible loop of one position at most: its integral is zero for every force. Conventional.
pub(super) const MAX_ONE_POSITION_SAMPLES: usize = 256;

/// Samples of a small ellipse at most.
pub(super) const MAX_SAMPLES_OF_PAIR: usize = 128;

/// Half axes of an ellipse, as a part of the radius of a loop. Conventional: the force is more linear there, and differences are
/// still far above rounding.
pub(super) const PAIR_PART_OF_RADIUS: f64 = 0.25;

/// Coordinates up to which all pairs of them are tested. Conventional: 15 pairs.
pub(super) const MAX_COORDINATES_OF_ALL_PAIRS: usize = 6;

/// Random pairs of directions beyond. Conventional: they give λ to about a quarter.
pub(super) const RANDOM_PAIRS: usize = 6;

/// Loops that wind around a period at most.
pub(super) const MAX_WINDING_LOOPS: usize = 8;

/// The largest part of the change of a force along a loop of radius "auto" that is not linear. Conventional: 64 samples resolve
/// such a loop to rounding.
pub(super) const MAX_NONLINEAR_PART: f64 = 0.25;

/// The first radius tried, as a part of the size of the centre. Conventional.
pub(super) const PART_OF_CENTRE: f64 = 0.1;

/// With radius "auto", every second loop is this many times as large, but no larger than the first radius tried: cut-offs lie
/// beyond the region where a force is nearly linear. Conventional: atoms then move as far as they vibrate.
pub(super) const FACTOR_OF_WIDE_LOOPS: f64 = 4.0;

/// Halvings of that radius: far enough for an origin that is a million times as far away as the force changes.
pub(super) const MAX_HALVINGS_OF_RADIUS: usize = 24;

/// States that are evaluated again, in reverse order and two of them alone.
pub(super) const REPEATED_STATES: usize = 6;

/// Evaluations that a test needs at least: one loop, and what is made before it.
pub(super) const MIN_BUDGET: usize = 100;

/// Evaluations that are made before the budget is divided: two states for the unit, periods, the first samples, and states again.
pub(super) const EVALUATIONS_BEFORE_LOOPS: usize =
    2 + 1 + MAX_WINDING_LOOPS + FIRST_SAMPLES + REPEATED_STATES + 2;

/// Evaluations that each loop should have. Derived: one doubling of the first samples, which a smooth force takes.
pub(super) const EVALUATIONS_PER_LOOP: usize = 2 * FIRST_SAMPLES;

/// Coefficients of a loop that decay slower than m to this power have jumps: those of a jump decay as 1/m, of a kink as 1/m².
pub(super) const MAX_DECAY_OF_JUMPS: f64 = 1.5;

/// Curls, and jumps, below this part of the scale may come from a solver that stops at a tolerance. Conventional: the loosest tolerance of
/// solvers for forces.
pub(super) const MAX_SOLVER_TOLERANCE: f64 = 1e-3;

/// Jumps of a force with such a curl may come from the same solver if they are smaller than this. Calibrated: solvers with a tolerance of
/// 1e-3 make jumps of 0.02 on small loops.
pub(super) const MAX_JUMP_OF_SOLVER: f64 = 0.1;

/// A jump makes at least this part of the change between two samples. Conventional: tens of pairs may cross a cut-off between two
/// samples; what is continuous leaves 2^-40.
pub(super) const MIN_JUMP_OVER_CHANGE: f64 = 0.02;

/// A curl up to this many times the jumps of a solver comes from the solver. Derived: the error at which it stops is
/// up to 1/(1 − ρ) times its last change, and converging iterations have ρ below 0.97.
pub(super) const MAX_CURL_OVER_JUMPS: f64 = 32.0;

/// Loops on which the jumps of a solver are searched, in units of the widest loop. Calibrated: in the truth set one of 400 solvers shows no
/// jump on any of them.
pub(super) const SOLVER_FACTORS: [f64; 3] = [8.0, 32.0, 2.0];

/// The number of these loops that must be measured; each has to be resolved, or to have all samples.
pub(super) const MIN_SOLVER_LOOPS: usize = 2;

/// Samples of each of them at most. Conventional.
pub(super) const MAX_SOLVER_SAMPLES: usize = 2048;

/// Evaluations of each of them at least. Derived: two doublings of the first samples show the decay of jumps.
pub(super) const MIN_SOLVER_EVALUATIONS: usize = 4 * FIRST_SAMPLES;

/// Steps of the bisection of a jump: down to 2^-40 of a sample's distance.
pub(super) const BISECTIONS: usize = 40;

/// Loops show the rate of damping if each is known to this part of itself. Conventional.
pub(super) const MAX_RATE_ERROR: f64 = 0.01;

/// Numbers in the states that are evaluated in one call: 64 MiB.
pub(super) const MAX_VALUES_PER_CALL: usize = 1 << 23;

//! The numbers that decide how a loop is cut into pieces, and when a piece is good enough.
//!
//! Those said to be calibrated were chosen on the truth table of `symplint-truth` and on the tests `piecewise` and
//! `traps` of this crate.

/// Degrees of the interpolants of a piece, one after the other until one is good enough. Each has the nodes of the
/// one before.
pub(super) const DEGREES: [usize; 3] = [3, 6, 12];

/// The level of [`DEGREES`] at which breaks are distinguished from other reasons.
pub(super) const FULL_LEVEL: usize = DEGREES.len() - 1;

/// An interpolant below the full degree is accepted on fewer states, and has to be so much better.
pub(super) const TOLERANCE_BELOW_FULL: f64 = 0.1;

/// The places at which an interpolant is compared with states that it was not made of: not symmetric, and between nodes at every
/// level.
pub(super) const CHECKS: [f64; 2] = [-0.618, 0.267];

/// The error of an interpolant is estimated as this many times what it misses the checks by: it is 1.0 to 1.5 times that
/// where the next coefficient dominates.
pub(super) const ERROR_OVER_CHECK: f64 = 2.0;

/// Every `SAMPLES_PER_ESTIMATE`-th sample of the loop makes a separate estimate of what the interpolants miss: if they disagree,
/// the samples do not resolve it.
pub(super) const SAMPLES_PER_ESTIMATE: usize = 4;

/// The error of the integral is this many times the largest of those estimates.
pub(super) const ERROR_OVER_ESTIMATE: f64 = 2.0;

/// A jump is at most this many times the largest interpolation error next to it.
pub(super) const MAX_JUMP_OVER_MISS: f64 = 2.0;

/// Coefficients from here on are small on a smooth piece; what a break leaves there gives it away.
pub(super) const FIRST_SMALL: usize = 6;

/// A break is a difference of two smooth functions: a polynomial of at most this many coefficients.
pub(super) const MAX_TERMS: usize = 3;

/// A stretch of this part of the loop is taken for a straight line: its curvature, (2π · 1e-11)², is far below
/// round-off.
pub(super) const MAX_STRAIGHT_LENGTH: f64 = 1e-11;

/// A jump on a straight line leaves a point at least 1/`MAX_JUMP_OVER_DISTANCE` of it away from the line through the ends: the
/// widest gap between two points is two fifths of a piece.
pub(super) const MAX_JUMP_OVER_DISTANCE: f64 = 2.5;

/// Part of the highest coefficients, squared, that one break has to explain. Calibrated.
pub(super) const MIN_EXPLAINED_PART: f64 = 0.95;

/// An explanation that explains this part of what the best one explains is as good: three terms next to an end can describe what
/// one term at the end itself describes.
pub(super) const MIN_PART_OF_BEST: f64 = 0.999;

/// Coefficients whose squares fall to this part or less along the tail belong to a smooth function: those of a
/// jump of the third derivative fall by 16 in amplitude from the 6th to the 12th.
pub(super) const MAX_TAIL_RATIO: f64 = 1e-3;

/// A break whose size vanishes somewhere in its gap, to this part squared, is a kink there. Calibrated.
pub(super) const MAX_SIZE_AT_KINK: f64 = 0.02;

/// A kink is known as closely as this many times what is left unexplained, squared, lets it be.
pub(super) const KINK_SAFETY: f64 = 16.0;

/// A jump is this many times what rounding and tolerance allow for.
pub(super) const MIN_JUMP_OVER_ROUNDING: f64 = 4.0;

/// An unresolved piece may hide a jump of its range, and what the coordinate moves back next to it.
pub(super) const MARGIN_OF_RANGE: f64 = 1.1;

/// An interpolant may be off at other points by this many times what its own estimate allows.
pub(super) const MARGIN_BETWEEN_POINTS: f64 = 2.0;

/// Turning points looked at in one piece at most.
pub(super) const MAX_TURNING_POINTS: usize = 64;

/// Turning points no further apart than this part of half a piece are one.
pub(super) const MAX_DISTANCE_OF_SAME_TURNING_POINT: f64 = 1e-6;

/// Rounding of a few operations.
pub(super) const ROUNDING_OF_OPERATIONS: f64 = 16.0 * f64::EPSILON;

/// Tolerances are this many times the noise of the map: normally distributed noise exceeds it with a chance of
/// 1e-15.
pub(super) const MARGIN_OF_NOISE: f64 = 8.0;

/// Coordinates much smaller than the largest of all positions, or momenta, count as this part of it.
pub(super) const MIN_PART_OF_LARGEST: f64 = 1e-6;

/// Sizes of coordinates at least: the square of its inverse is still a number. A map may collapse a coordinate.
pub(super) const MIN_SIZE: f64 = 1e-140;

/// What an interpolant may be off where the map rounds, in grains: half of one at every node, enlarged by the highest
/// degree, and what several operations of a step make of it.
pub(super) const MAX_ERROR_IN_GRAINS: f64 = 4.0;

/// Samples by which periodic momenta are unwrapped where there are no others.
pub(super) const SAMPLES_TO_UNWRAP: usize = 256;

/// Unexplained stretches shorter than this part of the loop suggest that the map has noise.
pub(super) const MAX_LENGTH_OF_NOISE: f64 = 1e-3;

/// Sites on a stretch at which noise is estimated, as parts of it. Breaks spoil two of five at most, so close
/// together are the points of each, and their median counts.
pub(super) const NOISE_SITES: [f64; 5] = [0.137, 0.289, 0.412, 0.643, 0.829];

/// The points of a site, in units of the spacing.
pub(super) const NOISE_POINTS: [f64; 7] = [0.0, 0.87, 2.13, 2.95, 4.18, 5.04, 6.0];

/// Distance of the points of a site on the whole loop.
pub(super) const NOISE_SPACING: f64 = 2e-6;

/// Distance of those on a piece, as a part of it: so short that among all pieces of a loop that breaks
/// thousands of times none has breaks at three sites.
pub(super) const NOISE_SPACING_OF_PIECE: f64 = 2e-5;

/// A jump of this part of the loop's size is not noise. What looks like noise next to it are other breaks, or states in
/// which rounding decides on which side of a threshold they are.
pub(super) const MAX_NOISE: f64 = 1e-3;

/// A jump below this part of the loop's size may be a step of the grid that the map rounds to: the noise of the map
/// is estimated before.
pub(super) const MAX_JUMP_OF_GRID: f64 = 1e-6;

/// A difference of two states is a jump if it is this part of what it becomes by the end of the step.
pub(super) const MIN_PART_OF_FINAL_JUMP: f64 = 1e-4;

/// A known break, or the crossing of a grid line, lies in a first piece that reaches this far to both sides of it: much further than the
/// rounding of where it is, and not at all on the scale of the loop.
pub(super) const REACH_AROUND_CUT: f64 = 1e-10;

/// A piece is cut at up to this number of crossings of grid lines, and in halves if there are more.
pub(super) const MAX_CROSSINGS: usize = 16;

/// Parameters no further apart than this are a few doubles apart.
pub(super) const MAX_DISTANCE_OF_NEIGHBOURS: f64 = 4.0 * f64::EPSILON;

/// Breaks looked at on either side of one for the break that undoes it.
pub(super) const BREAKS_ON_EACH_SIDE: usize = 8;

/// From where the slopes next to a break are taken: far beyond the few doubles in which a map may not know on which
/// side of its threshold it is, where jumps would be taken for slopes.
pub(super) const DISTANCE_OF_SLOPES: f64 = 1e-6;

/// A piece this many distances of samples long has two samples, which show how the loop continues beyond it.
pub(super) const MIN_LENGTH_OF_CALM_PIECE: f64 = 2.0;

/// The largest distance between two such pieces, in distances of samples: a feature of one, and on both sides of it shorter
/// pieces, which halve from `MIN_LENGTH_OF_CALM_PIECE` down to its width, and are cut at a sample.
pub(super) const MAX_WIDTH_OF_FEATURE: f64 = 8.0;

/// Samples on either side of a feature that continue each other. Where they are a hundredth of the loop's smallest
/// structure apart, as many as these do so to round-off; more would amplify it.
pub(super) const NEIGHBOURING_SAMPLES: usize = 6;

/// The Fourier coefficients of a spike do not fall, s = −½; those of a jump fall by s = ½.
pub(super) const MAX_EXPONENT_OF_SPIKES: f64 = 0.25;

//! The numbers that decide what is a break.

/// A jump below this part of the range of its coordinate may be the rounding of a map that works with
/// large numbers inside; it bounds the digits of a verdict, and breaks no loop.
pub(super) const MIN_RELATIVE_JUMP: f64 = 1e-11;

/// A residual stands out if it is this number of standard deviations of the noise: normally distributed noise reaches
/// this with a chance of 2e-11.
pub(super) const MIN_OUTLIER_DEVIATIONS: f64 = 6.7;

/// When cells become twice as wide, a residual grows 32-fold where the coordinate is smooth, at least twofold at a
/// kink, and not at all at a jump: a jump is this part of the wider residual at least.
pub(super) const MIN_NARROW_OVER_WIDE: f64 = 0.75;

/// Residuals below this number of roundings of a value are rounding: 5.3 (the sum of the absolute weights) if values are
/// rounded once, and a step rounds several times.
pub(super) const MAX_ROUNDINGS_OF_RESIDUAL: f64 = 32.0;

/// Suspected jumps of a loop that are followed.
pub(super) const MAX_SUSPECTS: usize = 4;

/// Evaluations that following one may take: 6 samples around it, fewer than 54 halvings, those next to it, both ends displaced, and both
/// once more.
pub(super) const MAX_EVALUATIONS_OF_SUSPECT: usize = 6 + 54 + 2 * CONFIRMING_STATES + 2;

/// The step that two smooth sides leave between them keeps its size as the map is evaluated more closely: what is
/// smaller than this part of what was expected is not a step.
pub(super) const MIN_PART_ON_HALVING: f64 = 0.25;

/// A break keeps its size while its bracket shrinks from this width to [`MIN_BRACKET_WIDTH`], over four decades: the difference of
/// both ends shrinks there by 1e4 on a slope, and by 100 at a square root. Derived: on a slope as steep as the loop, the width
/// makes less than a third of the smallest break, [`MIN_RELATIVE_JUMP`].
pub(super) const MAX_WIDTH_OF_CONSTANT_JUMP: f64 = 1e-12;

/// Halvings before the difference of the ends is expected to be that of the jump alone.
pub(super) const HALVINGS_BEFORE_TEST: usize = 2;

/// Brackets of this width are not halved: no double lies between the ends if s is beyond 1/4, and for smaller s nothing
/// on the scale of the loop.
pub(super) const MIN_BRACKET_WIDTH: f64 = 0.25 * f64::EPSILON;

/// States on each side of a jump that distinguish it from noise, the end of the bracket among them: at a first look, and
/// at a second one if need be.
pub(crate) const STATES_OF_LOOKS: [usize; 2] = [3, 6];

/// Their distance: 32 doubles, so that the rounding of s is not part of the noise, and nothing on the scale of a loop.
pub(super) const SPACING_BESIDE_JUMP: f64 = 32.0 * f64::EPSILON;

/// The ends of a break are displaced by about this many roundings. On a slope the change is then about as many times what the map makes of
/// one rounding, and at a square root the root of it.
pub(super) const ROUNDINGS_OF_DISPLACEMENT: f64 = 32.0;

/// States on each side that confirm a break, the end of the bracket among them. The chance that a map which takes one of two values at
/// random, from the bits of the state, passes both looks is below 2^-13.
pub(crate) const CONFIRMING_STATES: usize = 9;

/// How far from a jump these states reach.
pub(crate) const REACH_OF_CONFIRMATION: f64 = (CONFIRMING_STATES - 1) as f64 * SPACING_BESIDE_JUMP;

/// States on each side, between those around a zone, that confirm a break with a zone.
pub(crate) const INTERMEDIATE_ZONE_STATES: usize = STATES_AROUND_ZONE - 2;

/// States on each side of a zone, the end of the bracket among them: a quadratic function takes each of two values at
/// two points at most, so that no flicker between them looks smooth at five.
pub(crate) const STATES_AROUND_ZONE: usize = 5;

/// Their distances, the widest first. A threshold that is met to a rounding ε of what is compared with it is met in a
/// zone of ε/J of the loop, where J is the jump, which is `MIN_RELATIVE_JUMP` or more: 1e-5. In between, factors of 64: other
/// breaks may be as near as the zone is wide.
pub(crate) const DISTANCES_FROM_ZONE: [f64; 5] = [
    SPACING_BESIDE_JUMP * 1_073_741_824.0,
    SPACING_BESIDE_JUMP * 16_777_216.0,
    SPACING_BESIDE_JUMP * 262_144.0,
    SPACING_BESIDE_JUMP * 4_096.0,
    SPACING_BESIDE_JUMP * 64.0,
];

/// A break is this many times the noise next to it, and the typical step from one of the states next to it to the next: this is the slope
/// times the rounding of states, or more.
pub(super) const MIN_JUMP_OVER_NOISE: f64 = 8.0;

/// Sizes of a jump at different spacings, and the values on each side of it, agree to this part of the jump.
pub(super) const MAX_MISMATCH_OF_SIZES: f64 = 0.25;

/// A jump is confirmed only if no other is nearer than this many cells.
pub(super) const MIN_CELLS_BETWEEN_JUMPS: usize = 4;

/// Residuals smaller than this part of the coordinate's variation leave it resolved, even if they are noise.
pub(super) const MAX_RESOLVED_RESIDUAL: f64 = 1e-5;

/// Where more than this part of the cells are flagged, the samples show no shape.
pub(super) const MAX_FLAGGED_PART: f64 = 0.25;

/// Samples that show the size of a loop.
pub(crate) const SAMPLES_OF_SIZE: usize = 8;

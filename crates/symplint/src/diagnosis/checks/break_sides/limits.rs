//! The numbers of the test of broken loops.

/// A diagnosis that made fewer evaluations does not look at the sides of a break: they would be more than a tenth of all.
pub(super) const MIN_EVALUATIONS_MADE: usize = 400;

/// The same for the flow that leads from one side to the other.
pub(super) const MIN_MADE_FOR_FLOW: usize = 1000;

/// Distance of the nearest states from a break, as a part of the loop. Derived: the curvature of the loop, (2π)² of the square, is
/// below rounding.
pub(super) const MIN_DISTANCE: f64 = 1e-9;

/// The same in units of the uncertainty of its place.
pub(super) const MIN_DISTANCE_IN_UNCERTAINTIES: f64 = 8.0;

/// Distances of further states, which show whether a coordinate is constant. Conventional: three decades.
pub(super) const DISTANCES: [f64; 4] = [1e-6, 1e-5, 1e-4, 1e-3];

/// Coordinates that are kept, and as many partners.
pub(super) const MAX_COORDINATES: usize = 12;

/// Breaks whose positions are compared.
pub(super) const MAX_COMPARED_BREAKS: usize = 8;

/// The step that shows the flow, as a part of h.
pub(super) const FIRST_PART_OF_STEP: f64 = 1.0 / 64.0;

/// A larger part of h does not lead along the flow from one side to the other: a step that chooses its length makes at most all
/// of it.
pub(super) const MAX_PART_OF_STEP: f64 = 1.5;

/// Trials of the secant method.
pub(super) const MAX_SECANT_TRIALS: usize = 6;

/// Parts in which a step along the flow is made, so that the error of a method does not count.
pub(super) const SUBDIVISIONS: usize = 4;

/// The other side is met: the distance as a part of the jump.
pub(super) const MAX_DISTANCE_OVER_JUMP: f64 = 1e-5;

//! The orbit of a particle through a step in given mean fields, where fields and currents are taken on it.

use std::num::NonZeroUsize;

use super::coupling::{Coupling, PathFailure};

/// Where on the orbit of a step fields are gathered and currents deposited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Orbit {
    /// In its middle: the time discretisation of G. Chen, L. Chacón & D. C. Barnes, J. Comput. Phys. 230 (2011) 7018,
    /// without their sub-steps. Theirs adapt, and stop at the faces of cells, which conserves the charge as well as the
    /// energy; a step that stops nowhere conserves the energy alone.
    Midpoint,
    /// In the middle of each of this number of equal sub-steps of the particle. They do not adapt and do not stop at faces, so
    /// that the charge is not conserved.
    SubStepped(NonZeroUsize),
    /// All along the straight way, exactly: the charge is conserved as well (K. Kormann & E. Sonnendrücker, J. Comput.
    /// Phys. 425 (2021) 109890).
    Averaged,
}

/// The means of the fields of a step.
pub(super) struct MeanFields<'a> {
    pub(super) e1: &'a [f64],
    pub(super) e2: &'a [f64],
    pub(super) b: &'a [f64],
}

/// E1, E2 and B as a particle feels them.
#[derive(Clone, Copy, Default)]
pub(super) struct FieldsAtParticle {
    e1: f64,
    e2: f64,
    b: f64,
}

/// Points of a straight way and their weights.
///
/// A way is integrated piece by piece between nodes, where splines of degree up to 5 are polynomials: three points of
/// Gauss are exact.
pub(super) fn along<const N: usize>(
    coupling: &Coupling<N>,
    is_averaged: bool,
    x: f64,
    way: f64,
    mut each: impl FnMut(f64, f64),
) {
    /// √(3/5) and the weights of the rule on [−1, 1], halved.
    const NODE: f64 = 0.774_596_669_241_483_4;
    const OUTER: f64 = 5.0 / 18.0;
    const INNER: f64 = 8.0 / 18.0;
    if !is_averaged || way == 0.0 {
        return each(x + 0.5 * way, 1.0);
    }
    coupling.pieces(x, way, |from, to| {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let share = to - from;
        each(x + way * (middle - NODE * half), OUTER * share);
        each(x + way * middle, INNER * share);
        each(x + way * (middle + NODE * half), OUTER * share);
    });
}

/// The fields on a straight way.
pub(super) fn felt<const N: usize>(
    coupling: &Coupling<N>,
    is_averaged: bool,
    fields: &MeanFields<'_>,
    x: f64,
    way: f64,
) -> FieldsAtParticle {
    let mut felt = FieldsAtParticle::default();
    along(coupling, is_averaged, x, way, |x, weight| {
        let place = coupling.at(x);
        let one = place.one();
        felt.e1 += weight * one.sum(fields.e1);
        felt.e2 += weight * place.zero().sum(fields.e2);
        felt.b += weight * one.sum(fields.b);
    });
    felt
}

/// The mean velocity of a step of size h: v̄ = v + (h q/2m)(E + v̄ × B), which is linear in v̄.
pub(super) fn mean_velocity(v: [f64; 2], felt: FieldsAtParticle, half_charge: f64) -> [f64; 2] {
    let (a1, a2) = (v[0] + half_charge * felt.e1, v[1] + half_charge * felt.e2);
    let t = half_charge * felt.b;
    let factor = 1.0 / (1.0 + t * t);
    [factor * (a1 + t * a2), factor * (a2 - t * a1)]
}

/// Why an orbit was not found.
pub(super) enum OrbitFailure {
    /// An iterate cannot be followed through the cells.
    Path(PathFailure),
    /// So many iterations were not enough.
    NotConverged(usize),
}

/// The mean velocity of a particle that moves by h v̄1 meanwhile, to round-off. The iteration begins at `guess`;
/// `half_charge` is h q/2m.
pub(super) fn solve_orbit<const N: usize>(
    coupling: &Coupling<N>,
    is_averaged: bool,
    fields: &MeanFields<'_>,
    (x, v, guess): (f64, [f64; 2], [f64; 2]),
    (h, half_charge): (f64, f64),
) -> Result<[f64; 2], OrbitFailure> {
    /// An iteration contracts by h² ∂E/∂x, which is well below 1 in steps that resolve the plasma frequency.
    const MAX_ITERATIONS: usize = 100;
    /// Changes that no longer fall are round-off below this part of the velocity.
    const ROUNDOFF: f64 = 1e-13;
    let mut mean = guess;
    let mut least = f64::INFINITY;
    for _ in 0..MAX_ITERATIONS {
        let way = h * mean[0];
        coupling.check_way(x, way).map_err(OrbitFailure::Path)?;
        let felt = felt(coupling, is_averaged, fields, x, way);
        let next = mean_velocity(v, felt, half_charge);
        let change = (next[0] - mean[0]).abs();
        // If a particle turns around, the velocity before sets the rounding.
        let size = [v, next]
            .into_iter()
            .flatten()
            .fold(0.0, |size: f64, v| size.max(v.abs()));
        mean = next;
        // Of a particle that is almost at rest, velocities are rounded less than the place where it feels the field.
        let of_place = f64::EPSILON * x.abs().max(1.0 / coupling.per_length());
        let is_roundoff = change <= ROUNDOFF * size || (h * change).abs() <= of_place;
        if change == 0.0 || change >= least && is_roundoff {
            return Ok(mean);
        }
        least = least.min(change);
    }
    Err(OrbitFailure::NotConverged(MAX_ITERATIONS))
}

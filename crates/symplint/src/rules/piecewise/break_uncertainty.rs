//! How well it is known where the loop breaks, and what that is worth.
//!
//! A break is closed in on until no double lies between, but the map meets rounded states: where what breaks
//! the loop only grazes its threshold, q = q_max − u'' Δs²/2, a rounding of q moves the break far along s. The
//! loop is then broken twice, there and back, close to each other. That moves area from the pieces to the
//! segments that close the breaks; the closed integral does not notice.

use std::f64::consts::PI;

use super::curves::CurvePoint;
use super::limits::{BREAKS_ON_EACH_SIDE, DISTANCE_OF_SLOPES, MAX_DISTANCE_OF_NEIGHBOURS};
use super::refinement::{CurveBreak, Refinement};
use crate::error::Error;
use crate::signal::nearest;

/// A break that may have been somewhere else.
struct UncertainBreak {
    /// Which of the breaks.
    index: usize,
    /// How far it may be moved along s.
    distance: f64,
    /// Outwards of its sides, no other break lies up to this distance.
    free: f64,
}

/// The error of the absolutely continuous integral if breaks are not where they were found.
pub(super) fn break_uncertainty(refinement: &mut Refinement<'_>) -> Result<f64, Error> {
    let uncertain = uncertain(refinement);
    let points: Vec<CurvePoint> = (uncertain.iter())
        .flat_map(|at| {
            let [low, high] = refinement.breaks[at.index].sides;
            [low - at.free, high + at.free]
        })
        .map(|s| CurvePoint::on(0, s.rem_euclid(1.0)))
        .collect();
    for at in &uncertain {
        let found = &mut refinement.breaks[at.index];
        found.uncertainty = found.uncertainty.max(at.distance);
    }
    let outwards = refinement.images(&points, 0)?;
    let (coordinates, dof) = (refinement.coordinates, refinement.coordinates.dof());
    let mut sum = 0.0;
    for i in 0..dof {
        let (period, weight) = (coordinates.period(i), coordinates.weight(i).abs());
        for (at, outwards) in uncertain.iter().zip(outwards.chunks_exact(2)) {
            let found = &refinement.breaks[at.index];
            // The length that a piece has more on the one side of the break, and less on the other.
            let gained = |from: &[f64], to: &[f64]| {
                0.5 * (from[dof + i] + to[dof + i]) * nearest(to[i] - from[i], period)
            };
            let [low, high] = [&found.images[0], &found.images[1]];
            let moved = gained(outwards[0].after(), low.after())
                - gained(high.after(), outwards[1].after());
            sum += weight * moved.abs() * at.distance / at.free;
        }
    }
    Ok(sum)
}

/// The breaks of the loop that may be elsewhere by more than a few doubles.
fn uncertain(refinement: &Refinement<'_>) -> Vec<UncertainBreak> {
    let breaks = &refinement.breaks;
    let mut order: Vec<usize> = (0..breaks.len())
        .filter(|&k| breaks[k].curve == 0)
        .collect();
    order.sort_by(|&x, &y| breaks[x].sides[0].total_cmp(&breaks[y].sides[0]));
    let jumps: Vec<Vec<f64>> = (order.iter())
        .map(|&k| {
            let all = 0..2 * refinement.coordinates.dof();
            let jump = |c| refinement.scales.weight(c) * breaks[k].jump(c, refinement.coordinates);
            all.map(jump).collect()
        })
        .collect();
    let undoes = |k: usize, j: usize| {
        jumps[k]
            .iter()
            .zip(&jumps[j])
            .map(|(x, y)| x * y)
            .sum::<f64>()
            < 0.0
    };
    let count = order.len();
    let gap = |k: usize, j: usize| distance(&breaks[order[k]], &breaks[order[j]]);
    (0..count)
        .filter_map(|k| {
            let after = |j: usize| (k + j) % count;
            let before = |j: usize| (k + count - j) % count;
            let reach = BREAKS_ON_EACH_SIDE.min(count - 1);
            let there = (1..=reach)
                .map(after)
                .find(|&j| undoes(k, j))
                .map(|j| gap(k, j));
            let back = (1..=reach)
                .map(before)
                .find(|&j| undoes(k, j))
                .map(|j| gap(j, k));
            let apart = there.into_iter().chain(back).reduce(f64::min)?;
            // At half that distance from a turning point, a coordinate as curved as the loop, (2π)²
            // times its size, climbs by 2π² times the distance.
            let moved = (refinement.scales.input_rounding / (2.0 * PI * PI * apart)).min(apart);
            let free = DISTANCE_OF_SLOPES
                .min(0.5 * gap(k, after(1)))
                .min(0.5 * gap(before(1), k));
            (moved > MAX_DISTANCE_OF_NEIGHBOURS && free > 0.0).then_some(UncertainBreak {
                index: order[k],
                distance: moved,
                free,
            })
        })
        .collect()
}

/// From the end of a break to the beginning of the next one, once round the loop if need be.
fn distance(from: &CurveBreak, to: &CurveBreak) -> f64 {
    let direct = to.sides[0] - from.sides[1];
    if to.sides[0] < from.sides[0] {
        direct + 1.0
    } else {
        direct
    }
}

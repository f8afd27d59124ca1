//! How well it is known where the loop breaks, and what that is worth.
//!
//! A break is closed in on until no double lies between, but the map meets rounded states: where what breaks
//! the loop only grazes its threshold, q = q_max − u'' Δs²/2, a rounding of q moves the break far along s. The
//! loop is then broken twice, there and back, close to each other. That moves area from the pieces to the
//! segments that close the breaks; the closed integral does not notice.

use std::f64::consts::PI;

use super::NEIGHBOURS;
use super::curves::At;
use super::queue::{Found, Queue};
use crate::error::Error;
use crate::signal::nearest;
use crate::state::coordinate;

/// Breaks looked at on either side of one for its way back.
const REACH: usize = 8;

/// From where the slopes beside a break are taken: far beyond the few doubles in which a map may not know on which
/// side of its threshold it is, where jumps would be taken for slopes.
const FAR: f64 = 1e-6;

/// A break that may have been somewhere else.
struct Doubtful {
    /// Its two sides.
    sides: [f64; 2],
    /// How far it may be moved along s.
    doubt: f64,
    /// So far outwards of its sides there is no other break.
    free: f64,
}

/// What the absolutely continuous integral may be off because breaks are not where they were found.
pub(super) fn doubt_of_places(queue: &mut Queue<'_>) -> Result<f64, Error> {
    let doubtful = doubtful(queue);
    let points: Vec<At> = (doubtful.iter())
        .flat_map(|found| {
            let [low, high] = found.sides;
            [low - found.free, low, high, high + found.free]
        })
        .map(|s| At {
            curve: 0,
            s: s.rem_euclid(1.0),
        })
        .collect();
    if points.is_empty() {
        return Ok(0.0);
    }
    queue.evaluations += points.len();
    let after = queue.curves.images(&points, 0, false)?.after;
    let mut sum = 0.0;
    for i in 0..after.dof() {
        let (q, p) = (coordinate(&after, i), coordinate(&after, after.dof() + i));
        let (period, weight) = (
            queue.coordinates.period(i),
            queue.coordinates.weight(i).abs(),
        );
        for (k, found) in doubtful.iter().enumerate() {
            // What a piece has more on the one side of the break, and less on the other.
            let gained = |a: usize, b: usize| 0.5 * (p[a] + p[b]) * nearest(q[b] - q[a], period);
            let moved = gained(4 * k, 4 * k + 1) - gained(4 * k + 2, 4 * k + 3);
            sum += weight * moved.abs() * found.doubt / found.free;
        }
    }
    Ok(sum)
}

/// The breaks of the loop that may be elsewhere by more than a few doubles.
fn doubtful(queue: &Queue<'_>) -> Vec<Doubtful> {
    let mut breaks: Vec<&Found> = queue.breaks.iter().filter(|b| b.curve == 0).collect();
    breaks.sort_by(|x, y| x.sides[0].total_cmp(&y.sides[0]));
    let along = |x: &Found, y: &Found| -> f64 {
        let terms = x.jumps.iter().zip(&y.jumps).enumerate();
        terms
            .map(|(c, (x, y))| queue.scales.weight(c).powi(2) * x * y)
            .sum()
    };
    let count = breaks.len();
    (0..count)
        .filter_map(|k| {
            let found = breaks[k];
            let after = |j: usize| distance(found, breaks[(k + j) % count]);
            let before = |j: usize| distance(breaks[(k + count - j) % count], found);
            let reach = REACH.min(count - 1);
            let there = (1..=reach).find(|&j| along(found, breaks[(k + j) % count]) < 0.0);
            let back = (1..=reach).find(|&j| along(found, breaks[(k + count - j) % count]) < 0.0);
            let apart = (there.map(after).into_iter().chain(back.map(before)))
                .fold(f64::INFINITY, f64::min);
            // At half that distance from where it turns round, a coordinate as curved as the loop, (2π)²
            // times its size, climbs by 2π² times the distance.
            let doubt = (queue.scales.input_rounding / (2.0 * PI * PI * apart)).min(apart);
            let free = FAR.min(0.5 * after(1)).min(0.5 * before(1));
            (doubt > NEIGHBOURS && free > 0.0).then_some(Doubtful {
                sides: found.sides,
                doubt,
                free,
            })
        })
        .collect()
}

/// From the end of a break to the beginning of the next one, once round the loop if need be.
fn distance(from: &Found, to: &Found) -> f64 {
    let direct = to.sides[0] - from.sides[1];
    if to.sides[0] < from.sides[0] {
        direct + 1.0
    } else {
        direct
    }
}

//! Narrow stretches within stretches, where a solver inside the map stops at a tolerance.
//!
//! Such a map is one of several smooth branches, one for each number of iterations, and the loop breaks where that number
//! changes. Everywhere there the last change of the iterate equals the tolerance, so that all jumps are of one size: the
//! tolerance times the contraction of the iteration. What the next iteration would add goes along a stretch from the jump
//! at its one end to minus the jump at its other. If both jumps point the same way, it passes through zero in between,
//! and there the solver stops an iteration earlier, in a stretch that is narrower by the contraction, and so on. Both breaks
//! of such a stretch add up, and nothing outside shows it: missed, they leave |p| times both jumps in the integral.

use super::limits::{
    NEARER, NEARINGS, NESTED, OF_A_SOLVER, PARTS_OF_STRETCH, WIDEST_PART, WIDEST_STRETCH,
};
use super::piece::Piece;
use super::refinement::Refinement;
use crate::breaks::Break;
use crate::error::Error;
use crate::state::Coordinates;

/// A stretch between neighbouring breaks of the loop, from one to the next; beyond 1 in the next revolution.
struct Stretch {
    ends: [f64; 2],
    /// Which breaks end it.
    breaks: [usize; 2],
}

/// Looks for breaks within stretches between breaks, and within those that are found. Returns what the integral may be
/// off because stretches in which the next iteration passes through zero could not be searched, or are wide.
pub(super) fn search_nested(refinement: &mut Refinement<'_>) -> Result<f64, Error> {
    if !is_of_a_solver(refinement) {
        return Ok(0.0);
    }
    let mut searched: Vec<[f64; 2]> = Vec::new();
    for _ in 0..NESTED {
        let mut pieces = Vec::new();
        let mut now = Vec::new();
        for stretch in stretches(refinement) {
            let [a, b] = stretch.ends;
            // A stretch across s = 0 has two parts.
            let parts = match b > 1.0 {
                true => vec![[a, 1.0], [0.0, b - 1.0]],
                false => vec![[a, b]],
            };
            let parts = parts.into_iter().filter(|[a, b]| a < b);
            let zero = zero_of(refinement, &stretch).rem_euclid(1.0);
            for [a, b] in parts {
                if searched.contains(&[a, b]) {
                    continue;
                }
                let edges = edges([a, b], zero);
                let new: Vec<Piece> = (edges.windows(2))
                    .map(|ends| Piece::new(0, [ends[0], ends[1]], 0, [None, None]))
                    .collect();
                let states = new.iter().map(|part| part.missing_points().count()).sum();
                if refinement.budget.grant(states) {
                    (refinement.smooth)
                        .retain(|piece| piece.curve > 0 || piece.a < a || piece.b > b);
                    pieces.extend(new);
                    now.push([a, b]);
                }
            }
        }
        if pieces.is_empty() {
            break;
        }
        searched.extend(now);
        refinement.run(0, pieces)?;
    }
    let is_searched =
        |[a, b]: [f64; 2]| b - a < WIDEST_STRETCH && (b > 1.0 || searched.contains(&[a, b]));
    let hidden = (stretches(refinement).iter())
        .filter(|stretch| passes_zero(refinement, stretch) && !is_searched(stretch.ends))
        .map(|stretch| of_pair(refinement, stretch))
        .sum();
    Ok(hidden)
}

/// Whether all breaks of the loop are as small as those of a solver.
fn is_of_a_solver(refinement: &Refinement<'_>) -> bool {
    let (scales, coordinates) = (&refinement.scales, refinement.coordinates);
    let mut of_loop = (refinement.breaks.iter())
        .filter(|found| found.curve == 0)
        .peekable();
    let small = |found: &Break| {
        let of = |c: usize, jump: f64| (scales.weight(c) * jump).abs() < OF_A_SOLVER;
        of(found.dof, found.jump_q) && of(coordinates.dof() + found.dof, found.jump_p)
    };
    of_loop.peek().is_some()
        && of_loop.all(|found| found.flickers || small(&found.summary(scales, coordinates)))
}

/// All stretches between neighbouring breaks, in their order.
fn stretches(refinement: &Refinement<'_>) -> Vec<Stretch> {
    let breaks = &refinement.breaks;
    let mut order: Vec<usize> = (0..breaks.len())
        .filter(|&k| breaks[k].curve == 0)
        .collect();
    order.sort_by(|&x, &y| breaks[x].sides[0].total_cmp(&breaks[y].sides[0]));
    let count = order.len();
    (0..count)
        .map(|k| {
            let [this, next] = [order[k], order[(k + 1) % count]];
            let revolution = if k + 1 == count { 1.0 } else { 0.0 };
            Stretch {
                ends: [breaks[this].sides[1], breaks[next].sides[0] + revolution],
                breaks: [this, next],
            }
        })
        .filter(|stretch| stretch.ends[0] < stretch.ends[1])
        .collect()
}

/// The jumps at both ends, in the sizes of the coordinates.
fn jumps(refinement: &Refinement<'_>, stretch: &Stretch) -> [Vec<f64>; 2] {
    let coordinates: &Coordinates = refinement.coordinates;
    stretch.breaks.map(|k| {
        (0..2 * coordinates.dof())
            .map(|c| refinement.scales.weight(c) * refinement.breaks[k].jump(c, coordinates))
            .collect()
    })
}

/// Whether what the next iteration adds passes through zero: the jumps at both ends point the same way.
fn passes_zero(refinement: &Refinement<'_>, stretch: &Stretch) -> bool {
    let [left, right] = jumps(refinement, stretch);
    left.iter().zip(&right).map(|(x, y)| x * y).sum::<f64>() > 0.0
}

/// Where it does so if it is a straight line.
fn zero_of(refinement: &Refinement<'_>, stretch: &Stretch) -> f64 {
    let [left, right] =
        jumps(refinement, stretch).map(|jump| jump.iter().map(|x| x * x).sum::<f64>().sqrt());
    let [a, b] = stretch.ends;
    a + (b - a) * left / (left + right)
}

/// Ends of the parts of a stretch: equal parts, and nearer and nearer to `zero`, so that one of them meets a narrower
/// stretch round it, whatever its width.
fn edges([a, b]: [f64; 2], zero: f64) -> Vec<f64> {
    let parts = PARTS_OF_STRETCH.max(((b - a) / WIDEST_PART).ceil() as usize);
    let mut edges: Vec<f64> = (1..parts)
        .map(|k| a + (b - a) * k as f64 / parts as f64)
        .collect();
    let mut distance = (b - a) / parts as f64;
    for _ in 0..NEARINGS {
        distance *= NEARER;
        edges.extend([zero - distance, zero + distance]);
    }
    edges.retain(|edge| a < *edge && *edge < b);
    edges.extend([a, b]);
    edges.sort_by(f64::total_cmp);
    edges.dedup();
    edges
}

/// What two missed breaks contribute that are as large as those at the ends, |p| times both.
fn of_pair(refinement: &Refinement<'_>, stretch: &Stretch) -> f64 {
    let coordinates = refinement.coordinates;
    let dof = coordinates.dof();
    (0..dof)
        .map(|i| {
            let jumps: f64 = (stretch.breaks.iter())
                .map(|&k| refinement.breaks[k].jump(i, coordinates).abs())
                .sum();
            coordinates.weight(i).abs() * refinement.scales.magnitude[dof + i] * jumps
        })
        .sum()
}

//! Narrow stretches within narrow stretches.
//!
//! A solver that stops at a tolerance does so an iteration earlier where the error of an iterate passes through zero: in a
//! stretch that a break ends on either side. There the iterates converge faster, and within it the solver stops another
//! iteration earlier in a stretch that is narrower by the contraction of the iteration, and so on. Both breaks of a
//! stretch add up, and nothing outside shows it: so each stretch between two such breaks is looked at once more.

use super::limits::{MOST_STRETCHES, PARTS_OF_STRETCH, WIDEST_STRETCH};
use super::piece::Piece;
use super::refinement::Refinement;
use crate::error::Error;

/// Looks for breaks within stretches between breaks, and within those that are found.
pub(super) fn search_stretches(refinement: &mut Refinement<'_>) -> Result<(), Error> {
    let mut searched: Vec<[f64; 2]> = Vec::new();
    for _ in 0..MOST_STRETCHES {
        let stretches: Vec<[f64; 2]> = stretches(refinement)
            .into_iter()
            .filter(|stretch| !searched.contains(stretch))
            .collect();
        if stretches.is_empty() {
            break;
        }
        let mut pieces = Vec::new();
        for &[a, b] in &stretches {
            let edge = |k: usize| match k {
                0 => a,
                PARTS_OF_STRETCH => b,
                _ => a + (b - a) * k as f64 / PARTS_OF_STRETCH as f64,
            };
            let parts: Vec<Piece> = (0..PARTS_OF_STRETCH)
                .map(|k| Piece::new(0, [edge(k), edge(k + 1)], 0, [None, None]))
                .collect();
            let states = parts.iter().map(|part| part.missing_points().count()).sum();
            if !refinement.budget.grant(states) {
                break;
            }
            refinement
                .smooth
                .retain(|piece| piece.curve > 0 || piece.a < a || piece.b > b);
            pieces.extend(parts);
        }
        searched.extend(stretches);
        refinement.run(0, pieces)?;
    }
    Ok(())
}

/// Between neighbouring breaks of the loop that are near to each other, if rounding decides about any: the narrower a
/// stretch is, the more exactly its ends are known.
fn stretches(refinement: &Refinement<'_>) -> Vec<[f64; 2]> {
    let of_loop = || refinement.breaks.iter().filter(|found| found.curve == 0);
    if !of_loop().any(|found| found.flickers) {
        return Vec::new();
    }
    let mut sides: Vec<[f64; 2]> = of_loop().map(|found| found.sides).collect();
    sides.sort_by(|x, y| x[0].total_cmp(&y[0]));
    (sides.windows(2))
        .map(|pair| [pair[0][1], pair[1][0]])
        .filter(|[a, b]| a < b && b - a < WIDEST_STRETCH)
        .collect()
}

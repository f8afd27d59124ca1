//! The noise of a map: that of a solver that stops at a tolerance, of single precision.
//!
//! The sixth difference of a smooth coordinate over a very short stretch is below round-off; what is left is
//! noise (Moré & Wild, "Estimating computational noise", 2011). It is listened for at a few places. Breaks
//! spoil two of five of them at most, so close together are the points of each, and their median counts.

use super::curves::At;
use super::piece::Piece;
use super::scales::period;
use crate::signal::nearest;
use crate::state::Coordinates;
use crate::state::Ensemble;
use crate::state::coordinate;

/// Where it is listened for, as parts of a stretch.
const PLACES: [f64; 5] = [0.137, 0.289, 0.412, 0.643, 0.829];

/// The points of a place, in units of the spacing: not equidistant, or a straight line that is rounded to a grid
/// may well seem to have no noise.
const POINTS: [f64; 7] = [0.0, 0.87, 2.13, 2.95, 4.18, 5.04, 6.0];

/// Distance of the points of a place on the loop.
const SPACING: f64 = 2e-6;

/// Distance of those of a short stretch, as a part of it: so short that among all stretches of a loop that breaks
/// thousands of times none has breaks in three places.
const SPACING_OF_PIECE: f64 = 2e-5;

/// States that are asked for.
pub(super) const LISTENING: usize = PLACES.len() * POINTS.len();

/// The points on a stretch.
pub(super) fn points(piece: &Piece) -> impl Iterator<Item = At> + use<> {
    let Piece { curve, a, .. } = *piece;
    let length = piece.length();
    let spacing = if length < 1.0 {
        SPACING_OF_PIECE * length
    } else {
        SPACING
    };
    PLACES.iter().flat_map(move |place| {
        let first = a + place * length;
        POINTS.iter().map(move |x| At {
            curve,
            s: first + spacing * x,
        })
    })
}

/// Factors of the values at the points that annul polynomials up to the fifth degree, and leave noise as large
/// as it is.
fn sixth_difference() -> [f64; POINTS.len()] {
    let divided = POINTS.map(|x| {
        let others = POINTS.iter().filter(|&&other| other != x);
        1.0 / others.map(|other| x - other).product::<f64>()
    });
    let gain = divided.iter().map(|a| a * a).sum::<f64>().sqrt();
    divided.map(|a| a / gain)
}

/// The noise of each coordinate, from the states at those points, of which `first` is the first.
pub(super) fn of_states(states: &Ensemble, first: usize, coordinates: &Coordinates) -> Vec<f64> {
    let factors = sixth_difference();
    (0..2 * states.dof())
        .map(|c| {
            let row = &coordinate(states, c)[first..first + LISTENING];
            let period = period(coordinates, c);
            let mut noise: Vec<f64> = (row.chunks_exact(POINTS.len()))
                .map(|values| {
                    let terms = values.iter().zip(factors);
                    let counted = |value: f64| nearest(value - values[0], period);
                    (terms.map(|(&value, factor)| factor * counted(value)))
                        .sum::<f64>()
                        .abs()
                })
                .collect();
            noise.sort_by(f64::total_cmp);
            noise[PLACES.len() / 2]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smooth_functions_are_annulled_and_grids_are_not() {
        let factors = sixth_difference();
        let noise = |f: &dyn Fn(f64) -> f64| -> f64 {
            (POINTS.iter().zip(factors))
                .map(|(&x, factor)| factor * f(x))
                .sum::<f64>()
                .abs()
        };
        assert!(noise(&|x| 1.0 + x - 0.3 * x.powi(5)) < 1e-12);
        assert!(noise(&|x| (0.01 * x).sin()) < 1e-12);
        // A straight line on a grid, in steps of any part of it.
        let heard = (0..1000)
            .filter(|k| noise(&|x| (x * (0.3 + 0.0137 * f64::from(*k))).round()) > 0.02)
            .count();
        assert!(heard > 900, "{heard}");
    }
}

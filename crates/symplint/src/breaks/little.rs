//! Jumps that are too small to break a loop.

use super::limits::LEAST_JUMP;
use super::residual::rounding;
use super::search::find_jumps;
use crate::signal::{Extent, UNIT_ROUNDOFF, unwrap_row};
use crate::state::{Coordinates, Ensemble};

/// What jumps too small to break a loop contribute to its integral at most, Σ |p Δq| over the cells in which samples
/// show them; cells with one of the `known` breaks, given by their s, are left out.
pub(crate) fn little_jumps(samples: &Ensemble, coordinates: &Coordinates, known: &[f64]) -> f64 {
    let count = samples.samples();
    let mut is_known = vec![false; count];
    for s in known {
        is_known[(s * count as f64) as usize % count] = true;
    }
    let of_dof = |i: usize| {
        let mut row = samples.q().row(i).to_vec();
        let gain = unwrap_row(&mut row, coordinates.period(i)) as f64 * coordinates.period(i);
        let extent = Extent::of(&row);
        row.push(row[0] + gain);
        let increments: Vec<f64> = row.windows(2).map(|q| q[1] - q[0]).collect();
        let floor = rounding(UNIT_ROUNDOFF * extent.magnitude());
        let little = LEAST_JUMP * extent.length();
        let momenta = samples.p().row(i);
        let jumps = find_jumps(&increments, floor).jumps.into_iter();
        let sizes = jumps
            .filter(|jump| jump.size.abs() <= little && !is_known[jump.cell])
            .map(|jump| (momenta[jump.cell] * jump.size).abs());
        coordinates.weight(i).abs() * sizes.sum::<f64>()
    };
    (0..samples.dof()).map(of_dof).sum()
}

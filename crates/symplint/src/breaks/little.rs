//! Jumps that are too small to break a loop.

use super::limits::MIN_RELATIVE_JUMP;
use super::residual::rounding;
use super::search::find_jumps;
use crate::signal::{Extent, UNIT_ROUNDOFF, unwrap_row};
use crate::state::{Coordinates, Ensemble, in_parallel};

/// What jumps too small to break a loop contribute to its integral at most, Σ |p Δq| over the cells in which samples
/// show them; cells with one of the `known` breaks, given by their s, are left out. Rows are those that
/// [`rows_that_may_jump`](super::rows_that_may_jump) found.
pub(crate) fn little_jumps(
    samples: &Ensemble,
    coordinates: &Coordinates,
    known: &[f64],
    may_jump: &[[bool; 2]],
) -> f64 {
    let count = samples.samples();
    let mut is_known = vec![false; count];
    for s in known {
        is_known[(s * count as f64) as usize % count] = true;
    }
    let of_dof = |i: usize| {
        let (row, period) = (samples.q().row(i), coordinates.period(i));
        let mut row = row.to_vec();
        let gain = unwrap_row(&mut row, period) as f64 * period;
        let extent = Extent::of(&row);
        row.push(row[0] + gain);
        let increments: Vec<f64> = row.windows(2).map(|q| q[1] - q[0]).collect();
        let floor = rounding(UNIT_ROUNDOFF * extent.magnitude());
        let little = MIN_RELATIVE_JUMP * extent.length();
        let momenta = samples.p().row(i);
        let jumps = find_jumps(&increments, floor).jumps.into_iter();
        let sizes = jumps
            .filter(|jump| jump.size.abs() <= little && !is_known[jump.cell])
            .map(|jump| (momenta[jump.cell] * jump.size).abs());
        coordinates.weight(i).abs() * sizes.sum::<f64>()
    };
    let dofs: Vec<usize> = (0..samples.dof()).filter(|&dof| may_jump[dof][0]).collect();
    let of_dofs = in_parallel(dofs, 2 * samples.samples(), of_dof);
    of_dofs.iter().sum()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn jumps_count_by_their_momenta_and_weights_but_for_known_ones_and_large_ones() {
        const SAMPLES: usize = 4096;
        const LITTLE: f64 = 3e-12;
        let period = 1.0;
        // The second position winds twice; cells 1000 and the last one have little jumps, cell 3000 a large one.
        let mut states = Ensemble::zeros(2, SAMPLES);
        for k in 0..SAMPLES {
            let s = k as f64 / SAMPLES as f64;
            let jumps = LITTLE * f64::from(k > 1000) + 1e-3 * f64::from(k > 3000);
            states.block().q.row_mut(0)[k] = (TAU * s).sin();
            states.block().p.row_mut(0)[k] = 1.0;
            states.block().q.row_mut(1)[k] = (2.0 * s + 0.2 * (TAU * s).cos() + jumps
                - (1e-3 + 3.0 * LITTLE) * s)
                .rem_euclid(period);
            states.block().p.row_mut(1)[k] = 2.0 - s;
        }
        let coordinates = Coordinates::plain(2)
            .with_periods(vec![0.0, period])
            .unwrap()
            .with_weights(vec![1.0, -3.0])
            .unwrap();
        let at = |cell: usize| (cell as f64 + 0.5) / SAMPLES as f64;
        // From the last sample to the first the position falls by twice the jump.
        let [first, last] = [3.0 * (2.0 - at(1000)) * LITTLE, 3.0 * 1.0 * 2.0 * LITTLE];
        for (known, expected) in [
            (vec![], first + last),
            (vec![at(1000)], last),
            (vec![at(SAMPLES - 1), at(7)], first),
            (vec![at(1000), at(SAMPLES - 1)], 0.0),
        ] {
            let rows = crate::breaks::rows_that_may_jump(&states, &coordinates);
            let found = little_jumps(&states, &coordinates, &known, &rows);
            let off = (found - expected).abs();
            assert!(
                off < 0.02 * LITTLE,
                "{known:?}: {found:e}, not {expected:e}"
            );
        }
    }
}

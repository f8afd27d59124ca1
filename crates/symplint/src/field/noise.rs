//! How exactly a force is known: its noise over short distances, and differences between evaluations of one state.

use super::integrand::Integrand;
use super::limits::AGAIN;
use crate::error::Error;
use crate::loops::FourierLoop;
use crate::signal::noise::SixthDifferences;

/// Places on the loop: no two of them, nor their mirror images, coincide.
const PLACES: [f64; 2] = [0.137, 0.755];

/// Positions of the states of a row, in spacings. They are not equidistant: stairs whose height divides the spacing would look straight.
const NODES: [f64; 13] = [
    -5.81, -5.23, -3.88, -3.17, -1.83, -0.92, 0.0, 1.13, 2.21, 2.94, 4.27, 4.79, 6.17,
];

/// Spacings, in turns of the loop. The next one is taken if neighbours are equal, as those on one stair of single precision are.
const SPACINGS: [f64; 3] = [2.282e-6, 3.774e-5, 6.18e-4];

/// Neighbours of a row that may be equal.
const MOST_EQUAL: usize = 2;

/// Noise at one place counts no more than this many times that at the other: a jump of the force may lie near one of them.
const MOST: f64 = 16.0;

/// The standard deviation of the power along a velocity that does not change, over short distances on the loop.
///
/// # Errors
/// Those of the force.
pub(super) fn over_short_distances(
    integrand: &Integrand<'_>,
    phase_loop: &FourierLoop,
) -> Result<f64, Error> {
    let differences = SixthDifferences::at(&NODES);
    let mut found = [0.0_f64; PLACES.len()];
    for (place, found) in PLACES.into_iter().zip(&mut found) {
        for spacing in SPACINGS {
            if integrand.evaluator.count().left() < NODES.len() {
                break;
            }
            let s = NODES.map(|node| place + spacing * node);
            let mut row = integrand.power(phase_loop, &s, Some(place), None)?;
            let centre = row[NODES.len() / 2];
            row.iter_mut().for_each(|power| *power -= centre);
            let equal = row.windows(2).filter(|pair| pair[0] == pair[1]).count();
            *found = found.max(differences.root_mean_square(&row));
            if equal <= MOST_EQUAL {
                break;
            }
        }
    }
    let least = found.iter().copied().fold(f64::INFINITY, f64::min);
    let most = found.iter().copied().fold(0.0, f64::max);
    Ok(match least > 0.0 {
        true => most.min(MOST * least),
        false => most,
    })
}

/// The largest difference of the power of a state when it is evaluated again: in reverse order, and alone. `power` is that of
/// equispaced samples.
///
/// # Errors
/// Those of the force.
pub(super) fn of_repetitions(
    integrand: &Integrand<'_>,
    phase_loop: &FourierLoop,
    power: &[f64],
) -> Result<f64, Error> {
    let every = power.len() / AGAIN;
    let again: Vec<usize> = (0..AGAIN).rev().map(|k| k * every + k % 2).collect();
    let calls = [&again[..], &again[..1], &again[AGAIN - 1..]];
    let mut largest = 0.0_f64;
    for call in calls {
        let s: Vec<f64> = (call.iter())
            .map(|&k| k as f64 / power.len() as f64)
            .collect();
        let found = integrand.power(phase_loop, &s, None, None)?;
        for (k, found) in call.iter().zip(found) {
            largest = largest.max((found - power[*k]).abs());
        }
    }
    Ok(largest)
}

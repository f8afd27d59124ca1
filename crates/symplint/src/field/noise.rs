//! How exactly a force is known: its noise over short distances, and differences between evaluations of one state.

use super::integrand::Integrand;
use super::limits::REPEATED_STATES;
use crate::error::Error;
use crate::loops::FourierLoop;
use crate::signal::noise::{NODES_BESIDE, Noise, of_a_row};
use crate::signal::parameter;

/// Spacings, in turns of the loop. The next one is taken if neighbours are equal, as those on one stair of single precision are.
const SPACINGS: [f64; 3] = [2.282e-6, 3.774e-5, 6.18e-4];

/// The standard deviation of the power along a velocity that does not change, over short distances on the loop.
///
/// # Errors
/// Those of the force.
pub(super) fn over_short_distances(
    integrand: &Integrand<'_>,
    phase_loop: &FourierLoop,
) -> Result<f64, Error> {
    let of_a_row = of_a_row();
    let mut found = [0.0_f64; 2];
    for (place, found) in (0..).map(parameter).zip(&mut found) {
        let mut noise = Noise::default();
        for spacing in SPACINGS {
            if noise.resolved || integrand.evaluator.count().left() <= NODES_BESIDE.len() {
                break;
            }
            let nodes = std::iter::once(0.0).chain(NODES_BESIDE);
            let s: Vec<f64> = nodes.map(|node| place + spacing * node).collect();
            let power = integrand.power(phase_loop, &s, Some(place), None)?;
            noise.add(&of_a_row, std::array::from_fn(|k| power[k + 1] - power[0]));
        }
        *found = noise.value().unwrap_or(0.0);
    }
    Ok(found[0].max(found[1]))
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
    let every = power.len() / REPEATED_STATES;
    let again: Vec<usize> = (0..REPEATED_STATES)
        .rev()
        .map(|k| k * every + k % 2)
        .collect();
    let calls = [&again[..], &again[..1], &again[REPEATED_STATES - 1..]];
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

//! What rounding makes of a step: how far its results move if the state is moved by roundings.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;

use super::repeats::Repeats;
use crate::error::Error;
use crate::map::Evaluator;
use crate::signal::{nearest, unit};
use crate::state::{Ensemble, coordinate, coordinate_mut, period};

/// States are moved by this many roundings, so that noise of the map is small compared with the motion.
const DISPLACEMENT_IN_ROUNDINGS: f64 = 4096.0;

/// Directions in which each state is moved.
const DIRECTIONS: usize = 6;

/// Results differ by at most this many times what one rounding of the state makes of them: sums in another order, layer
/// upon layer. Calibrated: stiffness matrices and networks of up to 400 degrees of freedom and 4 layers have 40.
const MAX_ROUNDINGS_INSIDE: f64 = 128.0;

/// Differences of results in any order of sums, for each coordinate: ε |∂Φ| |z|, by finite differences.
///
/// # Errors
/// Those of the map.
pub(super) fn roundings_inside(
    evaluator: &Evaluator<'_>,
    repeats: &Repeats,
    states: [usize; 2],
) -> Result<Vec<f64>, Error> {
    let dof = repeats.before.dof();
    let relative = repeats.unit(evaluator);
    let group = 1 + DIRECTIONS;
    let random = &mut ChaCha8Rng::seed_from_u64(0);
    let mut moved = Ensemble::zeros(dof, states.len() * group);
    for c in 0..2 * dof {
        let row = coordinate(&repeats.before, c);
        let mut block = moved.block();
        for (k, value) in coordinate_mut(&mut block, c).iter_mut().enumerate() {
            let (state, direction) = (states[k / group], k % group);
            let part = match direction {
                0 => 0.0,
                _ => 2.0 * unit(random) - 1.0,
            };
            *value = row[state] * (1.0 + part * DISPLACEMENT_IN_ROUNDINGS * relative);
        }
    }
    evaluator.advance(&mut moved, repeats.h)?;
    // The median: a state that is moved across a break moves by more.
    let of_state = |c: usize, first: usize| {
        let row = &coordinate(&moved, c)[first..first + group];
        let period = period(evaluator.coordinates(), c);
        let mut by: Vec<f64> = (row[1..].iter())
            .map(|x| nearest(x - row[0], period).abs() / DISPLACEMENT_IN_ROUNDINGS)
            .collect();
        by.sort_by(f64::total_cmp);
        by[DIRECTIONS / 2]
    };
    let of = |c: usize| of_state(c, 0).max(of_state(c, group));
    let by: Vec<f64> = (0..2 * dof).map(of).collect();
    // All coordinates together: the error of one may vanish at two states.
    let squares: f64 = (0..2 * dof)
        .filter(|&c| repeats.magnitude(c) > 0.0)
        .map(|c| (by[c] / repeats.magnitude(c)).powi(2))
        .sum();
    let typical = (squares / (2 * dof) as f64).sqrt().max(0.25 * relative);
    let most = |c: usize| MAX_ROUNDINGS_INSIDE * by[c].max(typical * repeats.magnitude(c));
    Ok((0..2 * dof).map(most).collect())
}

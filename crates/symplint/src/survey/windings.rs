//! Which periods a loop winds round.

use crate::error::Error;
use crate::loops::{FEW_SAMPLES, Loop};
use crate::signal::Turns;
use crate::state::{Coordinates, Ensemble, coordinate, period};

/// The degrees of freedom whose position gains whole periods round the loop.
///
/// # Errors
/// If a momentum is periodic, and it or its position gains whole periods.
pub(crate) fn wound(phase_loop: &dyn Loop, coordinates: &Coordinates) -> Result<Vec<usize>, Error> {
    let dof = coordinates.dof();
    let periodic: Vec<usize> = (0..2 * dof)
        .filter(|&c| period(coordinates, c) > 0.0)
        .collect();
    if periodic.is_empty() {
        return Ok(Vec::new());
    }
    let mut first = Vec::new();
    let mut turns = vec![Turns::default(); periodic.len()];
    Ensemble::in_parts(phase_loop, FEW_SAMPLES, |part| {
        if first.is_empty() {
            first.extend(periodic.iter().map(|&c| coordinate(&part, c)[0]));
        }
        for (&c, turns) in periodic.iter().zip(&mut turns) {
            for &value in coordinate(&part, c) {
                turns.unwrap(value, period(coordinates, c));
            }
        }
        Ok(())
    })?;
    // Back to the first sample.
    let returns = turns.iter_mut().zip(&first).zip(&periodic);
    let winding = returns.filter_map(|((turns, &value), &c)| {
        turns.unwrap(value, period(coordinates, c));
        (turns.turns != 0.0).then_some(c)
    });
    let winding: Vec<usize> = winding.collect();
    match winding
        .iter()
        .map(|c| c % dof)
        .find(|&i| coordinates.momentum_period(i) > 0.0)
    {
        Some(dof) => Err(Error::WindsRoundTorus { dof }),
        None => Ok(winding),
    }
}

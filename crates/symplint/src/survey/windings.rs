//! Which periods a loop winds round.

use crate::error::Error;
use crate::loops::Loop;
use crate::signal::Turns;
use crate::state::{Coordinates, Ensemble};

/// The degrees of freedom whose position gains whole periods round the loop.
pub(crate) fn wound(phase_loop: &dyn Loop, coordinates: &Coordinates) -> Result<Vec<usize>, Error> {
    const SAMPLES: usize = 64;
    let dof = coordinates.dof();
    if (0..dof).all(|i| coordinates.period(i) == 0.0) {
        return Ok(Vec::new());
    }
    let mut first = Vec::new();
    let mut turns = vec![Turns::default(); dof];
    Ensemble::in_parts(phase_loop, SAMPLES, |part| {
        let q = part.q();
        if first.is_empty() {
            first.extend((0..dof).map(|i| q.row(i)[0]));
        }
        for (i, turns) in turns.iter_mut().enumerate() {
            for &q in q.row(i) {
                turns.unwrap(q, coordinates.period(i));
            }
        }
        Ok(())
    })?;
    // Back to the first sample.
    let returns = turns.iter_mut().zip(&first).enumerate();
    let winding = returns.filter_map(|(i, (turns, &q))| {
        turns.unwrap(q, coordinates.period(i));
        (turns.turns != 0.0).then_some(i)
    });
    Ok(winding.collect())
}

//! Whether a step ignores its size.

use crate::error::Error;
use crate::map::Evaluator;
use crate::state::{Ensemble, coordinate};

/// Whether a state of the given loop, which the step moves, has the same result at all step sizes, to the last bit.
///
/// # Errors
/// If the map wants no more evaluations.
pub(super) fn ignores_step_size(evaluator: &Evaluator<'_>, sizes: &[f64]) -> Result<bool, Error> {
    let kept = evaluator.witnesses();
    let Some(kept) = kept.iter().find(|kept| kept.is_of_given_loop()) else {
        return Ok(false);
    };
    let others: Vec<f64> = sizes.iter().copied().filter(|&h| h != kept.h).collect();
    if others.is_empty() || others.len() > evaluator.count().left() {
        return Ok(false);
    }
    let last = kept.rows.len() - 1;
    let is_after = |states: &Ensemble, k: usize| {
        (0..2 * states.dof()).all(|c| {
            coordinate(states, c)[k].to_bits() == coordinate(&kept.after, c)[last].to_bits()
        })
    };
    if is_after(&kept.before, last) {
        return Ok(false);
    }
    for h in others {
        let mut state = kept.before.clone().block().copy_of(last..last + 1);
        match evaluator.advance(&mut state, h) {
            Ok(()) if is_after(&state, 0) => {}
            Err(Error::Stopped) => return Err(Error::Stopped),
            Ok(()) | Err(_) => return Ok(false),
        }
    }
    Ok(true)
}

//! Quantities that a scheme conserves over a run.

use symplint::state::Rows;
use symplint::{Ensemble, TimeAdvance};

use super::plasma::Plasma;
use crate::error::PaperError;

/// The largest changes of energy and momentum in a run.
#[derive(Clone, Copy, Debug)]
pub struct Conservation {
    /// The spread of the energy, relative to the initial one, in the first and in the second half of the run.
    pub energy: [f64; 2],
    /// The largest residual of Gauss' law.
    pub gauss: Option<f64>,
    /// Of the momentum along x.
    pub momentum: f64,
}

/// Follows one state for `time` in steps of size `h`.
pub fn follow(
    plasma: &Plasma,
    map: &dyn TimeAdvance,
    (q, p): (&[f64], &[f64]),
    (h, time): (f64, f64),
) -> Result<Conservation, PaperError> {
    let mut ensemble = Ensemble::zeros(q.len(), 1);
    let mut block = ensemble.block();
    for i in 0..q.len() {
        (block.q.row_mut(i)[0], block.p.row_mut(i)[0]) = (q[i], p[i]);
    }
    let start = plasma.invariants(q, p);
    let mut changes = Conservation {
        energy: [0.0; 2],
        gauss: start.gauss,
        momentum: 0.0,
    };
    let steps = (time / h).round() as usize;
    for step in 0..steps {
        ensemble.advance(map, h)?;
        let block = ensemble.block();
        let column = |rows: Rows<'_>| (0..q.len()).map(|i| rows.row(i)[0]).collect::<Vec<_>>();
        let now = plasma.invariants(&column(block.q.as_rows()), &column(block.p.as_rows()));
        let largest = |so_far: f64, change: f64| so_far.max(change.abs());
        let half = &mut changes.energy[usize::from(2 * step >= steps)];
        *half = largest(*half, now.energy / start.energy - 1.0);
        changes.momentum = largest(changes.momentum, now.momentum - start.momentum);
        changes.gauss = (changes.gauss.zip(now.gauss)).map(|(so_far, now)| so_far.max(now));
    }
    Ok(changes)
}

//! Values of a periodic coordinate one by one, and windings.

use crate::error::Error;
use crate::loops::Loop;
use crate::state::{Coordinates, Ensemble};

/// Whether a position gains whole periods round the loop.
pub(crate) fn winds(phase_loop: &dyn Loop, coordinates: &Coordinates) -> Result<bool, Error> {
    const SAMPLES: usize = 64;
    let dof = coordinates.dof();
    if (0..dof).all(|i| coordinates.period(i) == 0.0) {
        return Ok(false);
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
    let mut winding = returns.map(|(i, (turns, &q))| {
        turns.unwrap(q, coordinates.period(i));
        turns.turns
    });
    Ok(winding.any(|turns| turns != 0.0))
}

/// Unwraps a run of values one by one, as [`unwrap_row`](crate::signal::unwrap_row) does a row.
#[derive(Clone, Copy, Default)]
pub(super) struct Turns {
    previous: Option<f64>,
    turns: f64,
}

impl Turns {
    pub fn unwrap(&mut self, wrapped: f64, period: f64) -> f64 {
        if period > 0.0 {
            if let Some(previous) = self.previous {
                self.turns -= ((wrapped - previous) / period).round();
            }
            self.previous = Some(wrapped);
        }
        wrapped + self.turns * period
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::unwrap_row;

    #[test]
    fn values_are_unwrapped_as_rows_are() {
        for period in [0.0, 1.0, 0.37] {
            let row: Vec<f64> = (0..100).map(|k| f64::from(k * k % 17) * 0.083).collect();
            let mut unwrapped = row.clone();
            unwrap_row(&mut unwrapped, period);
            let mut turns = Turns::default();
            let one_by_one: Vec<f64> = row.iter().map(|&x| turns.unwrap(x, period)).collect();
            assert_eq!(one_by_one, unwrapped);
        }
    }
}

//! What a loop and a step are like, from a few samples: windings, deformation.

use crate::error::Error;
use crate::loops::Loop;
use crate::signal::Extent;
use crate::state::Coordinates;
use crate::state::Ensemble;

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

/// How much one step deforms a loop, relative to its size: the largest motion of a coordinate against
/// the mean motion, over half the coordinate's range on the loop, from a few samples.
///
/// A translation deforms nothing, and no defect can come of it.
pub(super) struct Deformation {
    motions: Vec<[Motion; 2]>,
}

impl Deformation {
    /// No samples yet.
    pub fn new(dof: usize) -> Self {
        Deformation {
            motions: vec![[Motion::default(); 2]; dof],
        }
    }

    /// Takes in samples before and after the step.
    pub fn add(&mut self, before: &Ensemble, after: &Ensemble, coordinates: &Coordinates) {
        for (i, [of_q, of_p]) in self.motions.iter_mut().enumerate() {
            of_q.add(before.q().row(i), after.q().row(i), coordinates.period(i));
            of_p.add(before.p().row(i), after.p().row(i), 0.0);
        }
    }

    /// The deformation, if it is a number.
    pub fn value(&self) -> Option<f64> {
        let of_all = self.motions.iter().flatten().map(Motion::relative);
        Some(of_all.fold(0.0, f64::max)).filter(|value| value.is_finite())
    }
}

/// Largest distance between the motions of two samples, over the range of the coordinate; motions are
/// counted modulo `period`, if there is one.
pub(crate) fn motion(before: &[f64], after: &[f64], period: f64) -> f64 {
    let mut motion = Motion::default();
    motion.add(before, after, period);
    motion.relative()
}

/// The motion of one coordinate, sample by sample.
#[derive(Clone, Copy, Default)]
struct Motion {
    before: Extent,
    of_motion: Extent,
    turns: Turns,
}

impl Motion {
    fn add(&mut self, before: &[f64], after: &[f64], period: f64) {
        for (a, b) in before.iter().zip(after) {
            self.before.include(*a);
            self.of_motion.include(self.turns.unwrap(b - a, period));
        }
    }

    fn relative(&self) -> f64 {
        let size = self.before.length();
        if size > 0.0 {
            self.of_motion.length() / size
        } else {
            0.0
        }
    }
}

/// Unwraps a run of values one by one, as [`unwrap_row`](crate::signal::unwrap_row) does a row.
#[derive(Clone, Copy, Default)]
struct Turns {
    previous: Option<f64>,
    turns: f64,
}

impl Turns {
    fn unwrap(&mut self, wrapped: f64, period: f64) -> f64 {
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

    #[test]
    fn what_moves_as_one_is_not_deformed() {
        let before = [0.0, 1.0, 0.5, 0.25];
        let shifted = before.map(|x| x + 8.0);
        assert_eq!(motion(&before, &shifted, 0.0), 0.0);
        let stretched = before.map(|x| 1.5 * x);
        assert_eq!(motion(&before, &stretched, 0.0), 0.5);
        // Half of it goes once round a box of length 8.
        let wrapped = [8.0, 1.0, 8.5, 0.25];
        assert_eq!(motion(&before, &wrapped, 8.0), 0.0);
        assert_eq!(motion(&[1.0; 3], &[1.0, 2.0, 3.0], 0.0), 0.0);
    }
}

//! Whether a map is a map: the same state must come of the same state, whatever was advanced before
//! or beside it.

use crate::error::Error;
use crate::loops::Loop;
use crate::map::Evaluator;
use crate::state::Ensemble;

/// Differences below this many roundings are another order of the same arithmetic: vector instructions and
/// their remainders need not agree to the last bit.
const ROUNDINGS: f64 = 256.0;

/// Advances some samples in their order, in reverse, one of them twice, and each alone.
///
/// # Errors
/// [`Error::Memory`] where a sample comes out differently, and those of a map that fails where it did not
/// before. One that fails at once is left to the measurement.
pub(crate) fn check_purity(
    evaluator: &Evaluator<'_>,
    phase_loop: &dyn Loop,
    h: f64,
    samples: usize,
) -> Result<(), Error> {
    // Off any symmetry of the loop.
    let s: Vec<f64> = (0..samples)
        .map(|k| (k as f64 + 0.31) / samples as f64)
        .collect();
    let reversed: Vec<f64> = s.iter().rev().copied().collect();
    let twice = [s[0], s[0], s[1], s[0]];
    let Ok(forward) = evaluator.image(phase_loop, h, &s) else {
        return Ok(());
    };
    let differs = |circumstance: &'static str, states: &Ensemble, from: usize, sample: usize| {
        match difference(&forward, sample, states, from) {
            None => Ok(()),
            Some((dof, difference)) => Err(Error::Memory {
                circumstance,
                s: s[sample],
                dof,
                difference,
                step_size: h,
            }),
        }
    };
    let backward = evaluator.image(phase_loop, h, &reversed)?;
    for k in 0..samples {
        differs("in reverse order", &backward, samples - 1 - k, k)?;
    }
    let repeated = evaluator.image(phase_loop, h, &twice)?;
    for k in [0, 1, 3] {
        differs("when it is repeated", &repeated, k, 0)?;
    }
    for k in 0..samples {
        let alone = evaluator.image(phase_loop, h, &s[k..=k])?;
        differs("alone, outside a block", &alone, 0, k)?;
    }
    Ok(())
}

/// The degree of freedom in which two states differ by more than rounding, and by how much.
fn difference(a: &Ensemble, i: usize, b: &Ensemble, j: usize) -> Option<(usize, f64)> {
    for (a, b) in [(a.q(), b.q()), (a.p(), b.p())] {
        for dof in 0..a.count() {
            let (x, y) = (a.row(dof)[i], b.row(dof)[j]);
            let largest = a.row(dof).iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            if (x - y).abs() > ROUNDINGS * f64::EPSILON * largest {
                return Some((dof, (x - y).abs()));
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loops::Circle;
    use crate::map::{EvaluationCount, PerSample, StepFailure, TimeAdvance};
    use crate::state::Block;
    use std::sync::atomic::{AtomicU64, Ordering};

    fn verdict(map: &dyn TimeAdvance) -> Result<(), Error> {
        let count = EvaluationCount::unlimited();
        let evaluator = Evaluator::new(map, &count)?;
        check_purity(
            &evaluator,
            &Circle::new(vec![0.3], vec![0.5], 1.0).unwrap(),
            0.25,
            16,
        )
    }

    #[test]
    fn an_honest_map_passes() {
        let map = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
            p[0] -= h * q[0].sin();
            q[0] += h * p[0];
        });
        assert_eq!(verdict(&map), Ok(()));
    }

    #[test]
    fn a_map_with_memory_is_refused() {
        // A thermostat that all samples share.
        let heat = AtomicU64::new(0.0f64.to_bits());
        let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
            let friction = f64::from_bits(heat.load(Ordering::Relaxed));
            p[0] -= h * (q[0].sin() + friction * p[0]);
            q[0] += h * p[0];
            heat.store(
                (friction + 1e-3 * (p[0] * p[0] - 1.0)).to_bits(),
                Ordering::Relaxed,
            );
        });
        let error = verdict(&map).unwrap_err();
        assert!(matches!(error, Error::Memory { .. }));
        assert!(error.to_string().contains("reverse order"), "{error}");
    }

    #[test]
    fn a_map_that_mixes_the_samples_of_a_block_is_refused() {
        struct Mean;
        impl TimeAdvance for Mean {
            fn dof(&self) -> usize {
                1
            }
            fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
                let q = block.q.row(0);
                let mean = q.iter().sum::<f64>() / q.len() as f64;
                for p in block.p.row_mut(0) {
                    *p -= h * mean;
                }
                Ok(())
            }
        }
        let error = verdict(&Mean).unwrap_err();
        assert!(matches!(error, Error::Memory { .. }), "{error}");
    }
}

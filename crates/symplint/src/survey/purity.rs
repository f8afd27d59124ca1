//! Whether a map is a map: the same state must come of the same state, whatever was advanced before
//! or beside it.

use super::scatter::scatter;
use crate::error::Error;
use crate::evidence::Scatter;
use crate::loops::Loop;
use crate::map::Evaluator;
use crate::signal::Extent;
use crate::state::{Ensemble, coordinate};

/// Differences below this many roundings are another order of the same arithmetic: vector instructions and
/// their remainders need not agree to the last bit.
const ROUNDINGS: f64 = 256.0;

/// Advances some samples in their order, in reverse, one of them twice, and each alone. Where results differ by chance, as
/// sums do that many cores take in any order, the largest scatter of a coordinate is returned.
///
/// # Errors
/// [`Error::Memory`] where the same state is advanced to different ones, and the differences are not random; those of a map that
/// fails.
pub(crate) fn check_purity(
    evaluator: &Evaluator<'_>,
    phase_loop: &dyn Loop,
    h: f64,
    samples: usize,
) -> Result<Option<Scatter>, Error> {
    // Off any symmetry of the loop.
    let s: Vec<f64> = (0..samples)
        .map(|k| (k as f64 + 0.31) / samples as f64)
        .collect();
    let reversed: Vec<f64> = s.iter().rev().copied().collect();
    let twice = [s[0], s[0], s[1], s[0]];
    let forward = evaluator.image(phase_loop, h, &s)?;
    let sets = [&reversed[..], &twice].into_iter().chain(s.chunks(1));
    evaluator.prefetch_images(phase_loop, h, sets);
    let mut worst: Option<(f64, Difference, Error)> = None;
    let mut differs =
        |circumstance: &'static str, states: &Ensemble, from: usize, sample: usize| {
            let Some(found) = difference(&forward, sample, states, from) else {
                return;
            };
            if worst
                .as_ref()
                .is_none_or(|(most, ..)| found.relative > *most)
            {
                let error = Error::Memory {
                    circumstance,
                    s: s[sample],
                    dof: found.coordinate % forward.dof(),
                    difference: found.size,
                    step_size: evaluator.stated(h),
                };
                worst = Some((found.relative, found, error));
            }
        };
    let backward = evaluator.image(phase_loop, h, &reversed)?;
    for k in 0..samples {
        differs("in reverse order", &backward, samples - 1 - k, k);
    }
    let repeated = evaluator.image(phase_loop, h, &twice)?;
    for k in [0, 1, 3] {
        differs("when it is repeated", &repeated, k, 0);
    }
    for k in 0..samples {
        let alone = evaluator.image(phase_loop, h, &s[k..=k])?;
        differs("alone, outside a block", &alone, 0, k);
    }
    let Some((_, found, error)) = worst else {
        return Ok(None);
    };
    let sites = [s[0], s[1], s[samples / 2]];
    let of = (found.coordinate, found.size);
    let scatters = scatter(evaluator, phase_loop, h, sites, of)?.ok_or(error)?;
    let range = |c: usize| {
        let mut extent = Extent::default();
        coordinate(&forward, c)
            .iter()
            .for_each(|&x| extent.include(x));
        extent.length()
    };
    let parts = scatters.iter().enumerate().filter(|(c, _)| range(*c) > 0.0);
    let largest = parts.max_by(|a, b| (a.1 / range(a.0)).total_cmp(&(b.1 / range(b.0))));
    Ok(largest.map(|(c, &size)| Scatter {
        coordinate: if c < forward.dof() { 'q' } else { 'p' },
        dof: c % forward.dof(),
        size,
    }))
}

/// By how much two states differ.
struct Difference {
    /// The coordinate with the largest relative difference.
    coordinate: usize,
    size: f64,
    /// In units of the largest value of the coordinate.
    relative: f64,
}

/// How two states differ, if it is by more than rounding.
fn difference(a: &Ensemble, i: usize, b: &Ensemble, j: usize) -> Option<Difference> {
    let of = |c: usize| {
        let largest = coordinate(a, c)
            .iter()
            .fold(0.0, |m: f64, v| m.max(v.abs()));
        let size = (coordinate(a, c)[i] - coordinate(b, c)[j]).abs();
        (size > ROUNDINGS * f64::EPSILON * largest).then_some(Difference {
            coordinate: c,
            size,
            relative: size / largest,
        })
    };
    let found = (0..2 * a.dof()).filter_map(of);
    found.max_by(|a, b| a.relative.total_cmp(&b.relative))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loops::Circle;
    use crate::map::{EvaluationCount, PerSample, StepFailure, TimeAdvance};
    use crate::state::Block;
    use std::sync::atomic::{AtomicU64, Ordering};

    fn verdict(map: &dyn TimeAdvance) -> Result<Option<Scatter>, Error> {
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
        assert_eq!(verdict(&map), Ok(None));
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

    /// A pendulum whose force has an error: of `size` times what the count of calls, and the last state, make of it.
    fn pendulum(size: f64, error: impl Fn(u64, f64) -> f64 + Send + Sync) -> impl TimeAdvance {
        let (calls, last) = (AtomicU64::new(0), AtomicU64::new(0));
        PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
            let count = calls.fetch_add(1, Ordering::Relaxed);
            let before = f64::from_bits(last.swap(q[0].to_bits(), Ordering::Relaxed));
            p[0] -= h * (q[0].sin() + size * error(count, before));
            q[0] += h * p[0];
        })
    }

    #[test]
    fn chance_is_no_memory() {
        // A number between −1 and 1 that the count of calls scrambles (splitmix64).
        let scrambled = |count: u64| {
            let mut x = count.wrapping_mul(0x9E37_79B9_7F4A_7C15);
            x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            (x ^ (x >> 31)) as f64 / u64::MAX as f64 * 2.0 - 1.0
        };
        for size in [1e-12, 1e-9, 1e-6] {
            let found = verdict(&pendulum(size, |count, _| scrambled(count))).unwrap();
            let scatter = found.unwrap().size / (0.25 * size);
            assert!((0.3..1.0).contains(&scatter), "{size}: {scatter}");
        }
        // What depends on the count, the last state, or both by chance and by history, is a memory.
        let memories: [&(dyn Fn(u64, f64) -> f64 + Sync); 3] = [
            &|count, _| count as f64 / 64.0,
            &|_, before| before,
            &|count, before| 10.0 * before + scrambled(count),
        ];
        for error in memories {
            for size in [1e-12, 1e-9, 1e-6] {
                let found = verdict(&pendulum(size, error));
                assert!(matches!(found, Err(Error::Memory { .. })), "{found:?}");
            }
        }
    }
}

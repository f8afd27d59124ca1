//! Ensembles of the samples of a loop.

use super::Loop;
use crate::error::Error;
use crate::state::{Block, Ensemble, SMALL_MEMORY, first_error, first_not_finite, in_parallel};

impl Ensemble {
    /// The samples γ(k/N_s), k = 0 … N_s − 1, of a loop.
    ///
    /// # Errors
    /// If `samples` is less than 3, the ensemble is beyond all memory, or the loop is not finite
    /// somewhere.
    pub fn sample(phase_loop: &dyn Loop, samples: usize) -> Result<Self, Error> {
        if samples < 3 {
            return Err(Error::TooFewSamples { samples });
        }
        Self::sample_at(phase_loop, 0, samples, |k| k as f64 / samples as f64)
    }

    /// The samples γ((k + ½)/N_s), k = 0 … N_s − 1: what is missing for twice as many.
    ///
    /// # Errors
    /// Those of [`sample`](Self::sample).
    pub(crate) fn sample_between(phase_loop: &dyn Loop, samples: usize) -> Result<Self, Error> {
        let twice = 2 * samples;
        Self::sample_at(phase_loop, 0, samples, |k| {
            (2 * k + 1) as f64 / twice as f64
        })
    }

    /// Shows the same samples in ensembles of a few, in their order: for what a glance at each is enough.
    ///
    /// # Errors
    /// The same, and those of `visit`.
    pub(crate) fn in_parts(
        phase_loop: &dyn Loop,
        samples: usize,
        mut visit: impl FnMut(Ensemble) -> Result<(), Error>,
    ) -> Result<(), Error> {
        // Unless a block of a few samples needs more.
        let count = (SMALL_MEMORY / (16 * phase_loop.dof().max(1))).clamp(8, samples);
        for first in (0..samples).step_by(count) {
            let count = count.min(samples - first);
            let at = |k: usize| k as f64 / samples as f64;
            visit(Self::sample_at(phase_loop, first, count, at)?)?;
        }
        Ok(())
    }

    /// The states γ(`at`(k)) of `count` samples k from `first` on.
    fn sample_at(
        phase_loop: &dyn Loop,
        first: usize,
        count: usize,
        at: impl Fn(usize) -> f64 + Sync,
    ) -> Result<Self, Error> {
        Self::check_size(phase_loop.dof(), count)?;
        let mut ensemble = Self::zeros(phase_loop.dof(), count);
        ensemble.put_samples(phase_loop, first, at)?;
        Ok(ensemble)
    }

    /// Replaces all states by the [samples](Self::sample) of a loop with the same number of degrees of freedom.
    ///
    /// # Errors
    /// If the loop is not finite somewhere.
    pub(crate) fn fill_with_samples(&mut self, phase_loop: &dyn Loop) -> Result<(), Error> {
        let samples = self.samples();
        self.put_samples(phase_loop, 0, |k| k as f64 / samples as f64)
    }

    fn put_samples(
        &mut self,
        phase_loop: &dyn Loop,
        first: usize,
        at: impl Fn(usize) -> f64 + Sync,
    ) -> Result<(), Error> {
        let width = Self::block_width(self.dof());
        let each = |(b, mut block): (usize, Block<'_>)| {
            block.gathered(|block| sample_block(phase_loop, &at, first + b * width, block))
        };
        let numbers = 2 * self.dof() * width;
        let blocks = self.blocks().into_iter().enumerate();
        first_error(in_parallel(blocks, numbers, each))
    }
}

/// Writes the samples γ(k/N_s), k = `first`, `first` + 1, …, of a loop into a block.
///
/// # Errors
/// If the loop is not finite somewhere.
pub(crate) fn sample_block(
    phase_loop: &dyn Loop,
    at: impl Fn(usize) -> f64,
    first: usize,
    block: &mut Block<'_>,
) -> Result<(), Error> {
    let s: Vec<f64> = (0..block.len()).map(|k| at(first + k)).collect();
    phase_loop.sample(&s, block);
    match first_not_finite(block.q.as_rows(), block.p.as_rows()) {
        None => Ok(()),
        Some(found) => Err(found.into_error(first, None)),
    }
}

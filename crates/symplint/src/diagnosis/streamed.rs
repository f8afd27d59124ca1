//! Diagnoses of more degrees of freedom than memory holds ensembles of.

use super::doubling::Doubling;
use super::probe::{Measured, Method, Probe, Subject};
use super::resolve::{MOST, MOST_BYTES, fewest_samples, power_below};
use super::{Diagnostic, SampleCount};
use crate::error::Error;
use crate::rules::Defect;
use crate::rules::Streaming;

/// Coordinates that the map may be made to advance for one loop integral, where nobody asked for the number of
/// samples: a thousand samples in a million degrees of freedom.
const MOST_STREAMED: usize = 1 << 30;

/// Samples of the smallest ensembles that a diagnosis makes besides the one that it measures with.
pub(crate) const SMALL: usize = 64;

/// Whether an ensemble of so many samples may be made without being asked for.
pub(crate) fn fits(dof: usize, samples: usize) -> bool {
    samples.saturating_mul(dof) <= MOST_BYTES / 16
}

impl Probe<'_> {
    /// Whether the rule is the streaming one because not even small ensembles fit.
    pub fn is_beyond_memory(&self) -> bool {
        let dof = self.subject.phase_loop.dof();
        matches!(self.method, Method::Streaming(..)) && !fits(dof, SMALL)
    }

    /// Advances the loop sample by sample.
    pub(super) fn measure_streaming(
        &self,
        rule: &Streaming,
        samples: usize,
        h: f64,
    ) -> Result<Measured, Error> {
        let found =
            rule.integrate_with(self.subject.evaluator, self.subject.phase_loop, h, samples)?;
        Ok(Measured {
            defect: Defect::between(&self.initial, &found.integral)?,
            regularity: None,
            integral: found.integral,
            breaks: found.found.into_iter().collect(),
            closing: None,
            samples,
            evaluations: found.evaluations,
            cells_apart: found.cells_apart,
        })
    }
}

impl Diagnostic {
    /// Whether the ensembles that are wanted are too large for the other rules.
    pub(super) fn must_stream(&self, dof: usize) -> bool {
        match self.samples {
            SampleCount::Fixed(samples) => !fits(dof, samples),
            SampleCount::Auto => !fits(dof, SMALL),
        }
    }

    /// The streaming rule, samples doubled from `from` where their number is not given; and the quadrature
    /// error that it leaves at step size `h`, where that was measured.
    pub(super) fn streamed<'a>(
        &self,
        index: usize,
        subject: Subject<'a>,
        h: f64,
        from: usize,
    ) -> Result<(Probe<'a>, Option<f64>), Error> {
        let with =
            |samples: usize| Probe::new(index, subject, Method::Streaming(self.streaming, samples));
        if let SampleCount::Fixed(samples) = self.samples {
            return Ok((with(samples)?, None));
        }
        let most = most_streamed(subject.phase_loop.dof());
        let (mut samples, mut doubling) = (from, Doubling::new());
        loop {
            let probe = with(samples)?;
            let measured = probe.measure(h)?;
            let standing = doubling.proceed(&measured);
            // A break is one with any number of samples.
            if standing.is_done() || !measured.breaks.is_empty() || 2 * samples > most {
                return Ok((probe.knowing(h, measured), Some(standing.error)));
            }
            samples *= 2;
        }
    }

    /// The streaming rule from more samples than fit into memory, if it leaves less than the `error` of a
    /// probe from all that do.
    pub(super) fn beyond_memory<'a>(
        &self,
        probe: Probe<'a>,
        h: f64,
        error: f64,
    ) -> Result<Probe<'a>, Error> {
        let more = 2 * probe.samples();
        let dof = probe.subject.phase_loop.dof();
        if self.samples != SampleCount::Auto || fits(dof, more) || more > most_streamed(dof) {
            return Ok(probe);
        }
        let (streamed, left) = self.streamed(probe.index, probe.subject, h, more)?;
        let better = left.is_some_and(|left| left < error);
        Ok(if better { streamed } else { probe })
    }
}

/// The most samples, a power of two, for so many degrees of freedom.
fn most_streamed(dof: usize) -> usize {
    power_below(MOST_STREAMED / dof.max(1)).clamp(fewest_samples(dof), MOST)
}

//! Samples that are doubled without making or advancing any of them twice.

use crate::diagnosis::limits::{MAX_ROUNDED_SAMPLES, SAMPLES_OF_ROUNDING_TEST};
use crate::error::{Error, StateLocation};
use crate::rules::Subject;
use crate::state::{Ensemble, coordinate};

/// The samples of a loop before and after one step of size h.
///
/// Sample k of N is sample 2k of 2N: doubling takes the samples in between alone.
pub(in crate::diagnosis) struct RefinedSamples<'a> {
    subject: Subject<'a>,
    h: f64,
    pub before: Ensemble,
    pub after: Ensemble,
}

impl<'a> RefinedSamples<'a> {
    /// The first samples, and what the map makes of them.
    pub fn new(subject: Subject<'a>, samples: usize, h: f64) -> Result<Self, Error> {
        let before = Ensemble::sample(subject.phase_loop, samples)?;
        let mut after = before.clone();
        (subject.evaluator.advance(&mut after, h))
            .map_err(|error| error.at(|sample| StateLocation::SampleOf { sample, samples }))?;
        (subject.evaluator)
            .learn_grain(subject.phase_loop, samples, |c, k| coordinate(&after, c)[k]);
        Ok(RefinedSamples {
            subject,
            h,
            before,
            after,
        })
    }

    /// Samples that are known before and after the step.
    pub fn of(subject: Subject<'a>, h: f64, before: Ensemble, after: Ensemble) -> Self {
        RefinedSamples {
            subject,
            h,
            before,
            after,
        }
    }

    /// So many samples, or fewer where the map rounds: neighbours that are nearer than a grain show its stairs and not
    /// the loop.
    pub fn down_to_the_grain(subject: Subject<'a>, samples: usize, h: f64) -> Result<Self, Error> {
        // An error is that of the first of all samples.
        Self::coarse_first(subject, samples, h).or_else(|error| match error.is_of_map() {
            true => RefinedSamples::new(subject, samples, h),
            false => Err(error),
        })
    }

    fn coarse_first(subject: Subject<'a>, samples: usize, h: f64) -> Result<Self, Error> {
        let mut count = coarse(samples);
        let mut refined = RefinedSamples::new(subject, count, h)?;
        let grain = subject.evaluator.grain();
        let widths = grain.map_or(f64::INFINITY, |grain| grain.widths());
        let most = match widths.is_finite() {
            // A loop goes there and back.
            true => (2.0 * widths).min(MAX_ROUNDED_SAMPLES),
            false => f64::INFINITY,
        };
        while count < samples && 2.0 * count as f64 <= most {
            count *= 2;
            refined.double()?;
        }
        Ok(refined)
    }

    /// Twice the samples.
    pub fn double(&mut self) -> Result<(), Error> {
        let samples = self.before.samples();
        Ensemble::check_size(self.before.dof(), 2 * samples)?;
        // Between samples k and k + 1 of the present ones.
        let between_samples = |error: Error| {
            error.at(|k| StateLocation::SampleOf {
                sample: 2 * k + 1,
                samples: 2 * samples,
            })
        };
        let mut between = (Ensemble::sample_between(self.subject.phase_loop, samples))
            .map_err(between_samples)?;
        self.before.interleave(&between);
        (self.subject.evaluator)
            .advance(&mut between, self.h)
            .map_err(between_samples)?;
        self.after.interleave(&between);
        Ok(())
    }

    /// So many samples, by doubling where that leads there.
    pub fn resize(&mut self, samples: usize) -> Result<(), Error> {
        let doublings = samples / self.before.samples();
        if doublings.is_power_of_two() && doublings * self.before.samples() == samples {
            for _ in 0..doublings.ilog2() {
                self.double()?;
            }
        } else {
            *self = RefinedSamples::new(self.subject, samples, self.h)?;
        }
        Ok(())
    }
}

/// The samples with which [`RefinedSamples::down_to_the_grain`] begins to double them to this number.
pub(in crate::diagnosis) fn coarse(samples: usize) -> usize {
    let doublings = (samples / SAMPLES_OF_ROUNDING_TEST).max(1).ilog2();
    samples >> doublings.min(samples.trailing_zeros())
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::loops::Circle;
    use crate::map::{EvaluationCount, Evaluator, PerSample};

    #[test]
    fn no_sample_is_advanced_twice_and_none_differs() {
        let steps = AtomicUsize::new(0);
        let map = PerSample::new(3, |h, q: &mut [f64], p: &mut [f64]| {
            steps.fetch_add(1, Ordering::Relaxed);
            for i in 0..3 {
                p[i] -= h * q[(i + 1) % 3].sin();
                q[i] += h * p[i];
            }
        });
        let circle = Circle::new(vec![0.1, 0.2, 0.3], vec![0.5; 3], 1.0).unwrap();
        let count = EvaluationCount::unlimited();
        let evaluator = Evaluator::new(&map, &count).unwrap();
        let subject = Subject {
            evaluator: &evaluator,
            phase_loop: &circle,
        };
        let mut refined = RefinedSamples::new(subject, 48, 0.3).unwrap();
        // Through a length whose rows are padded, and then to one that no doubling reaches.
        for samples in [48, 96, 768, 1536, 1000] {
            let before = steps.load(Ordering::Relaxed);
            let kept_before = refined.before.samples();
            refined.resize(samples).unwrap();
            let made = steps.load(Ordering::Relaxed) - before;
            let kept = if samples > kept_before {
                kept_before
            } else {
                0
            };
            assert_eq!(
                made,
                if samples == kept_before {
                    0
                } else {
                    samples - kept
                }
            );
            let mut anew = Ensemble::sample(&circle, samples).unwrap();
            for i in 0..3 {
                assert_eq!(refined.before.q().row(i), anew.q().row(i));
                assert_eq!(refined.before.p().row(i), anew.p().row(i));
            }
            anew.advance(&map, 0.3).unwrap();
            for i in 0..3 {
                assert_eq!(refined.after.q().row(i), anew.q().row(i));
                assert_eq!(refined.after.p().row(i), anew.p().row(i));
            }
        }
    }

    #[test]
    fn a_failing_sample_is_named_by_its_place_among_all() {
        let map = PerSample::new(1, |_, q: &mut [f64], _: &mut [f64]| {
            if (q[0] - 1.0).abs() < 1e-3 {
                q[0] = f64::NAN;
            }
        });
        let circle = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
        let count = EvaluationCount::unlimited();
        let evaluator = Evaluator::new(&map, &count).unwrap();
        let subject = Subject {
            evaluator: &evaluator,
            phase_loop: &circle,
        };
        let mut refined = RefinedSamples::new(subject, 6, 0.3).unwrap();
        // q = 1 is at a quarter of the loop: sample 3 of 12.
        let error = refined.double().expect_err("it fails");
        assert!(
            matches!(
                error,
                Error::NotFinite {
                    at: StateLocation::SampleOf {
                        sample: 3,
                        samples: 12
                    },
                    ..
                }
            ),
            "{error}"
        );
    }
}

//! The samples of a loop before the step, kept from one step size to the next.

use super::refined_samples::RefinedSamples;
use crate::error::{Error, StateLocation};
use crate::loops::sample_block;
use crate::rules::Subject;
use crate::state::{Ensemble, SMALL_MEMORY, coordinate, copy_samples};

/// A loop whose samples are advanced by one step size after the other, in memory that is asked for once.
///
/// Samples are made once where they are kept. Larger ones would double the memory of a sweep: each block of
/// them is made again just before it is advanced.
pub(in crate::diagnosis) struct InitialSamples<'a> {
    pub subject: Subject<'a>,
    ensembles: Option<Ensembles>,
}

struct Ensembles {
    /// Kept only up to 64 MiB.
    before: Option<Ensemble>,
    /// The images of the last step, or larger samples before a step.
    after: Ensemble,
}

impl<'a> InitialSamples<'a> {
    /// Takes no memory until there is a step.
    pub fn new(subject: Subject<'a>) -> Self {
        InitialSamples {
            subject,
            ensembles: None,
        }
    }

    /// Tells the map that a step of each of these sizes is sure to be asked for of `samples` samples. If they cannot be made,
    /// the later request for them reports it.
    pub fn prefetch(&mut self, samples: usize, sizes: impl Iterator<Item = f64>) {
        let evaluator = self.subject.evaluator;
        if evaluator.has_prefetch()
            && let Ok(Ensembles {
                before: Some(before),
                ..
            }) = self.of(samples)
        {
            sizes.for_each(|h| evaluator.prefetch(before, h));
        }
    }

    /// The ensembles of this number of samples.
    fn of(&mut self, samples: usize) -> Result<&mut Ensembles, Error> {
        let held = (self.ensembles.take()).filter(|held| held.after.samples() == samples);
        let held = match held {
            Some(held) => held,
            None => Ensembles::new(self.subject, samples)?,
        };
        Ok(self.ensembles.insert(held))
    }

    /// Returns the samples before a step. They replace the images of the last step if memory is kept for one ensemble only.
    ///
    /// # Errors
    /// Those of making them.
    pub fn before(&mut self, samples: usize) -> Result<&Ensemble, Error> {
        let phase_loop = self.subject.phase_loop;
        match self.of(samples)? {
            Ensembles {
                before: Some(before),
                ..
            } => Ok(before),
            Ensembles { after: anew, .. } => {
                anew.fill_with_samples(phase_loop)?;
                Ok(anew)
            }
        }
    }

    /// The images of `samples` samples after a step of size `h`.
    ///
    /// # Errors
    /// Those of making and of advancing them.
    pub fn advanced(&mut self, samples: usize, h: f64) -> Result<&Ensemble, Error> {
        let Subject {
            evaluator,
            phase_loop,
        } = self.subject;
        let Ensembles { before, after } = self.of(samples)?;
        let advanced = match before {
            Some(before) => evaluator.advance_from(after, h, |first, block| {
                copy_samples(before, first, block);
                Ok(())
            }),
            None => evaluator.advance_from(after, h, |first, block| {
                sample_block(phase_loop, |k| k as f64 / samples as f64, first, block)
            }),
        };
        advanced.map_err(|error| error.at(|sample| StateLocation::SampleOf { sample, samples }))?;
        evaluator.learn_grain(phase_loop, samples, |c, k| coordinate(after, c)[k]);
        Ok(after)
    }
}

impl<'a> InitialSamples<'a> {
    /// The samples before and after the last step, which had the size `h`, if those before it are kept.
    pub fn last(&self, h: f64) -> Option<RefinedSamples<'a>> {
        let ensembles = self.ensembles.as_ref()?;
        let (before, after) = (ensembles.before.as_ref()?.clone(), ensembles.after.clone());
        Some(RefinedSamples::of(self.subject, h, before, after))
    }
}

impl Ensembles {
    fn new(subject: Subject<'_>, samples: usize) -> Result<Self, Error> {
        let dof = subject.phase_loop.dof();
        Ensemble::check_size(dof, samples)?;
        let kept = 16 * dof * samples <= SMALL_MEMORY;
        let before = kept.then(|| Ensemble::sample(subject.phase_loop, samples));
        Ok(Ensembles {
            before: before.transpose()?,
            after: Ensemble::zeros(dof, samples),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::loops::{Circle, Loop};
    use crate::map::{EvaluationCount, Evaluator, PerSample};
    use crate::state::Block;

    /// Counts the samples that are made.
    struct Counted(Circle, AtomicUsize);

    impl Loop for Counted {
        fn dof(&self) -> usize {
            self.0.dof()
        }
        fn sample(&self, s: &[f64], block: &mut Block<'_>) {
            self.1.fetch_add(s.len(), Ordering::Relaxed);
            self.0.sample(s, block);
        }
    }

    /// Kept or made again, on one thread or two, the states are those of samples that were made for this step
    /// alone.
    #[test]
    fn no_step_sees_what_another_left() {
        // More than are left where they lie.
        const DOF: usize = 600;
        let map = PerSample::new(DOF, |h, q: &mut [f64], p: &mut [f64]| {
            for i in 0..DOF {
                p[i] -= h * q[(i + 1) % DOF].sin();
                q[i] += h * p[i];
            }
        });
        let circle = Circle::new(vec![0.1; DOF], vec![0.5; DOF], 1.0).unwrap();
        let count = EvaluationCount::unlimited();
        let evaluator = Evaluator::new(&map, &count).unwrap();
        // The last is too large to be kept, and no multiple of a block.
        for (samples, makings) in [(48, 1), (1024, 1), (7_501, 6)] {
            let counted = Counted(circle.clone(), AtomicUsize::new(0));
            for threads in [1, 2] {
                counted.1.store(0, Ordering::Relaxed);
                let mut initial = InitialSamples::new(Subject {
                    evaluator: &evaluator,
                    phase_loop: &counted,
                });
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
                pool.build().unwrap().install(|| {
                    for h in [0.5, 0.25, 0.5] {
                        let mut anew = Ensemble::sample(&circle, samples).unwrap();
                        assert!(*initial.before(samples).unwrap() == anew);
                        anew.advance(&map, h).unwrap();
                        let after = initial.advanced(samples, h).unwrap();
                        for i in 0..DOF {
                            assert!(after.q().row(i) == anew.q().row(i));
                            assert!(after.p().row(i) == anew.p().row(i));
                        }
                    }
                });
                assert_eq!(counted.1.load(Ordering::Relaxed), makings * samples);
            }
        }
    }

    #[test]
    fn another_number_of_samples_is_another_ensemble() {
        let map = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| q[0] += h * p[0]);
        let circle = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
        let count = EvaluationCount::unlimited();
        let evaluator = Evaluator::new(&map, &count).unwrap();
        let mut initial = InitialSamples::new(Subject {
            evaluator: &evaluator,
            phase_loop: &circle,
        });
        for samples in [32, 64, 32] {
            let after = initial.advanced(samples, 0.5).unwrap();
            assert_eq!(after.samples(), samples);
        }
        assert!(matches!(
            initial.advanced(2, 0.5),
            Err(Error::TooFewSamples { samples: 2 })
        ));
    }
}

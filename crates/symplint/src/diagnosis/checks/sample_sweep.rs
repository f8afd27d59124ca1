//! The given loop with other numbers of samples.

use super::{GivenLoop, Runner};
use crate::diagnosis::Event;
use crate::diagnosis::limits::STEP_SIZE_OF_MAP;
use crate::diagnosis::resolve::initial_samples::InitialSamples;
use crate::diagnosis::resolve::probe::{Probe, StepMeasurement};
use crate::diagnosis::resolve::refined_samples::RefinedSamples;
use crate::error::Error;
use crate::evidence::{Check, OmissionReason, Sweep};
use crate::rules::{Rule, Subject};

impl Runner<'_> {
    /// The given loop with other numbers of samples, if they are asked for.
    pub(super) fn sweep_samples(
        &mut self,
        _: Subject<'_>,
        given: &GivenLoop<'_>,
    ) -> Result<(), Error> {
        let (diagnostic, probe) = (self.diagnostic, &given.probe);
        let Some(sweep) = &diagnostic.sample_sweep else {
            return Ok(());
        };
        (self.watch)(Event::Planned(sweep.counts.len()));
        let h = match self.diagnostic.has_step_size {
            true => sweep.step_size,
            false => STEP_SIZE_OF_MAP,
        };
        let subject = probe.subject;
        subject.evaluator.begin_loop();
        let mut refined: Option<RefinedSamples<'_>> = None;
        for (k, &samples) in sweep.counts.iter().enumerate() {
            let before = self.count.made();
            if samples > self.count.left() {
                let missing = sweep.counts[k..].len();
                self.omit(Check::SampleSweep, OmissionReason::Budget { missing });
                break;
            }
            let (of_samples, advanced) = if probe.keeps_samples() {
                let refined = match &mut refined {
                    None => refined.insert(RefinedSamples::new(subject, samples, h)?),
                    Some(refined) => {
                        refined.resize(samples)?;
                        refined
                    }
                };
                let rule = match probe.rule {
                    Rule::Piecewise(_) => Rule::Pseudospectral,
                    rule => rule,
                };
                let of_samples = Probe::of_samples(subject, rule, &refined.before)?;
                let advanced = of_samples.measure_samples(&refined.after, h)?;
                (of_samples, advanced)
            } else {
                let initial = &mut InitialSamples::new(subject);
                let of_samples = Probe::new(initial, probe.rule, samples)?;
                let known = of_samples.measure(initial, h, &mut |_| {})?;
                (of_samples, known.advanced)
            };
            let known = StepMeasurement {
                h,
                advanced,
                evaluations: self.count.made() - before,
            };
            self.record(0, Sweep::Samples, &of_samples, &known);
        }
        Ok(())
    }
}

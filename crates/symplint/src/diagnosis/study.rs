//! Points as they are measured: told of, and kept.

use super::departures::Departures;
use super::nested::Nested;
use super::probe::{Measured, Method, Probe};
use super::{BreakAt, Event, Point, SampleSweep, Sweep};
use crate::error::Error;
use crate::survey::winds;
use crate::verdict::{LoopEvidence, StepEvidence};

/// A diagnosis under way.
pub(super) struct Study<'a> {
    pub watch: &'a dyn Fn(Event<'_>),
    pub points: Vec<Point>,
    pub breaks: Vec<BreakAt>,
    /// Of the given loop after the largest step.
    pub regularity: Option<f64>,
    pub largest: f64,
}

impl Study<'_> {
    pub fn sweep_steps(
        &mut self,
        probe: &Probe<'_>,
        step_sizes: &[f64],
    ) -> Result<LoopEvidence, Error> {
        (self.watch)(Event::Planned(step_sizes.len()));
        let mut evidence = LoopEvidence {
            piecewise: matches!(probe.method, Method::Piecewise(..)),
            winds: winds(probe.subject.phase_loop, probe.subject.coordinates)?,
            ..LoopEvidence::new(probe.index, probe.samples())
        };
        let mut departures = Departures::new(probe.subject);
        for &h in step_sizes {
            let measured = probe.measure_from(&mut departures, h)?;
            evidence
                .steps
                .push(self.record(Sweep::StepSize, probe, h, measured));
        }
        Ok(evidence)
    }

    pub fn sweep_samples(&mut self, probe: &Probe<'_>, sweep: &SampleSweep) -> Result<(), Error> {
        (self.watch)(Event::Planned(sweep.counts.len()));
        let (h, mut nested) = (sweep.step_size, None);
        for &samples in &sweep.counts {
            if let Some(streaming) = probe.streaming(samples) {
                let streaming = streaming?;
                let measured = streaming.measure(h)?;
                self.record(Sweep::Samples, &streaming, h, measured);
                continue;
            }
            let nested = match &mut nested {
                None => nested.insert(Nested::new(probe.subject, samples, h)?),
                Some(nested) => {
                    nested.resize(samples)?;
                    nested
                }
            };
            let rule = probe.sampling_rule();
            let of_samples = Probe::of_samples(probe.index, probe.subject, rule, &nested.before)?;
            let measured = of_samples.measure_samples(&nested.after, h)?;
            self.record(Sweep::Samples, &of_samples, h, measured);
        }
        Ok(())
    }

    /// Tells of what was measured, and keeps it.
    fn record(
        &mut self,
        sweep: Sweep,
        probe: &Probe<'_>,
        h: f64,
        measured: Measured,
    ) -> StepEvidence {
        let point = Point::new(sweep, probe, h, &measured);
        (self.watch)(Event::Measured(&point));
        self.points.push(point);
        let found = measured.largest_break();
        let worth_all = probe.index == 0 && h == self.largest && sweep == Sweep::StepSize;
        if worth_all {
            self.regularity = measured.regularity;
        }
        let breaks = if worth_all {
            measured.breaks
        } else {
            found.into_iter().collect()
        };
        self.breaks.extend(breaks.into_iter().map(|found| BreakAt {
            loop_index: probe.index,
            step_size: h,
            found,
        }));
        StepEvidence {
            step_size: h,
            defect: measured.defect,
            found,
            closing: measured.closing,
            cells_apart: measured.cells_apart,
        }
    }
}

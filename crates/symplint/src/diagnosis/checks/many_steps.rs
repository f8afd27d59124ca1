//! The given loop in many steps.

use super::{GivenLoop, Runner};
use crate::diagnosis::limits::{FINE_DEFECT, FOLDED, RESOLVED_DEFECT};
use crate::diagnosis::plan::fits;
use crate::diagnosis::resolve::probe::Probe;
use crate::error::Error;
use crate::evidence::{Check, LongTime, Why};
use crate::rules::{Rule, Subject};
use crate::trace::{Trace, TracePoint};

impl Runner<'_> {
    /// The given loop in many steps, if they are asked for.
    pub(super) fn many_steps(
        &mut self,
        _: Subject<'_>,
        given: &GivenLoop<'_>,
    ) -> Result<(), Error> {
        let steps = self.diagnostic.long_time;
        if steps == 0 {
            return Ok(());
        }
        match follow(&given.probe, self.largest, steps, self.left())? {
            Ok(found) => self.evidence.long_time = Some(found),
            Err(why) => self.omit(Check::ManySteps, why),
        }
        Ok(())
    }
}

/// Follows the loop of a probe for `steps` steps of size `h`, or says what is left out if it does not fit into memory
/// or into the evaluations that are `left`.
fn follow(
    probe: &Probe<'_>,
    h: f64,
    steps: usize,
    left: usize,
) -> Result<Result<LongTime, Why>, Error> {
    let dof = probe.subject.dof();
    let mut samples = probe.samples.max(FOLDED / dof.max(1));
    if !probe.keeps_samples() && !fits(dof, samples) {
        return Ok(Err(Why::Memory { samples }));
    }
    // Fewer samples than one step is resolved with say nothing of many.
    if samples.saturating_mul(steps) > left {
        samples = probe.samples;
    }
    if samples.saturating_mul(steps) > left {
        return Ok(Err(Why::BUDGET));
    }
    let trace = Trace {
        rule: Rule::Pseudospectral,
        samples,
        step_size: h,
        steps,
        snapshots: Vec::new(),
    };
    let subject = &probe.subject;
    let record = trace.run_with(subject.evaluator, subject.phase_loop, None, &|_| {})?;
    let h = subject.evaluator.stated(h);
    Ok(Ok(summary(h, samples, &record.points[1..])))
}

fn summary(h: Option<f64>, samples: usize, points: &[TracePoint]) -> LongTime {
    let mut largest = 0.0f64;
    let resolved = points.iter().take_while(|point| {
        largest = largest.max(point.defect);
        (point.quadrature_error)
            .is_some_and(|error| error <= (RESOLVED_DEFECT * largest).max(FINE_DEFECT))
    });
    let defects: Vec<f64> = resolved.map(|point| point.defect).collect();
    let max = |part: &[f64]| part.iter().copied().fold(0.0, f64::max);
    let n = defects.len();
    LongTime {
        step_size: h,
        asked: points.len(),
        steps: n,
        samples,
        largest: max(&defects),
        early: max(&defects[..n / 4]),
        late: max(&defects[n - n / 4..]),
        least: (defects[n / 2..].iter().copied())
            .reduce(f64::min)
            .unwrap_or(0.0),
    }
}

//! The given loop in many steps.

use super::{GivenLoop, Runner, failed};
use crate::diagnosis::limits::{MAX_ERROR_OVER_DEFECT, MAX_SUFFICIENT_ERROR, MIN_FOLDED_SAMPLES};
use crate::diagnosis::plan::{fits, power_below};
use crate::diagnosis::resolve::probe::Probe;
use crate::error::Error;
use crate::evidence::{
    Check, EnergyInTime, LongTime, LoopAtStep, LoopEvidence, MIN_SAMPLES_OF_SHAPE, OmissionReason,
};
use crate::map::Energy;
use crate::rules::{Rule, Subject};
use crate::state::Ensemble;
use crate::trace::{Trace, TracePoint};

/// Blocks of the first half of the steps, whose rates predict the second half. Conventional.
const BLOCKS_OF_FIRST_HALF: usize = 8;

/// Points of the curve that is kept, at most. Conventional: more than a figure shows.
const MAX_CURVE_POINTS: usize = 200;

impl Runner<'_> {
    /// The given loop in many steps, if they are asked for.
    pub(super) fn many_steps(
        &mut self,
        _: Subject<'_>,
        given: &GivenLoop<'_>,
    ) -> Result<(), Error> {
        let steps = self.diagnostic.long_time;
        // Broken pieces of a loop are not followed any further.
        let is_broken = self
            .evidence
            .loops
            .first()
            .is_some_and(LoopEvidence::is_broken);
        if steps == 0 || is_broken {
            return Ok(());
        }
        match follow(&given.probe, self.largest, steps, self.left()) {
            Ok(Ok((found, curve))) => {
                self.evidence.long_time = Some(found);
                self.evidence.loop_at_steps = curve;
            }
            Ok(Err(why)) => self.omit(Check::ManySteps, why),
            Err(error @ (Error::Stopped | Error::BudgetSpent { .. })) => return Err(error),
            // The verdict rests on one step: states may escape, or a loop wind around a torus, in the steps after it.
            Err(error) => self.omit(Check::ManySteps, failed(&error)),
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
) -> Result<Result<(LongTime, Vec<LoopAtStep>), OmissionReason>, Error> {
    let dof = probe.subject.dof();
    let mut samples = probe.samples.max(MIN_FOLDED_SAMPLES / dof.max(1));
    if !probe.keeps_samples() && !fits(dof, samples) {
        return Ok(Err(OmissionReason::Memory { samples }));
    }
    // Fewer samples resolve fewer of the steps, which the trace tells.
    let affordable = power_below(left / steps);
    if affordable < MIN_SAMPLES_OF_SHAPE {
        return Ok(Err(OmissionReason::BUDGET));
    }
    samples = samples.min(affordable);
    let trace = Trace {
        rule: Rule::Pseudospectral,
        samples,
        step_size: h,
        steps,
        snapshots: Vec::new(),
    };
    let subject = &probe.subject;
    let mut energies = (subject.evaluator.energy()).map(|of| EnergiesInTime::new(of, steps));
    let record = trace.run_with(
        subject.evaluator,
        subject.phase_loop,
        None,
        &mut |point, states| {
            if let Some(energies) = &mut energies {
                energies.add(point.step, states);
            }
        },
    )?;
    let h = subject.evaluator.stated(h);
    let mut found = summary(h, samples, &record.points[1..]);
    found.energy = energies.and_then(EnergiesInTime::summary);
    let curve = curve(&record.points[1..=found.steps]);
    Ok(Ok((found, curve)))
}

/// Some of the points, evenly spaced, and the last one.
fn curve(points: &[TracePoint]) -> Vec<LoopAtStep> {
    let every = points.len().div_ceil(MAX_CURVE_POINTS).max(1);
    let kept = points.iter().rev().step_by(every).map(|point| LoopAtStep {
        step: point.step,
        defect: point.signed_defect,
        uncertainty: (point.quadrature_error).map(|error| error + point.roundoff),
    });
    let mut kept: Vec<LoopAtStep> = kept.collect();
    kept.reverse();
    kept
}

/// The energies of the states of a loop, step by step.
struct EnergiesInTime<'a> {
    energy: &'a Energy<'a>,
    steps: usize,
    initial: Vec<f64>,
    /// H(n) − H(0) at the last step that was added.
    changes: Vec<f64>,
    /// The largest change of each state.
    most: Vec<f64>,
    /// Its smallest one in the second half of the steps.
    least: Vec<f64>,
    early: f64,
    late: f64,
}

impl<'a> EnergiesInTime<'a> {
    fn new(energy: &'a Energy<'a>, steps: usize) -> Self {
        EnergiesInTime {
            energy,
            steps,
            initial: Vec::new(),
            changes: Vec::new(),
            most: Vec::new(),
            least: Vec::new(),
            early: 0.0,
            late: 0.0,
        }
    }

    fn add(&mut self, step: usize, states: &Ensemble) {
        let samples = states.samples();
        let mut energies = vec![f64::NAN; samples];
        (self.energy)(states.q(), states.p(), &mut energies);
        if step == 0 {
            (self.initial, self.most) = (energies, vec![0.0; samples]);
            self.least = vec![f64::INFINITY; samples];
            return;
        }
        let pairs = energies.iter().zip(&self.initial);
        self.changes = pairs.map(|(after, before)| after - before).collect();
        let mut largest = 0.0f64;
        let bounds = self.most.iter_mut().zip(&mut self.least);
        for (change, (most, least)) in self.changes.iter().zip(bounds) {
            let size = match change.is_nan() {
                true => f64::INFINITY,
                false => change.abs(),
            };
            (largest, *most) = (largest.max(size), most.max(size));
            if 2 * step > self.steps {
                *least = least.min(size);
            }
        }
        if 4 * step <= self.steps {
            self.early = self.early.max(largest);
        } else if 4 * step > 3 * self.steps {
            self.late = self.late.max(largest);
        }
    }

    /// `None` if an energy is not finite.
    fn summary(self) -> Option<EnergyInTime> {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let found = EnergyInTime {
            steps: self.steps,
            early: self.early,
            late: self.late,
            most: mean(&self.most),
            least: mean(&self.least),
            change: mean(&self.changes),
        };
        let numbers = [
            found.early,
            found.late,
            found.most,
            found.least,
            found.change,
        ];
        numbers.iter().all(|x| x.is_finite()).then_some(found)
    }
}

fn summary(h: Option<f64>, samples: usize, points: &[TracePoint]) -> LongTime {
    let mut largest = 0.0f64;
    let resolved = points.iter().take_while(|point| {
        largest = largest.max(point.defect);
        (point.quadrature_error).is_some_and(|error| {
            error <= (MAX_ERROR_OVER_DEFECT * largest).max(MAX_SUFFICIENT_ERROR)
        })
    });
    let signed: Vec<f64> = resolved.map(|point| point.signed_defect).collect();
    let defects: Vec<f64> = signed.iter().map(|defect| defect.abs()).collect();
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
        // Areas that shrink by one factor in every step add up in their logarithms.
        exponent: exponent(
            &signed
                .iter()
                .map(|defect| defect.ln_1p().abs())
                .collect::<Vec<f64>>(),
        ),
        change: signed.last().copied().unwrap_or(0.0),
        predicted: predicted(&signed),
        energy: None,
    }
}

/// The a of |E| ~ n^a: of the root mean squares of the second and of the last quarter, whose middles are 3/8 and 7/8 of all steps.
fn exponent(defects: &[f64]) -> Option<f64> {
    let n = defects.len();
    let mean = |part: &[f64]| {
        let squares: f64 = part.iter().map(|defect| defect * defect).sum();
        (squares / part.len() as f64).sqrt()
    };
    let (early, late) = (mean(&defects[n / 4..n / 2]), mean(&defects[n - n / 4..]));
    let exponent = (late / early).ln() / (7.0f64 / 3.0).ln();
    (n >= 2 * BLOCKS_OF_FIRST_HALF && exponent.is_finite()).then_some(exponent)
}

/// The relative change of the area after all steps, from those of the first half: the logarithm of the area continues as before, and its
/// error is twice what blocks of the first half differ by.
fn predicted(signed: &[f64]) -> Option<[f64; 2]> {
    let (n, half) = (signed.len(), signed.len() / 2);
    let block = half / BLOCKS_OF_FIRST_HALF;
    if block == 0 || signed.iter().any(|&defect| defect <= -1.0) {
        return None;
    }
    let logarithm = |steps: usize| match steps {
        0 => 0.0,
        steps => signed[steps - 1].ln_1p(),
    };
    let rates: Vec<f64> = (0..BLOCKS_OF_FIRST_HALF)
        .map(|k| (logarithm((k + 1) * block) - logarithm(k * block)) / block as f64)
        .collect();
    let mean = rates.iter().sum::<f64>() / BLOCKS_OF_FIRST_HALF as f64;
    let variance: f64 = rates.iter().map(|rate| (rate - mean).powi(2)).sum();
    let deviation = (variance / (BLOCKS_OF_FIRST_HALF - 1) as f64).sqrt();
    let (change, error) = (n as f64 * mean, 2.0 * n as f64 * deviation);
    Some([change.exp_m1(), error * change.exp()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_defect_that_adds_up_is_predicted_from_its_first_half() {
        // Uniform damping: the area falls by one factor in every step.
        let damped: Vec<f64> = (1..=1000)
            .map(|n| (-1e-3 * f64::from(n)).exp_m1())
            .collect();
        let [change, error] = predicted(&damped).unwrap();
        assert!((change - damped[999]).abs() < 1e-12 && error < 1e-12);
        // A rate that rises by a third is within the error.
        let rising = |n: f64| 1e-5 * n * (1.0 + n / 3000.0);
        let signed: Vec<f64> = (1..=1000).map(|n| rising(f64::from(n))).collect();
        let [change, error] = predicted(&signed).unwrap();
        assert!(
            (change - signed[999]).abs() < error,
            "{change:e} ± {error:e}"
        );
        assert!(error < 0.5 * change);
        // What returns is predicted to be anything.
        let returns: Vec<f64> = (1..=1000)
            .map(|n| 1e-3 * (0.037 * f64::from(n)).sin())
            .collect();
        let [change, error] = predicted(&returns).unwrap();
        assert!(error > change.abs());
        assert_eq!(predicted(&signed[..10]), None);
    }

    #[test]
    fn exponents_are_those_of_powers() {
        for power in [0.5, 1.0, 2.0] {
            let defects: Vec<f64> = (1..=400).map(|n| f64::from(n).powf(power)).collect();
            let found = exponent(&defects).unwrap();
            assert!((found / power - 1.0).abs() < 0.06, "{power}: {found}");
        }
    }
}

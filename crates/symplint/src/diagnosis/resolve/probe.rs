//! One loop with a rule and a number of samples, ready to be advanced by any step size.

use super::initial_samples::InitialSamples;
use crate::diagnosis::limits::MIN_PIECEWISE_EVALUATIONS;
use crate::diagnosis::plan::fits;
use crate::error::Error;
use crate::evidence::{ClosedBreaks, LoopEvidence, StepEvidence};
use crate::loops::FEW_SAMPLES;
use crate::rules::{LoopAfterStep, LoopIntegral, LoopIntegrator, Rule, RuleKind, Samples, Subject};
use crate::signal::Extent;
use crate::state::Ensemble;
use crate::survey;

/// A subject with its initial loop integral.
pub(in crate::diagnosis) struct Probe<'a> {
    pub subject: Subject<'a>,
    pub rule: Rule,
    /// Equispaced samples of the loop.
    pub samples: usize,
    integrator: Box<dyn LoopIntegrator>,
    initial: LoopIntegral,
    /// The measurement of a step that was made already.
    known: Option<StepMeasurement>,
}

/// One step that was measured.
#[derive(Clone)]
pub(in crate::diagnosis) struct StepMeasurement {
    pub h: f64,
    pub advanced: LoopAfterStep,
    /// States that the map advanced for it.
    pub evaluations: usize,
}

impl<'a> Probe<'a> {
    /// By this rule, from this number of samples.
    pub fn new(
        initial: &mut InitialSamples<'a>,
        rule: Rule,
        samples: usize,
    ) -> Result<Self, Error> {
        let subject = initial.subject;
        let samples = match rule.integrator().keeps_samples() {
            true => Samples::Kept(initial.before(samples)?),
            false => Samples::Count(samples),
        };
        Self::with(subject, rule, samples)
    }

    /// The same from samples that are there.
    pub fn of_samples(subject: Subject<'a>, rule: Rule, before: &Ensemble) -> Result<Self, Error> {
        Self::with(subject, rule, Samples::Kept(before))
    }

    fn with(subject: Subject<'a>, rule: Rule, samples: Samples<'_>) -> Result<Self, Error> {
        let integrator = rule.integrator();
        Ok(Probe {
            initial: integrator.before(&subject, samples)?,
            subject,
            rule,
            samples: samples.count(),
            integrator,
            known: None,
        })
    }

    /// Keeps what a step was found to do, so that it is not measured again.
    pub fn knowing(mut self, h: f64, advanced: LoopAfterStep, evaluations: usize) -> Self {
        self.known = Some(StepMeasurement {
            h,
            advanced,
            evaluations,
        });
        self
    }

    /// With a quadrature error of the step of size `h` that is at least this part of the initial integral; not known without one.
    pub fn known_to(mut self, error: Option<f64>, h: f64) -> Self {
        let size = self.initial.value.abs();
        if let Some(known) = self.known.as_mut().filter(|known| known.h == h) {
            let at_least = |known: Option<f64>, error: Option<f64>| {
                known.zip(error).map(|(known, error)| known.max(error))
            };
            let LoopAfterStep {
                integral, defect, ..
            } = &mut known.advanced;
            defect.quadrature_error = at_least(defect.quadrature_error, error);
            integral.quadrature_error =
                at_least(integral.quadrature_error, error.map(|error| error * size));
        }
        self
    }

    /// Adds to the evidence of a loop the rule, the number of samples and the positions that wind.
    pub fn described(&self, mut found: LoopEvidence) -> Result<LoopEvidence, Error> {
        found.rule = match self.rule.kind() {
            RuleKind::Auto => RuleKind::Pseudospectral,
            kind => kind,
        };
        found.samples = self.samples;
        found.wound = survey::wound(self.subject.phase_loop, self.subject.coordinates())?;
        found.winds = !found.wound.is_empty();
        Ok(found)
    }

    /// The measurement of the step of size `h`.
    pub fn known(&self, h: f64) -> Option<&StepMeasurement> {
        self.known.as_ref().filter(|known| known.h == h)
    }

    /// The evaluations that one more step takes at least.
    pub fn least_cost(&self) -> usize {
        let of_pieces = match self.rule {
            Rule::Piecewise(_) => MIN_PIECEWISE_EVALUATIONS,
            _ => 0,
        };
        self.samples + of_pieces
    }

    /// Whether samples stay in memory.
    pub fn keeps_samples(&self) -> bool {
        self.integrator.keeps_samples()
    }

    /// Whether the rule is one that does not keep samples, because not even small ensembles fit.
    pub fn is_beyond_memory(&self) -> bool {
        !self.keeps_samples() && !fits(self.subject.dof(), FEW_SAMPLES)
    }

    /// Measures a step of size `h` from the samples after it, as many as before it.
    pub fn measure_samples(&self, after: &Ensemble, h: f64) -> Result<LoopAfterStep, Error> {
        let samples = Samples::Kept(after);
        (self
            .integrator
            .after(&self.subject, h, samples, &self.initial))
        .map(|advanced| self.rounded(advanced))
    }

    /// What rounding of as many samples leaves of the integral, relative to it, if the map rounds.
    pub fn of_rounding(&self) -> Option<f64> {
        let grain = self.subject.evaluator.grain()?;
        let of_samples = grain.of_samples(self.samples, self.subject.coordinates());
        Some(of_samples / self.initial.value.abs()).filter(|part| *part > 0.0)
    }

    /// With what the grain of the map leaves of the integral.
    fn rounded(&self, mut advanced: LoopAfterStep) -> LoopAfterStep {
        if let Some(grain) = self.subject.evaluator.grain() {
            let coordinates = self.subject.coordinates();
            let noise = self.subject.evaluator.noise();
            let of_noise = noise.map_or(0.0, |noise| grain.of_noise(&noise, coordinates));
            let of_integral = grain.of_integral(coordinates) + of_noise;
            let relative = of_integral / self.initial.value.abs();
            advanced.defect.roundoff += relative;
            if let Some(closed) = &mut advanced.closed {
                closed.defect.roundoff += relative;
            }
        }
        advanced
    }

    /// Advances the loop by one step, unless that is known, and compares the loop integrals. `look` is shown the
    /// samples after the step, if they are in memory.
    pub fn measure(
        &self,
        samples: &mut InitialSamples<'_>,
        h: f64,
        look: &mut dyn FnMut(&Ensemble),
    ) -> Result<StepMeasurement, Error> {
        if let Some(known) = self.known(h) {
            return Ok(known.clone());
        }
        let count = self.subject.evaluator.count();
        let before = count.made();
        let advanced = match self.keeps_samples() {
            true => {
                let after = samples.advanced(self.samples, h)?;
                look(after);
                self.measure_samples(after, h)?
            }
            false => {
                self.subject.learn_grain(h)?;
                let samples = Samples::Count(self.samples);
                let advanced = self
                    .integrator
                    .after(&self.subject, h, samples, &self.initial)?;
                self.rounded(advanced)
            }
        };
        Ok(StepMeasurement {
            h,
            advanced,
            evaluations: count.made() - before,
        })
    }

    /// See [`StepEvidence::reach_of_jumps`].
    fn reach_of_jumps(&self, advanced: &LoopAfterStep) -> f64 {
        let Some(jump) = advanced.largest_break() else {
            return 0.0;
        };
        let Subject { phase_loop, .. } = self.subject;
        // Without samples nothing is known of the ranges.
        let Ok(samples) = Ensemble::sample(phase_loop, FEW_SAMPLES) else {
            return f64::INFINITY;
        };
        let half_range = |row: &[f64]| 0.5 * Extent::of(row).length();
        let of_q = jump.jump_q.abs() * half_range(samples.p().row(jump.dof));
        let of_p = jump.jump_p.abs() * half_range(samples.q().row(jump.dof));
        let weight = self.subject.coordinates().weight(jump.dof).abs();
        let breaks = advanced.closed.map_or(1, |closed| closed.breaks.max(1));
        breaks as f64 * weight * (of_q + of_p) / self.initial.value.abs()
    }

    /// A measured step as evidence.
    pub fn evidence(&self, known: &StepMeasurement) -> StepEvidence {
        let advanced = &known.advanced;
        StepEvidence {
            step_size: self.subject.evaluator.stated(known.h),
            samples: advanced.samples,
            rule: self.integrator.kind(),
            initial: self.initial.value,
            advanced: advanced.integral.value,
            defect: advanced.defect,
            jump: advanced.largest_break(),
            reach_of_jumps: self.reach_of_jumps(advanced),
            flickering: advanced.closed.map_or(0, |closed| closed.flickering),
            closing: advanced.closed.map(|closed| ClosedBreaks {
                breaks: closed.breaks,
                chord: closed.chord,
                closed: closed.defect,
                bend: closed.bend,
                straight: closed.straight,
            }),
            omitted_cells: advanced.integral.omitted.as_ref().map(Vec::len),
            cells_apart: advanced.cells_apart,
            regularity: advanced.regularity,
            has_feature: (self.subject.evaluator.features().iter())
                .any(|feature| feature.h == known.h),
            evaluations: known.evaluations,
            ..StepEvidence::default()
        }
    }
}

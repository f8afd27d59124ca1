//! Carrying out the plan: fills the evidence.

use super::checks::Runner;
use std::sync::Arc;

use super::limits::{MAX_LOOPS, MIN_BUDGET, STEP_SIZE_OF_MAP};
use super::plan;
use super::step_sizes::step_sizes;
use super::{Diagnostic, Event, Progress};
use crate::error::Error;
use crate::evidence::{Check, Evidence};
use crate::loops::{Loop, check_closed};
use crate::map::{EvaluationCount, Evaluator, Repeat, TimeAdvance};
use crate::rules::Subject;
use crate::survey;

impl Diagnostic {
    /// Measures, and concludes nothing.
    ///
    /// `watch` gets each point when it is measured. If the number of samples is automatic, or
    /// swept over, samples before and after a step are kept and doubled: no evaluation is made twice, but for a few
    /// that show whether results depend on earlier calls or on the batch. In a sweep over step sizes one ensemble is in memory, and the
    /// samples before the step too where they take 64 MiB at most; larger ones are made anew for each step size,
    /// block by block. By the streaming rule it is a few dozen states; what needs larger ensembles (the Jacobian,
    /// many steps) is then left out where they take more than 512 MiB.
    ///
    /// # Errors
    /// If map and loop do not fit, a step size is zero or not finite, the budget is below 200, the number of loops is 0 or too large, results depend on
    /// earlier calls or on the batch, the loop is random, the loop is not closed or encloses no area, or the map fails on the given loop or
    /// returns states that are not finite at every step size: if it does so at some of them, the others are measured and
    /// those are noted ([`Omission`](crate::evidence::Omission)).
    pub fn measure(
        &self,
        map: &dyn TimeAdvance,
        phase_loop: &dyn Loop,
        watch: &dyn Fn(Event<'_>),
    ) -> Result<Evidence, Error> {
        let mut evidence = match self.repeat {
            1 => self.measure_once(map, phase_loop, watch, 1)?,
            _ => self.measure_repeated(map, phase_loop, watch)?,
        };
        evidence.evaluations.add_radii(phase_loop.evaluations());
        Ok(evidence)
    }

    /// Measures the map itself, which makes `repeat` evaluations for each state.
    fn measure_once(
        &self,
        map: &dyn TimeAdvance,
        phase_loop: &dyn Loop,
        watch: &dyn Fn(Event<'_>),
        repeat: usize,
    ) -> Result<Evidence, Error> {
        if !self.has_step_size
            && (self.step_sizes != [STEP_SIZE_OF_MAP] || self.typical_step.is_some())
        {
            let only = Diagnostic {
                step_sizes: vec![STEP_SIZE_OF_MAP],
                typical_step: None,
                ..self.clone()
            };
            return only.measure_once(map, phase_loop, watch, repeat);
        }
        check_step_sizes(self)?;
        let budget = self.budget.unwrap_or_else(|| plan::default_budget(self));
        if budget < MIN_BUDGET {
            return Err(Error::OutOfRange {
                what: "budget of evaluations",
                value: budget as f64,
                remedy: "give 200 or more",
            });
        }
        if !(1..=MAX_LOOPS).contains(&self.loops) {
            return Err(Error::OutOfRange {
                what: "number of loops",
                value: self.loops as f64,
                remedy: "give 1 to 10,000",
            });
        }
        let count = EvaluationCount::new(budget);
        let mut evaluator = Evaluator::new(map, &count)?;
        if !self.project {
            evaluator = evaluator.without_constraint();
        }
        if !self.has_step_size {
            evaluator = evaluator.without_step_size();
        }
        evaluator.check_dof(phase_loop.dof())?;
        check_reversal(self.reversal.as_deref(), evaluator.dof())?;
        check_closed(phase_loop, evaluator.coordinates())?;
        survey::wound(phase_loop, evaluator.coordinates())?;
        let given = evaluator.on_manifold(phase_loop);
        let subject = Subject {
            evaluator: &evaluator,
            phase_loop: &given,
        };
        let progress = Arc::new(Progress::new(count.finished(), budget, repeat));
        watch(Event::Started(&progress));
        let diagnostic = &match (self.step_sizes.is_empty(), self.typical_step) {
            (true, Some(typical)) => Diagnostic {
                step_sizes: step_sizes(subject, typical)?,
                ..self.clone()
            },
            _ => self.clone(),
        };
        let mut evidence = Evidence {
            expected_order: self.order.filter(|_| self.has_step_size),
            ..Evidence::default()
        };
        evidence.evaluations.budget = budget;
        evidence.evaluations.add(Check::StepSizes, count.made());
        let mut run = Runner::new(diagnostic, (watch, &progress), &evaluator, evidence);
        let given = run.begin(subject)?;
        run.complete(subject, &given)?;
        run.evidence.evaluations.made = count.made();
        run.evidence.evaluations.wanted = diagnostic.missing(subject, &run.evidence)?;
        Ok(run.evidence)
    }

    /// Measures the map composed with itself. In the budget and in the count, every state takes as many
    /// evaluations.
    fn measure_repeated(
        &self,
        map: &dyn TimeAdvance,
        phase_loop: &dyn Loop,
        watch: &dyn Fn(Event<'_>),
    ) -> Result<Evidence, Error> {
        let map = Repeat::new(map, self.repeat)?;
        let budget = self.budget.unwrap_or_else(|| plan::default_budget(self));
        let once = Diagnostic {
            repeat: 1,
            budget: Some(budget / self.repeat),
            ..self.clone()
        };
        if budget / self.repeat < MIN_BUDGET {
            return Err(Error::OutOfRange {
                what: "budget of evaluations",
                value: budget as f64,
                remedy: "give at least 200 times the number of repetitions",
            });
        }
        let mut evidence = once.measure_once(&map, phase_loop, watch, self.repeat)?;
        evidence.evaluations = evidence.evaluations.times(self.repeat);
        evidence.evaluations.budget = budget;
        if let Some(structure) = &mut evidence.structure {
            structure.steps = self.repeat;
        }
        Ok(evidence)
    }
}

fn check_reversal(signs: Option<&[f64]>, dof: usize) -> Result<(), Error> {
    let Some(signs) = signs else {
        return Ok(());
    };
    if signs.len() != 2 * dof {
        return Err(Error::OutOfRange {
            what: "number of signs of the reversal",
            value: signs.len() as f64,
            remedy: "give 1 or -1 for each position, then for each momentum",
        });
    }
    match signs.iter().find(|sign| sign.abs() != 1.0) {
        Some(&value) => Err(Error::OutOfRange {
            what: "a sign of the reversal",
            value,
            remedy: "give 1 or -1",
        }),
        None => Ok(()),
    }
}

fn check_step_sizes(diagnostic: &Diagnostic) -> Result<(), Error> {
    let of_samples = (diagnostic.sample_sweep.as_ref()).map(|sweep| sweep.step_size);
    let sizes = diagnostic.step_sizes.iter().copied();
    for h in sizes.chain(of_samples).chain(diagnostic.typical_step) {
        if !h.is_finite() || h == 0.0 {
            return Err(Error::OutOfRange {
                what: "step size",
                value: h,
                remedy: "give finite step sizes that are not zero",
            });
        }
    }
    // Halvings of a denormal number are rounded.
    if let Some(typical) = diagnostic
        .typical_step
        .filter(|typical| !typical.is_normal())
    {
        return Err(Error::OutOfRange {
            what: "typical step size",
            value: typical,
            remedy: "give one of 2^-1022 or more",
        });
    }
    match diagnostic.step_sizes.is_empty() && diagnostic.typical_step.is_none() {
        true => Err(Error::OutOfRange {
            what: "number of step sizes",
            value: 0.0,
            remedy: "give one or more, or a typical one",
        }),
        false => Ok(()),
    }
}

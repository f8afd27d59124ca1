//! The checks of a diagnosis, a file or a folder for each, and what runs them.

mod break_sides;
pub(super) mod constraint;
mod contraction;
mod expected;
mod features;
mod given_loop;
mod jacobian;
mod localise;
mod many_steps;
pub(super) mod memory;
mod preserved_form;
mod random_loops;
mod sample_sweep;
mod structure;

use constraint::singular_cost;
use memory::{Noise, check_again, wrong_period};

use super::plan::Plan;
use super::resolve::probe::{Probe, StepMeasurement};
use super::{Diagnostic, Event, Progress};
use crate::error::Error;
use crate::evidence::{
    Check, Evidence, LoopBreak, Motion, Omission, OmissionReason, Point, StepEvidence, Sweep,
};
use crate::jacobian::TangentImages;
use crate::map::{EvaluationCount, Evaluator, Feature, LoopSize};
use crate::rules::Subject;

/// A diagnosis under way.
pub(super) struct Runner<'a> {
    pub(super) diagnostic: &'a Diagnostic,
    pub(super) watch: &'a dyn Fn(Event<'_>),
    pub(super) progress: &'a Progress,
    pub(super) count: &'a EvaluationCount,
    pub(super) plan: Plan,
    /// The largest step size that the map can take.
    pub(super) largest: f64,
    /// Step sizes at which the map failed on the given loop; it is not asked for them again.
    pub(super) failed: Vec<FailedStep>,
    /// Evaluations that loops take which are still to come, and of which the map was told.
    pub(super) reserved: usize,
    /// By how much results of one state differ.
    pub(super) noise: Option<Noise>,
    /// Features that the samples of loops do not resolve, with the number of the loop.
    pub(super) features: Vec<(usize, Feature)>,
    /// The columns of the Jacobian, for the search for another form.
    pub(super) images: Vec<TangentImages>,
    pub(super) evidence: Evidence,
}

/// A step size at which the map failed on the given loop.
#[derive(Clone)]
pub(super) struct FailedStep {
    pub(super) h: f64,
    pub(super) error: Error,
}

/// The given loop, ready to be advanced again, and what one of its steps costs.
pub(super) struct GivenLoop<'a> {
    pub(super) probe: Probe<'a>,
    pub(super) cost: usize,
    /// Its size, for tests near it.
    pub(super) size: LoopSize,
}

/// Measures a check that follows the given loop.
type Measure<'a> = fn(&mut Runner<'a>, Subject<'_>, &GivenLoop<'_>) -> Result<(), Error>;

impl<'a> Runner<'a> {
    /// A diagnosis that has measured nothing yet.
    pub(super) fn new(
        diagnostic: &'a Diagnostic,
        (watch, progress): (&'a dyn Fn(Event<'_>), &'a Progress),
        evaluator: &Evaluator<'a>,
        evidence: Evidence,
    ) -> Self {
        Runner {
            diagnostic,
            watch,
            progress,
            count: evaluator.count(),
            plan: Plan::new(
                diagnostic,
                evidence.evaluations.budget,
                evaluator,
                singular_cost(evaluator.dof()),
            ),
            largest: largest_of(diagnostic.step_sizes.iter().copied()),
            failed: Vec::new(),
            reserved: 0,
            noise: None,
            features: Vec::new(),
            images: Vec::new(),
            evidence,
        }
    }

    /// The checks that follow the given loop, in their order.
    fn checks() -> [(Check, Measure<'a>); 14] {
        [
            (Check::RandomLoops, Self::random_loops),
            (Check::RandomLoops, Self::check_periods),
            (Check::RandomLoops, Self::reach),
            (Check::ManySteps, Self::many_steps),
            (Check::Jacobian, Self::jacobian),
            (Check::Jacobian, Self::test_features),
            (Check::Constraint, Self::look_for_manifold),
            (Check::Constraint, Self::look_for_leaf),
            (Check::Contraction, Self::contract),
            (Check::Localisation, Self::localise),
            (Check::SampleSweep, Self::sweep_samples),
            (Check::BreakSides, Self::look_at_break),
            (Check::PreservedForm, Self::look_for_form),
            (Check::Structure, Self::structure),
        ]
    }

    /// Measures the given loop, and checks the map, at the largest step size that the map can take.
    ///
    /// # Errors
    /// Any error but those of the map at some of the step sizes. If the map fails at all of them, or at the largest and the smallest, the
    /// error of the largest.
    pub(super) fn begin<'s>(&mut self, subject: Subject<'s>) -> Result<GivenLoop<'s>, Error> {
        loop {
            match self.try_largest(subject) {
                // The map need not be able to take every step.
                Err(error) if error.is_of_map() => {
                    (self.watch)(Event::Failed(&error));
                    if self.failed.is_empty() && self.fails_at_smallest(subject)? {
                        return Err(error);
                    }
                    let h = self.largest;
                    self.failed.push(FailedStep { h, error });
                    self.largest = largest_of(self.sizes());
                    if self.largest == 0.0 {
                        return Err(self.failed.swap_remove(0).error);
                    }
                    subject.evaluator.begin_loop();
                    self.noise = None;
                    self.features.clear();
                    self.evidence = Evidence {
                        evaluations: std::mem::take(&mut self.evidence.evaluations),
                        expected_order: self.evidence.expected_order,
                        ..Evidence::default()
                    };
                }
                // The failed steps spent the budget: their error is what the user needs.
                Err(Error::BudgetSpent { .. }) if !self.failed.is_empty() => {
                    return Err(self.failed.swap_remove(0).error);
                }
                begun => return begun,
            }
        }
    }

    /// Whether the map fails at the smallest step size too, by one state: a program that hangs would spend its time limit at each size.
    fn fails_at_smallest(&mut self, subject: Subject<'_>) -> Result<bool, Error> {
        let smallest = self.sizes().min_by(|a, b| a.abs().total_cmp(&b.abs()));
        let Some(h) = smallest.filter(|h| *h != self.largest) else {
            return Ok(false);
        };
        let image = self.counted(Check::GivenLoop, |_| {
            subject.evaluator.image(subject.phase_loop, h, &[0.0])
        });
        match image {
            Err(error) if error.is_of_map() => Ok(true),
            Err(Error::BudgetSpent { .. }) => Ok(false),
            image => image.map(|_| false),
        }
    }

    /// Measures the given loop, and checks the map, at the largest step size.
    fn try_largest<'s>(&mut self, subject: Subject<'s>) -> Result<GivenLoop<'s>, Error> {
        let beside = self.counted(Check::Memory, |run| run.look_first(subject))?;
        let given = self.counted(Check::GivenLoop, |run| run.given_loop(subject))?;
        self.counted(Check::Memory, |run| {
            run.evidence.survey.wrong_period = wrong_period(subject, run.largest)?;
            if let Some(error) = beside {
                return Err(error);
            }
            let noise = check_again(subject.evaluator, true, run.noise.clone())?;
            run.note_noise(subject.evaluator, noise);
            Ok(())
        })?;
        Ok(given)
    }

    /// Makes the checks that follow the given loop, and looks once more at states from before.
    pub(super) fn complete(
        &mut self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
    ) -> Result<(), Error> {
        for (k, (check, measure)) in Self::checks().into_iter().enumerate() {
            self.expect_from(k, subject, given.costs());
            self.check(check, |run| measure(run, subject, given))?;
        }
        // Jacobian and localisation note any error and continue.
        subject.evaluator.check_not_stopped()?;
        self.progress.expect(self.of_memory(), 0);
        self.counted(Check::Memory, |run| run.look_again(subject.evaluator))
    }

    /// Counts the evaluations of a check, and notes why it was left out if the budget was spent or the map failed.
    fn check(
        &mut self,
        check: Check,
        measure: impl FnOnce(&mut Self) -> Result<(), Error>,
    ) -> Result<(), Error> {
        match self.counted(check, measure) {
            Err(Error::BudgetSpent { .. }) => self.omit(check, OmissionReason::BUDGET),
            Err(error) if error.is_of_map() => self.omit(check, failed(&error)),
            measured => return measured,
        }
        Ok(())
    }

    /// Counts the evaluations of a check.
    fn counted<T>(&mut self, check: Check, measure: impl FnOnce(&mut Self) -> T) -> T {
        self.progress.begin(check);
        let start = self.count.made();
        let measured = measure(self);
        let made = self.count.made() - start;
        self.evidence.evaluations.add(check, made);
        measured
    }

    /// Notes what is left out.
    fn omit(&mut self, check: Check, why: OmissionReason) {
        self.evidence.omissions.push(Omission { check, why });
    }

    /// The step sizes at which the map did not fail on the given loop, in the order in which they were given.
    fn sizes(&self) -> impl Iterator<Item = f64> {
        let sizes = self.diagnostic.step_sizes.iter().copied();
        sizes.filter(|&h| self.failed.iter().all(|failed| failed.h != h))
    }

    /// Evaluations left for loops: what the Jacobian, the domain of the map and loops to come will take is kept.
    fn left(&self) -> usize {
        let kept = self.plan.jacobian + self.plan.domain + self.reserved;
        self.count.left().saturating_sub(kept)
    }

    /// Tells of what was measured, and keeps it.
    fn record(
        &mut self,
        loop_index: usize,
        sweep: Sweep,
        probe: &Probe<'_>,
        known: &StepMeasurement,
    ) {
        let step: StepEvidence = probe.evidence(known);
        (self.watch)(Event::Measured(&Point::new(sweep, loop_index, &step)));
        let all = loop_index == 0 && known.h == self.largest && sweep == Sweep::StepSize;
        let breaks = match all {
            true => known.advanced.breaks.clone(),
            false => step.jump.into_iter().collect(),
        };
        self.evidence
            .breaks
            .extend(breaks.into_iter().map(|found| LoopBreak {
                loop_index,
                step_size: step.step_size,
                found,
            }));
        match sweep {
            Sweep::Samples => self.evidence.sample_sweep.push(step),
            Sweep::StepSize => {
                let found = self.evidence.loops.last_mut();
                found.expect("the loop was recorded").steps.push(step);
            }
        }
    }

    /// Keeps how the largest step moves the last loop.
    fn moved(&mut self, motion: Option<Motion>) {
        let steps = self
            .evidence
            .loops
            .iter_mut()
            .last()
            .map(|found| &mut found.steps);
        let wanted = self.diagnostic.has_step_size.then_some(self.largest);
        let largest = |step: &&mut StepEvidence| step.step_size == wanted;
        if let Some(step) = steps.and_then(|steps| steps.iter_mut().find(largest)) {
            step.motion = motion;
        }
    }
}

/// The step size with the largest magnitude; 0 without step sizes.
fn largest_of(sizes: impl Iterator<Item = f64>) -> f64 {
    sizes.fold(0.0, |a, b| if b.abs() > a.abs() { b } else { a })
}

/// The map failed at states near the given loop.
fn failed(error: &Error) -> OmissionReason {
    OmissionReason::Failed {
        step_size: None,
        reason: error.to_string(),
    }
}

/// The result of a test at states at which the map need not be defined, or that is optional: `None` if the map failed or the budget was spent.
fn if_possible<T>(found: Result<Option<T>, Error>) -> Result<Option<T>, Error> {
    match found {
        Err(Error::BudgetSpent { .. }) => Ok(None),
        Err(error) if error.is_of_map() => Ok(None),
        found => found,
    }
}

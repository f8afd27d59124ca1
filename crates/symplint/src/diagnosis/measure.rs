//! Carrying out the plan: fills the evidence.

mod domain;
mod features;
mod other_loops;
mod reach;

use super::initial_samples::InitialSamples;
use super::limits::{
    CLEAR_OF_METHOD, DECAY_PART, FEWEST_OF_AN_ORDER, KEPT_PART, LEAST_BUDGET, MOST_LOOPS, SMALL,
};
use super::plan::{self, Plan};
use super::probe::{Known, Probe};
use super::refined_samples::RefinedSamples;
use super::resolve::Resolution;
use super::step_sizes::step_sizes;
use super::{Diagnostic, Event, SampleCount, long_time};
use crate::breaks::Break;
use crate::error::Error;
use crate::evidence::{
    BreakAt, Check, Evidence, LoopEvidence, LoopKind, Motion, Omission, Point, StepEvidence, Sweep,
    Why,
};
use crate::jacobian::{JacobianDecay, JacobianEvidence, JacobianTest};
use crate::loops::{Loop, check_closed};
use crate::map::{EvaluationCount, Evaluator, Feature, LoopSize, Repeat, TimeAdvance};
use crate::rules::{Rule, RuleKind, Subject};
use crate::state::Ensemble;
use crate::survey;

impl Diagnostic {
    /// Measures, and concludes nothing.
    ///
    /// `watch` is told of each point as it is measured. Where the number of samples is looked for, or
    /// swept over, samples before and after a step are kept and doubled: no evaluation is made twice, but for a few
    /// that show whether results depend on earlier calls or on the batch. In a sweep over step sizes one ensemble is in memory, and the
    /// samples before the step too where they take 64 MiB at most; larger ones are made anew for each step size,
    /// block by block. By the streaming rule it is a few dozen states; what needs larger ensembles (the Jacobian,
    /// many steps) is then left out where they take more than 512 MiB.
    ///
    /// # Errors
    /// If map and loop do not fit, a step size is zero or not finite, the budget is below 200, there is no loop or too many, results depend on
    /// earlier calls or on the batch, the loop is random, the loop is not closed or encloses no area, or the map fails on the given loop or
    /// returns states that are not finite at every step size: where it does so at some of them, the others are measured and
    /// those are noted ([`Omission`]).
    pub fn measure(
        &self,
        map: &dyn TimeAdvance,
        phase_loop: &dyn Loop,
        watch: &dyn Fn(Event<'_>),
    ) -> Result<Evidence, Error> {
        if self.repeat != 1 {
            return self.measure_repeated(map, phase_loop, watch);
        }
        if !self.has_step_size && (self.step_sizes != [ONLY_STEP] || self.typical_step.is_some()) {
            let only = Diagnostic {
                step_sizes: vec![ONLY_STEP],
                typical_step: None,
                ..self.clone()
            };
            return only.measure(map, phase_loop, watch);
        }
        check_step_sizes(self)?;
        let budget = self.budget.unwrap_or_else(|| plan::default_budget(self));
        if budget < LEAST_BUDGET {
            return Err(Error::OutOfRange {
                what: "budget of evaluations",
                value: budget as f64,
                remedy: "give 200 or more",
            });
        }
        if !(1..=MOST_LOOPS).contains(&self.loops) {
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
        check_closed(phase_loop, evaluator.coordinates())?;
        survey::wound(phase_loop, evaluator.coordinates())?;
        let given = evaluator.on_manifold(phase_loop);
        let subject = Subject {
            evaluator: &evaluator,
            phase_loop: &given,
        };
        let diagnostic = &match (self.step_sizes.is_empty(), self.typical_step) {
            (true, Some(typical)) => Diagnostic {
                step_sizes: step_sizes(subject, typical)?,
                ..self.clone()
            },
            _ => self.clone(),
        };
        let mut evidence = Evidence::default();
        evidence.evaluations.budget = budget;
        evidence.evaluations.add(Check::StepSizes, count.made());
        let mut failed: Vec<FailedStep> = Vec::new();
        let mut sizes = diagnostic.step_sizes.clone();
        let (mut run, given) = loop {
            let largest = largest_of(&sizes);
            let start = Run {
                diagnostic,
                watch,
                count: &count,
                plan: Plan::new(diagnostic, budget, &evaluator),
                largest,
                failed: failed.clone(),
                reserved: 0,
                noise: None,
                features: Vec::new(),
                evidence: evidence.clone(),
            };
            match start.begin(subject) {
                // The map need not be able to take every step.
                Err(error) if of_the_map(&error) => {
                    sizes.retain(|&h| h != largest);
                    if sizes.is_empty() {
                        // Of the largest step size.
                        return Err(failed.into_iter().next().map_or(error, |first| first.error));
                    }
                    evaluator.begin_loop();
                    watch(Event::Failed(&error));
                    failed.push(FailedStep { h: largest, error });
                }
                // The failed steps spent the budget: their error is what the user needs.
                Err(Error::BudgetSpent { .. }) if !failed.is_empty() => {
                    return Err(failed.swap_remove(0).error);
                }
                begun => break begun?,
            }
        };
        for (check, measure) in Run::checks() {
            run.check(check, |run| measure(run, subject, &given))?;
        }
        // Jacobian and localisation note any error and go on.
        evaluator.check_not_stopped()?;
        run.counted(Check::Memory, |run| run.look_again(&evaluator, &sizes))?;
        run.evidence.evaluations.made = count.made();
        run.evidence.evaluations.wanted = diagnostic.missing(subject, &run.evidence)?;
        Ok(run.evidence)
    }

    /// Measures the map composed with itself. Of the budget, and of what was made of it, every state takes as many
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
        if budget / self.repeat < LEAST_BUDGET {
            return Err(Error::OutOfRange {
                what: "budget of evaluations",
                value: budget as f64,
                remedy: "give at least 200 times the number of repetitions",
            });
        }
        let mut evidence = once.measure(&map, phase_loop, watch)?;
        evidence.evaluations = evidence.evaluations.times(self.repeat);
        evidence.evaluations.budget = budget;
        Ok(evidence)
    }
}

/// If a map wraps a coordinate, the other one of its degree of freedom jumps by at most this part of the jump: it is continuous, and
/// the ends of a break are a rounding apart. Conventional.
const OF_A_WRAP: f64 = 1e-6;

/// What a map without a step size is called with.
const ONLY_STEP: f64 = 1.0;

/// The step size of the largest size, of one or more.
fn largest_of(sizes: &[f64]) -> f64 {
    let largest = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
    sizes.iter().copied().fold(0.0, largest)
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

/// A diagnosis under way.
struct Run<'a> {
    diagnostic: &'a Diagnostic,
    watch: &'a dyn Fn(Event<'_>),
    count: &'a EvaluationCount,
    plan: Plan,
    /// The largest step size that the map can take.
    largest: f64,
    /// Step sizes at which the map failed on the given loop; it is not asked for them again.
    failed: Vec<FailedStep>,
    /// Evaluations that loops take which are still to come, and of which the map was told.
    reserved: usize,
    /// By how much results of one state differ.
    noise: Option<survey::Noise>,
    /// Features that the samples of loops do not resolve, with the number of the loop.
    features: Vec<(usize, Feature)>,
    evidence: Evidence,
}

/// A step size at which the map failed on the given loop.
#[derive(Clone)]
struct FailedStep {
    h: f64,
    error: Error,
}

/// The given loop, ready to be advanced again, and what one of its steps costs.
struct Given<'a> {
    probe: Probe<'a>,
    cost: usize,
    /// What it suggests for tests beside it.
    size: LoopSize,
}

/// What a check measures beside the given loop.
type Measure<'a> = fn(&mut Run<'a>, Subject<'_>, &Given<'_>) -> Result<(), Error>;

impl<'a> Run<'a> {
    /// The checks that follow the given loop, in their order.
    fn checks() -> [(Check, Measure<'a>); 11] {
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
        ]
    }

    /// Counts the evaluations of a check, and notes why it was left out if the budget was spent or the map failed.
    fn check(
        &mut self,
        check: Check,
        measure: impl FnOnce(&mut Self) -> Result<(), Error>,
    ) -> Result<(), Error> {
        match self.counted(check, measure) {
            Err(Error::BudgetSpent { .. }) => self.omit(check, Why::BUDGET),
            Err(error) if of_the_map(&error) => self.omit(check, failed(&error)),
            measured => return measured,
        }
        Ok(())
    }

    /// Counts the evaluations of a check.
    fn counted<T>(&mut self, check: Check, measure: impl FnOnce(&mut Self) -> T) -> T {
        let start = self.count.made();
        let measured = measure(self);
        let made = self.count.made() - start;
        self.evidence.evaluations.add(check, made);
        measured
    }
}

impl Run<'_> {
    /// Checks the map at the largest step size, and measures the given loop.
    fn begin<'s>(mut self, subject: Subject<'s>) -> Result<(Self, Given<'s>), Error> {
        // Step sizes that failed before were tried on the given loop, too.
        let of_failed = self.count.made() - self.evidence.evaluations.of(Check::StepSizes);
        self.evidence.evaluations.add(Check::GivenLoop, of_failed);
        let beside = self.counted(Check::Memory, |run| run.look_first(subject))?;
        let given = self.counted(Check::GivenLoop, |run| run.given_loop(subject))?;
        self.counted(Check::Memory, |run| {
            run.evidence.survey.wrong_period = survey::wrong_period(subject, run.largest)?;
            if let Some(error) = beside {
                return Err(error);
            }
            let noise = survey::check_again(subject.evaluator, true, run.noise.clone())?;
            run.note_noise(subject.evaluator, noise);
            Ok(())
        })?;
        Ok((self, given))
    }

    /// Tests whether results depend on earlier calls, and how they are rounded. The error of the map beside the given loop, if it fails
    /// there: where the given loop fails, too, its samples tell more of where that is.
    fn look_first(&mut self, subject: Subject<'_>) -> Result<Option<Error>, Error> {
        let Subject {
            evaluator,
            phase_loop,
        } = subject;
        let (samples, witnesses) = (self.plan.purity_samples, self.plan.witnesses);
        evaluator.keep_witnesses(witnesses);
        self.count.reserve(survey::cost_again(witnesses));
        match survey::rounding_inside(subject, self.largest) {
            Ok(None) => {}
            Ok(Some(grains)) => {
                evaluator.note_rounding_inside(grains);
                self.evidence.survey.single_inside = true;
            }
            // Samples of the loop will show it, or miss it.
            Err(error) if of_the_map(&error) => {}
            Err(error) => return Err(error),
        }
        match survey::check_purity(evaluator, phase_loop, self.largest, samples) {
            Ok(noise) => {
                self.note_noise(evaluator, noise);
                Ok(None)
            }
            // One failure is described as well as possible, further ones at little cost.
            Err(error) if of_the_map(&error) && self.failed.is_empty() => Ok(Some(error)),
            Err(error) => Err(error),
        }
    }

    /// Keeps by how much results of one state differ: the rules allow for it.
    fn note_noise(&mut self, evaluator: &Evaluator<'_>, noise: Option<survey::Noise>) {
        if noise == self.noise {
            return;
        }
        let scatter = noise.as_ref().and_then(survey::Noise::scatter);
        self.evidence.survey.scatter = scatter;
        // Random numbers look like single precision.
        self.evidence.survey.single_inside &= !scatter.is_some_and(|of| of.is_random());
        if let Some(noise) = &noise {
            evaluator.note_rounding_inside(noise.units());
            if let Some(deviations) = noise.deviations() {
                evaluator.note_noise(deviations);
            }
        }
        self.noise = noise;
    }

    /// Advances states of the batches before once more, and one of them by steps of other sizes.
    fn look_again(&mut self, evaluator: &Evaluator<'_>, sizes: &[f64]) -> Result<(), Error> {
        self.count.reserve(0);
        let noise = survey::check_again(evaluator, false, self.noise.clone())?;
        self.note_noise(evaluator, noise);
        self.evidence.survey.ignores_step_size = survey::ignores_step_size(evaluator, sizes)?;
        Ok(())
    }

    /// Checks that no loop needs a period that is not one of the map: a given loop that winds, or a loop that breaks in periodic
    /// coordinates alone, because the map wraps them by another period. (A kick, a wall or a solver also changes the other
    /// coordinate of the degree of freedom.)
    fn check_periods(&mut self, subject: Subject<'_>, _: &Given<'_>) -> Result<(), Error> {
        let coordinates = subject.coordinates();
        let Some(wrong) = self.evidence.survey.wrong_period else {
            return Ok(());
        };
        let is_wrapped = |at: &BreakAt| {
            let Break {
                dof,
                jump_q,
                jump_p,
                ..
            } = at.found;
            let alone = |jump: f64, other: f64| other.abs() <= OF_A_WRAP * jump.abs();
            coordinates.period(dof) > 0.0 && alone(jump_q, jump_p)
                || coordinates.momentum_period(dof) > 0.0 && alone(jump_p, jump_q)
        };
        let winds = self.evidence.loops.iter().any(|found| found.winds);
        match winds || self.evidence.breaks.iter().any(is_wrapped) {
            true => Err(wrong.into_error()),
            false => Ok(()),
        }
    }

    /// Whether the map failed at this step size on the given loop.
    fn has_failed(&self, h: f64) -> bool {
        self.failed.iter().any(|failed| failed.h == h)
    }

    /// Evaluations left for loops: what the Jacobian, the domain of the map and loops to come will take is kept.
    fn left(&self) -> usize {
        let kept = self.plan.jacobian + self.plan.domain + self.reserved;
        self.count.left().saturating_sub(kept)
    }

    /// The given loop at all step sizes that the budget allows, the largest first of all.
    fn given_loop<'s>(&mut self, subject: Subject<'s>) -> Result<Given<'s>, Error> {
        let diagnostic = self.diagnostic;
        let left = self.left();
        let (budget, tight) = (self.count.budget(), self.plan.is_tight());
        let mut seen = None;
        let mut look = |after: &Ensemble| seen = Some(survey::of_samples(subject, after));
        let with = Resolution {
            h: self.largest,
            plan: &self.plan,
            most_samples: self.plan.most_samples(diagnostic, budget, left),
            allowance: left / KEPT_PART * (KEPT_PART - 1),
        };
        let probe = diagnostic.resolve(subject, &with, &mut look)?;
        let samples = &mut InitialSamples::new(subject);
        let judged = probe.measure(samples, self.largest, &mut look)?;
        let cost = judged.evaluations.max(1);
        let seen = match seen {
            Some(seen) => seen,
            None => survey::of_few_samples(subject, self.largest)?,
        };
        self.evidence.survey.one_state = seen.one_state;
        let of_grain = || survey::of_grain(&*subject.evaluator.grain()?);
        self.evidence.survey.output_precision = seen.output_precision.or_else(of_grain);

        let mut given = LoopEvidence::new(0, LoopKind::Given);
        given.rule = probe.rule.kind();
        if given.rule == RuleKind::Auto {
            given.rule = RuleKind::Pseudospectral;
        }
        given.samples = probe.samples;
        given.wound = survey::wound(subject.phase_loop, subject.coordinates())?;
        given.winds = !given.wound.is_empty();
        self.evidence.loops.push(given);
        let affordable = self.affordable_steps(cost);
        (self.watch)(Event::Planned(affordable.len()));
        if probe.keeps_samples() {
            let further = affordable.iter().copied().filter(|&h| h != self.largest);
            samples.prefetch(probe.samples, further.take(self.left() / cost));
        }
        let mut omitted = diagnostic.step_sizes.len() - self.failed.len() - affordable.len();
        for h in affordable {
            let known = match h == self.largest {
                true => judged.clone(),
                false if self.left() < probe.least_cost() => {
                    omitted += 1;
                    continue;
                }
                false => match probe.measure(samples, h, &mut |_| {}) {
                    Err(Error::BudgetSpent { .. }) => {
                        omitted += 1;
                        continue;
                    }
                    Err(error) if of_the_map(&error) => {
                        (self.watch)(Event::Failed(&error));
                        self.failed.push(FailedStep { h, error });
                        continue;
                    }
                    measured => measured?,
                },
            };
            let with = Resolution {
                h,
                plan: &self.plan,
                most_samples: probe.samples,
                allowance: known.evaluations + self.left() / KEPT_PART,
            };
            let judged = (&probe, &judged.advanced);
            let refined = || samples.last(h);
            // The samples themselves were advanced, if the map fails between them.
            match if_possible(diagnostic.reconsidered(judged, &known, refined, &with))? {
                Some(again) => {
                    let known = again.known(h).unwrap_or(&known);
                    self.record(0, Sweep::StepSize, &again, known);
                }
                None => self.record(0, Sweep::StepSize, &probe, &known),
            }
        }
        self.keep_features(0, subject);
        for FailedStep { h, error } in &self.failed {
            self.evidence.omissions.push(Omission {
                check: Check::GivenLoop,
                why: Why::Failed {
                    step_size: Some(*h),
                    reason: error.to_string(),
                },
            });
        }
        self.moved(seen.motion);
        if omitted > 0 {
            self.omit(Check::GivenLoop, Why::Budget { missing: omitted });
        }
        let unresolved = match diagnostic.samples {
            SampleCount::Fixed(samples) => probe.samples < samples,
            SampleCount::Auto => tight && self.evidence.loops[0].weak_step().is_some(),
        };
        if unresolved {
            self.omit(Check::GivenLoop, Why::Unresolved);
        }
        let size = LoopSize::of(subject.evaluator, subject.phase_loop, self.largest)?;
        Ok(Given { probe, cost, size })
    }

    /// The step sizes that the budget allows, in the order in which they were given: all, or the largest ones, so
    /// that something is left for random loops.
    fn affordable_steps(&self, cost: usize) -> Vec<f64> {
        let sizes = &self.diagnostic.step_sizes;
        let units = self.left() / cost;
        let random = self.diagnostic.loops - 1;
        let further = (units / 2).max(units.saturating_sub(random));
        let mut order: Vec<usize> = (0..sizes.len())
            .filter(|&k| !self.has_failed(sizes[k]))
            .collect();
        order.sort_by(|&a, &b| sizes[b].abs().total_cmp(&sizes[a].abs()));
        order.truncate(1 + further);
        order.sort_unstable();
        order.into_iter().map(|k| sizes[k]).collect()
    }

    /// The given loop with other numbers of samples, if they are asked for.
    fn sweep_samples(&mut self, _: Subject<'_>, given: &Given<'_>) -> Result<(), Error> {
        let (diagnostic, probe) = (self.diagnostic, &given.probe);
        let Some(sweep) = &diagnostic.sample_sweep else {
            return Ok(());
        };
        (self.watch)(Event::Planned(sweep.counts.len()));
        let h = match self.diagnostic.has_step_size {
            true => sweep.step_size,
            false => ONLY_STEP,
        };
        let subject = probe.subject;
        subject.evaluator.begin_loop();
        let mut refined: Option<RefinedSamples<'_>> = None;
        for (k, &samples) in sweep.counts.iter().enumerate() {
            let before = self.count.made();
            if samples > self.count.left() {
                let missing = sweep.counts[k..].len();
                self.omit(Check::SampleSweep, Why::Budget { missing });
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
                let of_samples = Probe::new(subject, probe.rule, samples)?;
                let known =
                    of_samples.measure(&mut InitialSamples::new(subject), h, &mut |_| {})?;
                (of_samples, known.advanced)
            };
            let known = Known {
                h,
                advanced,
                evaluations: self.count.made() - before,
            };
            self.record(0, Sweep::Samples, &of_samples, &known);
        }
        Ok(())
    }

    /// Tells of what was measured, and keeps it.
    fn record(&mut self, loop_index: usize, sweep: Sweep, probe: &Probe<'_>, known: &Known) {
        let step: StepEvidence = probe.evidence(known);
        (self.watch)(Event::Measured(&Point::new(sweep, loop_index, &step)));
        let all = loop_index == 0 && known.h == self.largest && sweep == Sweep::StepSize;
        let breaks = match all {
            true => known.advanced.breaks.clone(),
            false => step.jump.into_iter().collect(),
        };
        self.evidence
            .breaks
            .extend(breaks.into_iter().map(|found| BreakAt {
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

    /// Notes what is left out.
    fn omit(&mut self, check: Check, why: Why) {
        self.evidence.omissions.push(Omission { check, why });
    }

    /// The given loop in many steps, if they are asked for.
    fn many_steps(&mut self, _: Subject<'_>, given: &Given<'_>) -> Result<(), Error> {
        let steps = self.diagnostic.long_time;
        if steps == 0 {
            return Ok(());
        }
        match long_time::follow(&given.probe, self.largest, steps, self.left())? {
            Ok(found) => self.evidence.long_time = Some(found),
            Err(why) => self.omit(Check::ManySteps, why),
        }
        Ok(())
    }

    /// The Jacobian of the largest step, on the given loop.
    fn jacobian(&mut self, subject: Subject<'_>, given: &Given<'_>) -> Result<(), Error> {
        if !self.diagnostic.jacobian {
            return Ok(());
        }
        if given.probe.is_beyond_memory() {
            self.omit(Check::Jacobian, Why::Memory { samples: SMALL });
            return Ok(());
        }
        let Subject {
            evaluator,
            phase_loop,
        } = subject;
        let left = self.count.left().saturating_sub(self.plan.domain);
        let planned = self.plan.jacobian;
        match JacobianTest::within(left.min(planned), evaluator.dof(), evaluator.has_tangent()) {
            None => self.omit(Check::Jacobian, Why::BUDGET),
            Some(test) => {
                // Further groups of degrees of freedom, and tracing a defect, take as much again.
                let further = planned.saturating_mul(1 + given.size.groups.len().max(1));
                let test = JacobianTest {
                    budget: left.min(further),
                    ..test
                };
                match test.run_with(evaluator, phase_loop, &given.size, self.largest) {
                    Ok(found) => {
                        self.evidence.jacobian_decay =
                            self.jacobian_decay(&test, subject, &given.size, &found);
                        self.evidence.jacobian = Some(found);
                    }
                    // It displaces states off the loop, where the map need not be defined.
                    Err(error) => self.omit(Check::Jacobian, failed(&error)),
                }
            }
        }
        Ok(())
    }

    /// The defect of the Jacobian at a second step size, if the loops may have an order: at the smallest step size at which
    /// the defect is expected to be well above what its method resolves.
    fn jacobian_decay(
        &self,
        test: &JacobianTest,
        subject: Subject<'_>,
        size: &LoopSize,
        found: &JacobianEvidence,
    ) -> Option<JacobianDecay> {
        let (_, worst) = found.worst_point().filter(|_| found.shows_defect())?;
        let largest_step = found.step_size?;
        let significant = |of: &LoopEvidence| -> Vec<(f64, f64)> {
            (of.steps.iter().filter(|step| step.is_significant()))
                .filter_map(|step| Some((step.step_size?, step.defect.magnitude())))
                .collect()
        };
        let loops = self.evidence.loops.iter().filter(|of| !of.winds);
        let of_loops = loops.map(significant);
        let expected = of_loops
            .filter(|steps| steps.len() >= FEWEST_OF_AN_ORDER)
            .flat_map(|steps| {
                let largest = steps.iter().find(|(h, _)| *h == largest_step);
                let at_largest = largest.map_or(f64::INFINITY, |(_, defect)| *defect);
                let fallen = move |(h, defect)| (h, worst.magnitude() * defect / at_largest);
                steps.into_iter().map(fallen)
            });
        let least = CLEAR_OF_METHOD * found.method.least_defect();
        let h = expected
            .filter(|&(h, defect)| h.abs() < largest_step.abs() && defect >= least)
            .map(|(h, _)| h)
            .min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
        let evaluator = subject.evaluator;
        let one = JacobianTest { points: 1, ..*test };
        let groups = if found.full {
            1
        } else {
            size.groups.len().max(1)
        };
        let cost = groups * one.evaluations(evaluator.dof(), evaluator.has_tangent());
        let left = self.count.left().saturating_sub(self.plan.domain);
        if cost > left.min(self.count.made() / DECAY_PART) {
            return None;
        }
        // A witness that fails is not missed: the loops are measured.
        (one.decay(evaluator, subject.phase_loop, size, found, h)).ok()?
    }

    /// Looks where a defect comes from, on the first loop that shows it.
    fn localise(&mut self, subject: Subject<'_>, given: &Given<'_>) -> Result<(), Error> {
        let survey = &self.evidence.survey;
        let off_manifold = survey.singular.is_some() || survey.degenerate_form.is_some();
        if !self.diagnostic.localise || off_manifold || given.probe.is_beyond_memory() {
            return Ok(());
        }
        // The integral of a loop that winds may change, and its period need not be one of the map.
        let broken = (self.evidence.loops.iter()).any(|found| !found.winds && found.is_broken());
        let Some(found) =
            (self.evidence.loops.iter()).find(|found| found.shows_defect() && !found.winds)
        else {
            return Ok(());
        };
        let most = subject.evaluator.substeps().saturating_mul(given.cost);
        if self.count.left() < most {
            self.omit(Check::Localisation, Why::BUDGET);
            return Ok(());
        }
        let found = self.diagnostic.locate(
            subject,
            &given.size,
            found,
            broken,
            self.largest,
            &self.plan,
        );
        match found {
            Ok(found) => self.evidence.localisation = Some(found),
            // Inside the loop, or between substeps, the map need not be defined.
            Err(error) => self.omit(Check::Localisation, failed(&error)),
        }
        Ok(())
    }
}

/// That the map failed beside the given loop.
fn failed(error: &Error) -> Why {
    Why::Failed {
        step_size: None,
        reason: error.to_string(),
    }
}

/// What was found where the map need not be defined, or where it was not asked for: `None` if the map failed or the budget was spent.
pub(super) fn if_possible<T>(found: Result<Option<T>, Error>) -> Result<Option<T>, Error> {
    match found {
        Err(Error::BudgetSpent { .. }) => Ok(None),
        Err(error) if of_the_map(&error) => Ok(None),
        found => found,
    }
}

/// Whether an error is one of the map on a loop, and not of what was asked for.
pub(super) fn of_the_map(error: &Error) -> bool {
    matches!(error, Error::NotFinite { .. } | Error::StepFailed { .. })
}

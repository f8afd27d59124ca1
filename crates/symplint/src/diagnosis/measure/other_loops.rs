//! The loops beside the given one: random ones, and one that winds round a period.

use super::{Given, Run, of_the_map};
use crate::diagnosis::Event;
use crate::diagnosis::initial_samples::InitialSamples;
use crate::diagnosis::plan;
use crate::diagnosis::random_loops::{loop_of_kind, random_kind};
use crate::diagnosis::resolve::Resolution;
use crate::error::Error;
use crate::evidence::{LoopEvidence, LoopKind, Omission, StepEvidence, Sweep};
use crate::map::{ImageLoop, LoopSize};
use crate::rules::{RuleKind, Subject};
use crate::state::Ensemble;
use crate::survey;

impl Run<'_> {
    /// Random loops at the largest step size, and a loop that winds round a period; the first that shows a defect
    /// at all step sizes.
    pub(super) fn random_loops(
        &mut self,
        subject: Subject<'_>,
        given: &Given<'_>,
    ) -> Result<(), Error> {
        let start = self.count.made();
        let diagnostic = self.diagnostic;
        let count = diagnostic.loops - 1;
        for index in 1..=count {
            if self.is_settled() {
                break;
            }
            // A loop that cannot be resolved as the given one was is no evidence.
            let least = if self.plan.is_tight() { given.cost } else { 0 };
            if self.left() < least.max(self.plan.first_samples) {
                let omitted = count + 1 - index;
                self.omit(Omission::RandomLoops { count: omitted });
                break;
            }
            let seed = diagnostic.seed.wrapping_add(index as u64);
            let kind = random_kind(&given.size, index);
            let Some(random) = loop_of_kind(kind, &given.size, subject.coordinates(), seed)? else {
                continue;
            };
            let subject = Subject {
                phase_loop: &subject.evaluator.on_manifold(random),
                ..subject
            };
            // The order is that of a full sweep, and a symmetric loop hides terms of lower
            // order: the given loop and one random one are worth it.
            let known = (self.evidence.loops[1..].iter()).any(LoopEvidence::shows_defect);
            match self.random_loop(index, kind, subject, known) {
                Ok(()) if self.is_unresolved() => {
                    self.evidence.loops.pop();
                    let omitted = count + 1 - index;
                    self.omit(Omission::RandomLoops { count: omitted });
                    break;
                }
                Ok(()) => {}
                Err(Error::BudgetSpent { .. }) => {
                    let omitted = count + 1 - index;
                    self.omit(Omission::RandomLoops { count: omitted });
                    break;
                }
                // A loop that nobody asked for may leave the map's domain.
                Err(error) if of_the_map(&error) => self.failed(index, kind, &error),
                // What nobody asked to move may be lost in rounding where it lies.
                Err(error @ (Error::NoArea { .. } | Error::LostInRounding { .. }))
                    if kind == LoopKind::Extended =>
                {
                    self.failed(index, kind, &error);
                }
                Err(error) => return Err(error),
            }
        }
        let winds = self.evidence.loops[0].winds;
        let affordable = self.left() >= given.cost.max(self.plan.first_samples);
        if count > 0 && !winds && !self.is_settled() && affordable {
            self.winding_loop(subject, &given.size)?;
        }
        self.evidence.evaluations.random_loops = self.count.made() - start;
        Ok(())
    }

    /// Whether a tight budget was spent before the last loop was resolved as the given one was: it is no evidence.
    fn is_unresolved(&self) -> bool {
        let (given, random) = (&self.evidence.loops[0], self.evidence.loops.last());
        let says_more = |step: &StepEvidence| {
            step.jump.is_some() || step.is_unexplained() || step.misses_the_grid()
        };
        let weak = |found: &LoopEvidence| {
            found.weak_step().is_some() && !found.steps.iter().any(says_more)
        };
        self.plan.is_tight() && given.is_bounded() && random.is_some_and(weak)
    }

    /// Whether further loops cannot change the verdict of a tight budget any more: the given loop breaks, or it and
    /// a random one change. (A symmetric loop hides terms of lower order: the order needs both.)
    fn is_settled(&self) -> bool {
        let (given, random) = self.evidence.loops.split_at(1);
        let broken = given[0].steps.iter().any(|step| step.jump.is_some());
        let shown = given[0].shows_defect() && random.iter().any(LoopEvidence::shows_defect);
        self.plan.is_tight() && !given[0].winds && (broken || shown)
    }

    /// A random loop round the period of a position, where there is one.
    fn winding_loop(&mut self, subject: Subject<'_>, size: &LoopSize) -> Result<(), Error> {
        let (index, seed) = (
            self.diagnostic.loops,
            self.diagnostic
                .seed
                .wrapping_add(self.diagnostic.loops as u64),
        );
        let found = loop_of_kind(LoopKind::Winding, size, subject.coordinates(), seed)?;
        let Some(winding) = found else {
            return Ok(());
        };
        let subject = Subject {
            phase_loop: &subject.evaluator.on_manifold(winding),
            ..subject
        };
        match self.random_loop(index, LoopKind::Winding, subject, true) {
            Err(error @ (Error::NoArea { .. } | Error::LostInRounding { .. })) => {
                let _ = error;
                Ok(())
            }
            // It was not asked for.
            Err(Error::BudgetSpent { .. }) => Ok(()),
            Err(error) if of_the_map(&error) => Ok(()),
            other => other,
        }
    }

    /// The given loop after one step, advanced by another one.
    pub(super) fn image_loop(&mut self, subject: Subject<'_>) -> Result<(), Error> {
        let image = ImageLoop {
            inner: subject.phase_loop,
            evaluator: subject.evaluator,
            h: self.largest,
        };
        let index = self.evidence.loops.last().map_or(0, |last| last.index) + 1;
        let subject = Subject {
            phase_loop: &image,
            ..subject
        };
        match self.random_loop(index, LoopKind::Image, subject, true) {
            // It may have lost its area, or the budget may be spent: the given loop has to do.
            Err(
                Error::NoArea { .. } | Error::LostInRounding { .. } | Error::BudgetSpent { .. },
            ) => Ok(()),
            Err(error) if of_the_map(&error) => Ok(()),
            other => other,
        }
    }

    /// A random loop at the largest step size; at all if it shows a defect and none did before.
    fn random_loop(
        &mut self,
        index: usize,
        kind: LoopKind,
        subject: Subject<'_>,
        known: bool,
    ) -> Result<(), Error> {
        subject.evaluator.begin_loop();
        let diagnostic = self.diagnostic;
        let left = self.left();
        let with = Resolution {
            h: self.largest,
            plan: &self.plan,
            // As many as the given loop took, at least: with fewer it may not see what that one did.
            most_samples: match self.plan.is_tight() {
                true => plan::tight_samples(left)
                    .max(self.evidence.loops[0].samples)
                    .min(left),
                false => plan::share(diagnostic, self.count.budget()).min(left),
            },
            allowance: left,
        };
        let mut seen = None;
        let mut look = |after: &Ensemble| seen = Some(survey::of_samples(subject, after));
        let probe = diagnostic.resolve(subject, &with, &mut look)?;
        let samples = &mut InitialSamples::new(subject);
        let first = probe.measure(samples, self.largest, &mut look)?;
        (self.watch)(Event::Planned(1));
        let mut found = LoopEvidence::new(index, kind);
        found.rule = match probe.rule.kind() {
            RuleKind::Auto => RuleKind::Pseudospectral,
            kind => kind,
        };
        found.samples = probe.samples;
        found.winds = survey::winds(subject.phase_loop, subject.coordinates())?;
        self.evidence.loops.push(found);
        self.record(index, Sweep::StepSize, &probe, &first);
        self.moved(seen.and_then(|seen| seen.motion));
        let shows = (self.evidence.loops.last()).is_some_and(LoopEvidence::shows_defect);
        if !shows || known {
            return Ok(());
        }
        let others: Vec<f64> = (diagnostic.step_sizes.iter().copied())
            .filter(|&h| h != self.largest)
            .collect();
        (self.watch)(Event::Planned(others.len()));
        for h in others {
            if self.left() < first.evaluations {
                break;
            }
            match probe.measure(samples, h, &mut |_| {}) {
                Err(Error::BudgetSpent { .. }) => break,
                measured => self.record(index, Sweep::StepSize, &probe, &measured?),
            }
        }
        Ok(())
    }

    /// A loop on which the map failed.
    fn failed(&mut self, index: usize, kind: LoopKind, error: &Error) {
        // It may have been recorded at some step sizes before the map failed at another.
        self.evidence.loops.retain(|found| found.index != index);
        let mut found = LoopEvidence::new(index, kind);
        found.failure = Some(error.to_string());
        self.evidence.loops.push(found);
    }
}

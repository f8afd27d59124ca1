//! The loops besides the given one: random ones, and one that winds round a period.

mod kinds;
mod reach;

pub(super) use kinds::loop_of_kind;
use kinds::random_kind;

use super::{GivenLoop, Runner, if_possible};
use crate::diagnosis::Event;
use crate::diagnosis::plan;
use crate::diagnosis::resolve::Resolution;
use crate::diagnosis::resolve::initial_samples::InitialSamples;
use crate::diagnosis::resolve::probe::{Probe, StepMeasurement};
use crate::error::Error;
use crate::evidence::{
    Check, DofGroup, LoopEvidence, LoopKind, Motion, OmissionReason, StepEvidence, Sweep,
};
use crate::loops::FourierLoop;
use crate::map::{ImageLoop, LoopSize};
use crate::rules::Subject;
use crate::state::Ensemble;
use crate::survey;

/// Random loops for each group of degrees of freedom but the first.
pub(super) const LOOPS_PER_GROUP: usize = 2;

/// Random loops of an ample budget where the given loop breaks.
const LOOPS_BESIDE_BREAKS: usize = 2;

/// Loops are sure to be measured if all of them take at most one in this number of the evaluations left: the first one
/// may need more than the given one did.
const DIVISOR_OF_SURE_BUDGET: usize = 2;

/// A loop besides the given one.
pub(super) struct LoopCandidate {
    index: usize,
    kind: LoopKind,
    group: Option<usize>,
}

impl LoopCandidate {
    fn evidence(&self) -> LoopEvidence {
        LoopEvidence {
            group: self.group,
            ..LoopEvidence::new(self.index, self.kind)
        }
    }
}

impl Runner<'_> {
    /// Random loops at the largest step size, and a loop that winds round a period; the first that shows a defect
    /// at all step sizes.
    pub(super) fn random_loops(
        &mut self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
    ) -> Result<(), Error> {
        let diagnostic = self.diagnostic;
        let count = diagnostic.loops - 1;
        let mut others: Vec<LoopCandidate> = (1..=count)
            .map(|index| LoopCandidate {
                index,
                kind: random_kind(&given.size, index),
                group: None,
            })
            .collect();
        let groups = &given.size.groups;
        if count > 0 && !groups.is_empty() {
            self.evidence.groups = (groups.iter())
                .map(|group| DofGroup {
                    dofs: group.dofs.clone(),
                    action: group.action,
                })
                .collect();
            // In loops that move all, the group of the largest actions is what shows.
            let of_groups = (1..groups.len()).flat_map(|group| [group; LOOPS_PER_GROUP]);
            others.extend(of_groups.enumerate().map(|(k, group)| LoopCandidate {
                index: diagnostic.loops + 1 + k,
                kind: LoopKind::Group,
                group: Some(group),
            }));
        }
        let of_loop = given.cost.max(self.plan.first_samples);
        let sure = self.sure_loops(of_loop).min(others.len());
        self.prefetch_loops(subject, given, &others[..sure])?;
        let mut omitted = 0;
        for (k, other) in others.iter().enumerate() {
            if k >= sure && self.is_settled() {
                break;
            }
            self.reserved = sure.saturating_sub(k + 1) * of_loop;
            self.expect_from(0, subject, given.costs());
            if self.try_loop(subject, given, other)? {
                continue;
            }
            omitted += 1;
            if k >= sure {
                omitted += others.len() - k - 1;
                break;
            }
        }
        if omitted > 0 {
            self.omit(
                Check::RandomLoops,
                OmissionReason::Budget { missing: omitted },
            );
        }
        let winds = self.evidence.loops[0].winds;
        let affordable = self.left() >= given.cost.max(self.plan.first_samples);
        let periodic = self.evidence.survey.wrong_period.is_none();
        if count > 0 && periodic && !winds && !self.is_settled() && affordable {
            self.winding_loop(subject, &given.size)?;
        }
        Ok(())
    }

    /// Tells the map of the first samples of loops that are sure to be measured.
    fn prefetch_loops(
        &self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
        others: &[LoopCandidate],
    ) -> Result<(), Error> {
        let first = (self.diagnostic).first_of_loop(subject.dof(), &self.plan);
        let Some(samples) = first.filter(|_| subject.evaluator.has_prefetch()) else {
            return Ok(());
        };
        for other in others {
            if let Some(random) = self.random(subject, given, other)? {
                let subject = Subject {
                    phase_loop: &subject.evaluator.on_manifold(random),
                    ..subject
                };
                InitialSamples::new(subject).prefetch(samples, std::iter::once(self.largest));
            }
        }
        Ok(())
    }

    /// The number of further loops that are measured whatever they show, if each takes `of_loop` evaluations: those
    /// before which [`is_settled`](Self::is_settled) is false.
    fn sure_loops(&self, of_loop: usize) -> usize {
        self.needed_loops()
            .min(self.left() / DIVISOR_OF_SURE_BUDGET / of_loop)
    }

    /// The same if the budget were large enough.
    pub(super) fn needed_loops(&self) -> usize {
        let given = &self.evidence.loops[0];
        // A loop that winds does not count as evidence.
        let proves = !given.winds;
        match (proves && given.is_broken(), self.plan.is_tight()) {
            (true, true) => 0,
            (true, false) => LOOPS_BESIDE_BREAKS,
            (false, true) if proves && given.shows_defect() => 1,
            (false, _) => usize::MAX,
        }
    }

    /// The curve of such a loop, if there is one of its kind.
    fn random(
        &self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
        other: &LoopCandidate,
    ) -> Result<Option<FourierLoop>, Error> {
        let seed = self.diagnostic.seed.wrapping_add(other.index as u64);
        let coordinates = subject.coordinates();
        loop_of_kind(other.kind, other.group, &given.size, coordinates, seed)
    }

    /// A random loop; whether the budget allowed it.
    fn try_loop(
        &mut self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
        other: &LoopCandidate,
    ) -> Result<bool, Error> {
        // A loop that cannot be resolved as the given one was does not count as evidence.
        let least = if self.plan.is_tight() { given.cost } else { 0 };
        if self.left() < least.max(self.plan.first_samples) {
            return Ok(false);
        }
        let Some(random) = self.random(subject, given, other)? else {
            return Ok(true);
        };
        let subject = Subject {
            phase_loop: &subject.evaluator.on_manifold(random),
            ..subject
        };
        // The order is that of a full sweep, and a symmetric loop hides terms of lower
        // order: the given loop and one random one are worth it.
        let (given, random) = self.evidence.loops.split_at(1);
        let known = given[0].is_broken() || random.iter().any(LoopEvidence::shows_defect);
        match self.random_loop(other, subject, known) {
            Ok(()) if self.is_unresolved() => {
                self.evidence.loops.pop();
                return Ok(false);
            }
            Ok(()) => {}
            Err(Error::BudgetSpent { .. }) => return Ok(false),
            // A random loop may leave the map's domain.
            Err(error) if error.is_of_map() => self.failed(other, &error),
            // A degree of freedom that the given loop leaves at rest may be lost in rounding.
            Err(error @ (Error::NoArea { .. } | Error::LostInRounding { .. }))
                if matches!(other.kind, LoopKind::Extended | LoopKind::Group) =>
            {
                self.failed(other, &error);
            }
            Err(error) => return Err(error),
        }
        Ok(true)
    }

    /// Whether a tight budget was spent before the last loop was resolved as the given one was: it does not count as evidence.
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

    /// Whether further loops cannot change the verdict any more: the given loop breaks, or, in a tight budget, it and
    /// a random one change. (A symmetric loop hides terms of lower order: the order needs both. It may hide as well what
    /// the map does between its breaks, so that an ample budget has some random ones.)
    fn is_settled(&self) -> bool {
        let (given, random) = self.evidence.loops.split_at(1);
        if given[0].winds {
            return false;
        }
        let shown = given[0].shows_defect() && random.iter().any(LoopEvidence::shows_defect);
        match (given[0].is_broken(), self.plan.is_tight()) {
            (true, true) => true,
            (true, false) => random.len() >= LOOPS_BESIDE_BREAKS,
            (false, tight) => tight && shown,
        }
    }

    /// A random loop round the period of a position, if there is one.
    fn winding_loop(&mut self, subject: Subject<'_>, size: &LoopSize) -> Result<(), Error> {
        let (index, seed) = (
            self.diagnostic.loops,
            self.diagnostic
                .seed
                .wrapping_add(self.diagnostic.loops as u64),
        );
        let winding = LoopCandidate {
            index,
            kind: LoopKind::Winding,
            group: None,
        };
        let found = loop_of_kind(winding.kind, None, size, subject.coordinates(), seed)?;
        let Some(random) = found else {
            return Ok(());
        };
        let subject = Subject {
            phase_loop: &subject.evaluator.on_manifold(random),
            ..subject
        };
        match self.random_loop(&winding, subject, true) {
            Err(Error::NoArea { .. } | Error::LostInRounding { .. }) => Ok(()),
            // It was not asked for.
            measured => if_possible(measured.map(Some)).map(|_| ()),
        }
    }

    /// The given loop after one step, advanced by another one.
    pub(super) fn image_loop(&mut self, subject: Subject<'_>) -> Result<(), Error> {
        let image = ImageLoop {
            inner: subject.phase_loop,
            evaluator: subject.evaluator,
            h: self.largest,
        };
        let of_image = LoopCandidate {
            index: self
                .evidence
                .loops
                .iter()
                .map(|found| found.index)
                .max()
                .unwrap_or(0)
                + 1,
            kind: LoopKind::Image,
            group: None,
        };
        let subject = Subject {
            phase_loop: &image,
            ..subject
        };
        match self.random_loop(&of_image, subject, true) {
            // It may have lost its area, or the budget may be spent: the given loop has to do.
            Err(Error::NoArea { .. } | Error::LostInRounding { .. }) => Ok(()),
            measured => if_possible(measured.map(Some)).map(|_| ()),
        }
    }

    /// A loop besides the given one, with as many samples as it needs, after a step of size `h`: how that was measured, what
    /// it shows, and how the loop moves.
    pub(super) fn resolved<'s>(
        &self,
        samples: &mut InitialSamples<'s>,
        h: f64,
    ) -> Result<(Probe<'s>, StepMeasurement, Option<Motion>), Error> {
        let subject = samples.subject;
        subject.evaluator.begin_loop();
        let left = self.left();
        let with = Resolution {
            h,
            plan: &self.plan,
            // As many as the given loop took, at least: with fewer it may not see what that one did.
            most_samples: match self.plan.is_tight() {
                true => plan::tight_samples(left)
                    .max(self.evidence.loops[0].samples)
                    .min(left),
                false => plan::share(self.diagnostic, self.count.budget()).min(left),
            },
            allowance: left,
        };
        let mut seen = None;
        let mut look = |after: &Ensemble| seen = Some(survey::of_samples(subject, after));
        let probe = self.diagnostic.resolve(samples, &with, &mut look)?;
        let known = probe.measure(samples, h, &mut look)?;
        Ok((probe, known, seen.and_then(|seen| seen.motion)))
    }

    /// A random loop at the largest step size; at all if it shows a defect and none did before.
    fn random_loop(
        &mut self,
        other: &LoopCandidate,
        subject: Subject<'_>,
        known: bool,
    ) -> Result<(), Error> {
        let diagnostic = self.diagnostic;
        let samples = &mut InitialSamples::new(subject);
        let (probe, first, motion) = self.resolved(samples, self.largest)?;
        (self.watch)(Event::Planned(1));
        self.evidence.loops.push(probe.described(other.evidence())?);
        self.record(other.index, Sweep::StepSize, &probe, &first);
        self.keep_features(other.index, subject);
        self.moved(motion);
        let shows = (self.evidence.loops.last()).is_some_and(LoopEvidence::shows_defect);
        if !shows || known {
            return Ok(());
        }
        let others: Vec<f64> = (diagnostic.step_sizes.iter().copied())
            .filter(|&h| h != self.largest && self.sizes().any(|size| size == h))
            .collect();
        (self.watch)(Event::Planned(others.len()));
        if probe.keeps_samples() {
            let affordable = self.left() / first.evaluations.max(1);
            samples.prefetch(probe.samples, others.iter().copied().take(affordable));
        }
        for h in others {
            if self.left() < first.evaluations {
                break;
            }
            match probe.measure(samples, h, &mut |_| {}) {
                Err(Error::BudgetSpent { .. }) => break,
                measured => self.record(other.index, Sweep::StepSize, &probe, &measured?),
            }
        }
        Ok(())
    }

    /// A loop on which the map failed.
    fn failed(&mut self, other: &LoopCandidate, error: &Error) {
        // It may have been recorded at some step sizes before the map failed at another.
        (self.evidence.loops).retain(|found| found.index != other.index);
        let mut found = other.evidence();
        found.failure = Some(error.to_string());
        self.evidence.loops.push(found);
    }
}

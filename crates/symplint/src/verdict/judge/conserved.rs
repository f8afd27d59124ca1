//! No defect: how large it may be.

use super::{Case, Decision, change};
use crate::evidence::{Check, LoopEvidence, Motion, Omission, OmissionReason, StepEvidence};
use crate::rules::RuleKind;
use crate::verdict::VerdictKind;
use crate::verdict::advice::Advice;
use crate::verdict::findings::{BoundFinding, BreakFinding, ChangeFinding, Finding, MapFinding};
use crate::verdict::thresholds::STATES_PER_ERROR;

impl Case<'_> {
    pub(super) fn symplectic(&self) -> Decision {
        let (given, others) = self.loops.split_at(1);
        // A random loop that winds says whether the map is exact, no more.
        let random = (others.iter()).filter(|found| !found.winds && found.is_bounded());
        let bound = self.bound_of_loops();
        let because = Finding::Bounds(BoundFinding::Conserved {
            bound,
            range: self.range(&given[0]),
            failed: self.failed_steps(),
            random: random.count(),
            given: given[0].is_bounded(),
            radii: self.radii(),
        });
        let mut decision = Decision::new(VerdictKind::Symplectic, because);
        decision.digits = Some((-bound.log10() * 10.0).floor() / 10.0);
        decision.findings = self.bounds();
        decision.advice.extend(match self.is_sampled() {
            true => Some(Advice::MoreLoopsOfFile),
            false => (!self.has_random_loops()).then_some(Advice::MoreLoops),
        });
        let moves_nothing = |(motion, _): (Motion, _)| motion.deformation == 0.0 && !motion.moves;
        if self.strongest_motion().is_some_and(moves_nothing) {
            decision.advice.insert(0, Advice::MovesNothing);
        }
        decision
    }

    /// At how many step sizes the map failed on the given loop.
    pub(super) fn failed_steps(&self) -> usize {
        let failed = |of: &&Omission| {
            of.check == Check::GivenLoop && matches!(of.why, OmissionReason::Failed { .. })
        };
        self.evidence.omissions.iter().filter(failed).count()
    }

    /// The largest radii of the loops that are conserved, if the verdict is about loops of this size.
    fn radii(&self) -> Option<[f64; 2]> {
        let larger = (self.evidence.reach.iter())
            .filter(|reach| reach.step.step_size.is_none() && !reach.shows_defect());
        let factor = larger.map(|reach| reach.factor).fold(1.0, f64::max);
        Some(self.evidence.radii?.map(|radius| factor * radius))
    }

    /// What no defect exceeds, of loops that bound one: the given loop, and others that do not wind.
    pub(super) fn bound_of_loops(&self) -> f64 {
        let of_jacobian = self.bounds_by_jacobian_alone();
        of_jacobian.fold(LoopEvidence::bound_of(self.loops), f64::max)
    }

    /// The states of the loops that bound the defect. All step sizes advance the same states of a loop.
    fn states_that_bound(&self) -> usize {
        let counts = |found: &&LoopEvidence| !found.winds && found.is_bounded();
        let loops = self.loops.iter().filter(counts);
        loops.map(|found| found.samples).sum()
    }

    /// How large the defects may be: of every sampled loop; else of the given loop and of the worst random one.
    pub(super) fn bounds(&self) -> Vec<Finding> {
        let mut findings = match self.is_sampled() {
            true => self.bounds_of_samples(),
            false => self.bounds_of_loops(),
        };
        findings.extend(self.groups());
        let samples = self.loops.first().map_or(0, |given| given.samples);
        let one_in = self.states_that_bound() / STATES_PER_ERROR;
        findings.push(Finding::Bounds(BoundFinding::Resolution {
            samples,
            one_in: (one_in > 1).then_some(one_in),
        }));
        let motion = self.strongest_motion();
        findings.extend(motion.map(|(motion, _)| {
            Finding::Map(MapFinding::Moves {
                motion,
                has_step_size: self.has_step_size(),
            })
        }));
        findings.extend(self.evidence.reach.map(|reach| {
            Finding::Map(MapFinding::Beyond {
                reach: Box::new(reach),
                more: motion.is_none_or(|(motion, _)| reach.is_further(motion)),
            })
        }));
        findings
    }

    fn bounds_of_samples(&self) -> Vec<Finding> {
        (self.steps())
            .map(|(found, step)| self.bound(found, step))
            .collect()
    }

    fn bound(&self, found: &LoopEvidence, step: &StepEvidence) -> Finding {
        let finite = |value: f64| Some(value).filter(|value| value.is_finite());
        Finding::Bounds(BoundFinding::Bound {
            loop_index: found.index,
            samples: (found.rule != RuleKind::Piecewise).then_some(found.samples),
            bound: finite(step.bound()),
            measured: step.defect.magnitude(),
            uncertainty: finite(step.defect.uncertainty()),
            step: self.name(found, step),
        })
    }

    fn bounds_of_loops(&self) -> Vec<Finding> {
        let worst_step = |found: &LoopEvidence| {
            let worst = (found.steps.iter()).max_by(|a, b| a.bound().total_cmp(&b.bound()))?;
            Some(self.bound(found, worst))
        };
        let (given, random) = self.loops.split_at(1);
        let bound = |found: &LoopEvidence| {
            let bounds = found.steps.iter().map(StepEvidence::bound);
            bounds.fold(0.0, f64::max)
        };
        // Loops that bound the defect, if there are any: the verdict rests on them.
        let counts = |found: &&LoopEvidence| !found.winds && found.is_bounded();
        let any = random.iter().any(|found| counts(&found));
        let worst = (random.iter())
            .filter(|found| !found.steps.is_empty() && (!any || counts(found)))
            .max_by(|a, b| bound(a).total_cmp(&bound(b)));
        let mut findings: Vec<Finding> =
            (given.iter().chain(worst)).filter_map(worst_step).collect();
        let failed = (self.loops.iter()).find_map(|found| {
            Some(Finding::Bounds(BoundFinding::LoopFailed {
                loop_index: found.index,
                reason: found.failure.clone()?,
            }))
        });
        findings.extend(failed);
        // A break of a loop that winds does not count as evidence: it may be its period.
        let cut = self.jumps().find(|(found, ..)| found.winds);
        findings.extend(cut.map(|(found, step, jump)| {
            Finding::Breaks(BreakFinding::Jump {
                loop_index: found.index,
                step: self.name(found, step),
                breaks: step.closing.map(|closing| closing.breaks),
                at_least: step.flickering > 0,
                jump,
                sampled: false,
            })
        }));
        let flux = (self.steps())
            .find(|(found, step)| found.winds && step.jump.is_none() && step.is_significant());
        findings.extend(flux.map(|(found, step)| {
            Finding::Changes(ChangeFinding::NotExact {
                loop_index: found.index,
                wound: found.wound.clone(),
                change: change(&step.defect),
                step: self.name(found, step),
            })
        }));
        let conserved =
            |found: &&LoopEvidence| !found.steps.iter().any(StepEvidence::is_unexplained);
        let exact = (random.iter())
            .filter(|found| found.winds && found.is_bounded())
            .find(conserved);
        findings.extend(exact.map(|found| {
            Finding::Changes(ChangeFinding::Exact {
                loop_index: found.index,
                bound: bound(found),
                wound: found.wound.clone(),
            })
        }));
        findings
    }
}

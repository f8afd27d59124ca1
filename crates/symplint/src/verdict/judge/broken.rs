//! Loops that are not closed before the step, and loops that a step breaks.

use super::{Case, Decision, change, moves_rest};
use crate::breaks::Break;
use crate::evidence::{LoopEvidence, MAX_BOUND_ON_DEFECT, StepEvidence};
use crate::signal::SIGNIFICANT;
use crate::verdict::VerdictKind;
use crate::verdict::advice::Advice;
use crate::verdict::findings::{BreakFinding, ChangeFinding, Finding, SampleFinding, Step};
use crate::verdict::order::Fit;
use crate::verdict::thresholds::{MIN_SAMPLED_JUMP, MIN_SHUFFLED_RATIO, MIN_TREND};

/// The worst of the loops whose breaks are closed.
struct WorstClosure {
    finding: Finding,
    conserved: Option<bool>,
}

impl Case<'_> {
    /// The loop before the step is not closed, or a loop is cut where a periodic box ends.
    pub(super) fn no_closed_loop(&self) -> Option<Decision> {
        let given = self.loops.first()?;
        let wrapped = |dof, period, step| {
            let because = Finding::Samples(SampleFinding::Wrapped { dof, period, step });
            let mut decision = Decision::new(VerdictKind::Undecided, because);
            decision.findings = self.bounds();
            decision.advice.push(Advice::StatePeriod);
            decision
        };
        if let Some(wrap) = given.wrap_before {
            return Some(wrapped(wrap.dof, wrap.period, None));
        }
        if let Some(ratio) = given.shuffled.filter(|&ratio| ratio > MIN_SHUFFLED_RATIO) {
            let mut decision = Decision::new(
                VerdictKind::Undecided,
                Finding::Samples(SampleFinding::Shuffled { ratio }),
            );
            decision.findings = self.bounds();
            decision.advice.push(Advice::OrderOfSamples);
            return Some(decision);
        }
        if let Some(jump) = given.broken_before {
            let mut decision = Decision::new(
                VerdictKind::Undecided,
                Finding::Samples(SampleFinding::NotClosed { jump }),
            );
            decision.findings = self.bounds();
            decision.advice = vec![
                Advice::OrderOfSamples,
                Advice::PeriodIfPeriodic,
                Advice::MoreSamplesOfFile,
            ];
            return Some(decision);
        }
        self.steps().find_map(|(found, step)| {
            let wrap = step.wrap?;
            Some(wrapped(wrap.dof, wrap.period, Some(self.name(found, step))))
        })
    }

    pub(super) fn broken(&self) -> Option<Decision> {
        match self.is_sampled() {
            true => self.broken_samples(),
            false => self.broken_by_map(),
        }
    }

    /// Every break that a step of a map makes, with its loop and step.
    pub(super) fn jumps(&self) -> impl Iterator<Item = (&LoopEvidence, &StepEvidence, Break)> {
        self.steps()
            .filter_map(|(found, step)| Some((found, step, step.jump?)))
    }

    /// A loop that winds may break because its period is not one of the map: it does not count.
    fn broken_by_map(&self) -> Option<Decision> {
        let (found, _, jump) = self.jumps().find(|(found, ..)| !found.winds)?;
        // A small break must not hide a large change.
        if self.changes_beside_breaks() {
            return None;
        }
        let closed = self.closed();
        let conserved = closed.as_ref().and_then(|closed| closed.conserved);
        let because = Finding::Breaks(BreakFinding::Discontinuous { jump, conserved });
        let mut decision = Decision::new(VerdictKind::BrokenLoops, because);
        decision.conserved_once_closed = conserved;
        let [first, count] = self.findings_on_breaks()?;
        decision.findings.push(first);
        decision.findings.extend(moves_rest(found));
        decision.findings.push(count);
        let fit = self.fits.iter().find(|fit| fit.loop_index == 0);
        decision.order = fit.filter(|fit| fit.slope > MIN_TREND).and_then(Fit::whole);
        decision.findings.extend(fit.map(|fit| {
            Finding::Changes(ChangeFinding::Law {
                fit: fit.clone(),
                between_breaks: true,
            })
        }));
        decision
            .findings
            .extend(closed.map(|closed| closed.finding));
        decision.advice = vec![
            Advice::SmootherForce,
            Advice::PeriodIfPeriodic,
            Advice::TightenSolver,
        ];
        Some(decision)
    }

    /// The first broken loop with its jump, and the number of broken loops.
    pub(super) fn findings_on_breaks(&self) -> Option<[Finding; 2]> {
        let (found, step, jump) = self.jumps().find(|(found, ..)| !found.winds)?;
        let first = Finding::Breaks(BreakFinding::Jump {
            loop_index: found.index,
            step: self.name(found, step),
            breaks: step.closing.map(|closing| closing.breaks),
            at_least: step.flickering > 0,
            jump,
            sampled: false,
        });
        let count = Finding::Breaks(BreakFinding::BrokenCount {
            broken: self.jumps().count(),
            of: self.steps().count(),
        });
        Some([first, count])
    }

    /// Whether the loops whose breaks are closed conserve their integrals; `None` where that is not known.
    fn closed(&self) -> Option<WorstClosure> {
        let closed = self.steps().filter_map(|(found, step)| {
            let closing = step.closing.filter(|_| !found.winds)?;
            Some((found, step, closing))
        });
        // A change that proves something before a larger one that does not.
        let (found, step, closing) = closed.max_by(|(.., a), (.., b)| {
            let by_size = || a.closed.magnitude().total_cmp(&b.closed.magnitude());
            a.is_changed().cmp(&b.is_changed()).then_with(by_size)
        })?;
        let (loop_index, name) = (found.index, self.name(found, step));
        let defect = closing.closed;
        if defect.magnitude() > SIGNIFICANT * defect.uncertainty() {
            return Some(WorstClosure {
                finding: Finding::Breaks(BreakFinding::ClosedChanges {
                    change: change(&defect),
                    straight: closing.straight,
                    bend: (!closing.is_changed()).then_some(closing.bend),
                    loop_index,
                    step: name,
                }),
                conserved: closing.is_changed().then_some(false),
            });
        }
        let bound = defect.magnitude() + defect.uncertainty();
        (bound <= MAX_BOUND_ON_DEFECT).then_some(WorstClosure {
            finding: Finding::Breaks(BreakFinding::ClosedConserved {
                bound,
                straight: closing.straight,
                loop_index,
                step: name,
            }),
            conserved: Some(true),
        })
    }

    /// Loops that jump between neighbouring samples by more than single precision would.
    fn broken_samples(&self) -> Option<Decision> {
        let jumping = || {
            self.steps().filter_map(|(found, step)| {
                let jumps = step.jumping.filter(|j| j.largest > MIN_SAMPLED_JUMP)?;
                Some((found, step, jumps))
            })
        };
        let (found, step, jumps) = jumping().max_by_key(|(_, _, jumps)| jumps.confirmed)?;
        let name = self.name(found, step);
        let samples = found.samples;
        let because = Finding::Samples(SampleFinding::JumpingSamples {
            loops: jumping().count(),
            of: self.steps().count(),
            jumps: jumps.confirmed,
            step: name,
            samples,
        });
        let mut decision = Decision::new(VerdictKind::BrokenLoops, because);
        decision.findings.extend(step.jump.map(|jump| {
            Finding::Breaks(BreakFinding::Jump {
                loop_index: found.index,
                step: name,
                breaks: Some(jumps.confirmed),
                at_least: true,
                jump,
                sampled: true,
            })
        }));
        decision
            .findings
            .extend(jumping().filter_map(|(found, step, _)| self.sampled_breaks(found, step)));
        decision.findings.extend(self.fits.first().map(|fit| {
            Finding::Changes(ChangeFinding::Law {
                fit: fit.clone(),
                between_breaks: true,
            })
        }));
        decision
            .findings
            .push(Finding::Samples(SampleFinding::SamplesAreNoProof {
                samples,
            }));
        decision.advice = vec![
            Advice::OrderOfSamples,
            Advice::PeriodIfPeriodic,
            Advice::MoreSamplesOfFile,
            Advice::SmootherForce,
            Advice::TightenSolver,
        ];
        Some(decision)
    }

    fn sampled_breaks(&self, found: &LoopEvidence, step: &StepEvidence) -> Option<Finding> {
        let (jumps, closing) = (step.jumping?, step.closing?);
        let name: Step = self.name(found, step);
        Some(Finding::Samples(SampleFinding::SampledBreaks {
            step: name,
            cells: jumps.cells,
            confirmed: jumps.confirmed,
            open: change(&step.defect),
            closed: change(&closing.closed),
        }))
    }
}

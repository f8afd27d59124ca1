//! From the evidence to the verdict.

mod broken;
mod conserved;
mod groups;
mod undecided;

use super::advice::Advice;
use super::cause::{Cause, Clues, JumpLaw};
use super::findings::{
    BoundFinding, Change, ChangeFinding, DomainFinding, Finding, LocalisationFinding, MapFinding,
    RunFinding, SampleFinding, Step, StepRange,
};
use super::jacobian::{JacobianVerdict, compare_jacobian};
use super::order::{Fit, clear, fit_order, known_data, leaves};
use super::properties::{Property, properties};
use super::slope::{constant_defect, slope_of, smallest_steps_slope};
use super::thresholds::{MAX_ORDER, MAX_UNCONFIRMED_DEFECT, MIN_TREND};
use super::{Verdict, VerdictKind, long_time};
use crate::evidence::{
    Check, Evidence, LoopEvidence, LoopKind, MIN_STEP_SIZES_OF_LAW, Motion, Omission,
    OmissionReason, Origin, Scatter, StepEvidence,
};
use crate::jacobian::JacobianDecay;
use crate::rules::Defect;
use crate::signal::{CERTAIN, SIGNIFICANT};

/// Computes the verdict. Pure: the same evidence gives the same verdict, from any source.
///
/// A symplectic map conserves the loop integral of every closed loop exactly, at every step size. So one
/// significant defect proves that a map is not symplectic, and so does one break; the absence of both bounds the
/// defect for the loops and steps that were tried.
pub fn judge(evidence: &Evidence) -> Verdict {
    // Off the manifold that a map projects onto it conserves nothing, and need not; nor off a leaf of its form.
    let survey = &evidence.survey;
    let counted = match survey.singular.is_some() || survey.degenerate_form.is_some() {
        true => &evidence.loops[..evidence.loops.len().min(1)],
        false => &evidence.loops,
    };
    let fits: Vec<Fit> = counted.iter().filter_map(fit_order).collect();
    let case = Case {
        evidence,
        loops: counted,
        fits: &fits,
    };
    let mut decision = case.decide();
    let properties = properties(evidence, decision.kind);
    let cause = case.cause(&decision, &properties);
    decision.advise_on_cause(cause.as_ref(), evidence, &properties);
    if evidence.survey.wrong_period.is_some() {
        decision.advice.push(Advice::CorrectPeriod);
    }
    if evidence.survey.is_rounded() && decision.kind != VerdictKind::NotSymplectic {
        decision.advise_on_digits();
    }
    let mut findings = vec![decision.because];
    findings.append(&mut decision.findings);
    let further = case.further_findings(decision.kind, decision.digits);
    // A cause that blocks show states them.
    let is_new = |finding: &Finding| {
        let blocks = matches!(
            finding,
            Finding::Localisation(LocalisationFinding::Blocks { .. })
        );
        !blocks || !cause.as_ref().is_some_and(Cause::is_of_blocks)
    };
    findings.extend(further.into_iter().filter(is_new));
    Verdict {
        kind: decision.kind,
        digits: decision.digits,
        order: decision.order,
        conserved_once_closed: decision.conserved_once_closed,
        findings,
        cause,
        advice: decision.advice,
        fits,
        properties,
    }
}

/// The decision on a case, before the findings that every verdict has.
struct Decision {
    kind: VerdictKind,
    digits: Option<f64>,
    order: Option<f64>,
    conserved_once_closed: Option<bool>,
    because: Finding,
    findings: Vec<Finding>,
    advice: Vec<Advice>,
}

impl Decision {
    fn new(kind: VerdictKind, because: Finding) -> Self {
        Decision {
            kind,
            digits: None,
            order: None,
            conserved_once_closed: None,
            because,
            findings: Vec::new(),
            advice: Vec::new(),
        }
    }

    /// The remedy for the likeliest cause comes first; if no cause is known, those that defects of this order have.
    fn advise_on_cause(
        &mut self,
        cause: Option<&Cause>,
        evidence: &Evidence,
        properties: &[Property],
    ) {
        let Some(cause) = cause else {
            let names_none = self.advice.iter().all(Advice::is_of_order);
            if self.kind == VerdictKind::NotSymplectic && names_none {
                let order = self.order.or_else(|| slope_of(evidence));
                self.advice.insert(0, Advice::on_order(order, properties));
            }
            return;
        };
        self.advice.retain(|advice| !advice.is_general());
        if self
            .advice
            .iter()
            .all(|advice| advice.to_string() != cause.remedy)
        {
            let text = cause.remedy.clone();
            self.advice.insert(0, Advice::Remedy { text });
        }
    }

    /// Advice for a map whose states have few digits.
    fn advise_on_digits(&mut self) {
        if !self.advice.contains(&Advice::MoreDigits) {
            // If rounding is what hides an answer, digits come first.
            let of_rounding = matches!(
                self.because,
                Finding::Bounds(BoundFinding::WeakBound { .. })
                    | Finding::Changes(ChangeFinding::Unexplained { .. })
                    | Finding::Samples(SampleFinding::SmallJumps { .. })
            );
            let of_motion = matches!(
                self.advice[..],
                [
                    Advice::SmallerSteps { .. } | Advice::BalancedRadii { .. },
                    ..
                ]
            );
            let place = match of_rounding && !of_motion {
                true => 0,
                false => self.advice.len(),
            };
            self.advice.insert(place, Advice::MoreDigits);
        }
        if self.kind == VerdictKind::Symplectic {
            self.advice.push(Advice::LargerLoopOrMoreSamples);
        }
    }
}

struct Case<'a> {
    evidence: &'a Evidence,
    /// The loops that lie in the domain of the map.
    loops: &'a [LoopEvidence],
    fits: &'a [Fit],
}

impl<'a> Case<'a> {
    /// The reasons of verdicts, the most important one first: the first that applies decides.
    const PRIORITY: [fn(&Self) -> Option<Decision>; 21] = [
        Self::nothing_measured,
        Self::no_closed_loop,
        Self::random_numbers,
        // Loops outside the domain of the map do not count as evidence.
        Self::beside_leaf,
        Self::beside_manifold,
        Self::broken,
        Self::not_contracted,
        Self::outside_its_domain,
        Self::not_symplectic,
        Self::projects,
        Self::leaves_manifold,
        // Nothing shows a defect. What may hide one:
        Self::misses_grid,
        Self::hardly_moves,
        Self::undecided_samples,
        Self::unexplained,
        Self::all_wind,
        Self::weak_bound,
        Self::no_random_loop,
        Self::unknown_group,
        Self::slow_group,
        Self::refuted,
    ];

    fn decide(&self) -> Decision {
        let mut reasons = Self::PRIORITY.iter();
        let decision = reasons.find_map(|reason| reason(self));
        decision.unwrap_or_else(|| self.symplectic())
    }

    /// The likeliest cause of a failure.
    fn cause(&self, decision: &Decision, properties: &[Property]) -> Option<Cause> {
        let clues = Clues {
            evidence: self.evidence,
            properties,
            findings: &decision.findings,
            advice: &decision.advice,
            order: decision.order,
            fits: self.fits,
            law: JumpLaw::of(self.evidence),
        };
        match decision.kind {
            VerdictKind::BrokenLoops => clues.of_breaks(),
            VerdictKind::NotSymplectic => clues.of_changes(),
            VerdictKind::Symplectic | VerdictKind::Undecided => None,
        }
    }

    fn nothing_measured(&self) -> Option<Decision> {
        let is_empty =
            self.steps().next().is_none() && self.loops.iter().all(|found| found.failure.is_none());
        is_empty.then(|| {
            let mut decision = Decision::new(
                VerdictKind::Undecided,
                Finding::Run(RunFinding::NothingMeasured),
            );
            decision.advice.push(Advice::MeasureLoop);
            decision
        })
    }

    fn is_sampled(&self) -> bool {
        self.evidence.origin == Origin::Samples
    }

    /// Whether the map has a step size, as far as is known.
    fn has_step_size(&self) -> bool {
        self.is_sampled() || self.steps().all(|(_, step)| step.step_size.is_some())
    }

    /// Every step with its loop.
    fn steps(&self) -> impl Iterator<Item = (&'a LoopEvidence, &'a StepEvidence)> + use<'a> {
        (self.loops.iter()).flat_map(|found| found.steps.iter().map(move |step| (found, step)))
    }

    /// The step with the largest defect among those that `wanted` picks. Loops that wind do not count as evidence: a
    /// symplectic map need not be exact.
    fn worst(
        &self,
        wanted: impl Fn(&StepEvidence) -> bool,
    ) -> Option<(&'a LoopEvidence, &'a StepEvidence)> {
        (self.steps())
            .filter(|(found, step)| !found.winds && wanted(step))
            .max_by(|a, b| a.1.defect.magnitude().total_cmp(&b.1.defect.magnitude()))
    }

    /// The range of the step sizes of a loop.
    fn range(&self, found: &LoopEvidence) -> StepRange {
        // The result of a step that ignores h holds for no step size.
        if self.evidence.survey.ignores_step_size {
            return StepRange::Map;
        }
        let sizes = || found.steps.iter().filter_map(|step| step.step_size);
        match (sizes().reduce(f64::min), sizes().reduce(f64::max)) {
            (Some(low), Some(high)) if low == high => StepRange::One(low),
            (Some(low), Some(high)) => StepRange::Between(low, high),
            _ if self.is_sampled() => StepRange::Unknown,
            _ => StepRange::Map,
        }
    }

    /// How the findings name a step of a loop.
    fn name(&self, found: &LoopEvidence, step: &StepEvidence) -> Step {
        match step.step_size {
            Some(h) => Step::Size(h),
            None if !self.is_sampled() => Step::Map,
            None if found.steps.len() == 1 => Step::Only,
            None => {
                let mut steps = found.steps.iter();
                let index = steps.position(|other| std::ptr::eq(other, step));
                Step::Number(index.unwrap_or(0) + 1)
            }
        }
    }

    /// The largest step of the given loop.
    fn largest_step(&self) -> Option<(&'a LoopEvidence, &'a StepEvidence)> {
        let given = self.loops.first()?;
        let size = |step: &StepEvidence| step.step_size.map_or(0.0, f64::abs);
        let largest = (given.steps.iter()).reduce(|a, b| if size(b) > size(a) { b } else { a })?;
        Some((given, largest))
    }

    /// The law of the lowest order: a symmetric loop can hide terms of lower order. `None` if the defects of another loop
    /// fall more slowly, by their own law or at the smallest steps, or are of no order and leave this one.
    fn law_of_loops(&self) -> Option<&'a Fit> {
        let contractible = || self.loops.iter().filter(|found| !found.winds);
        let of_loop =
            |found: &LoopEvidence| (self.fits.iter()).find(|fit| fit.loop_index == found.index);
        let lowest = contractible()
            .filter_map(of_loop)
            .filter(|fit| fit.slope > MIN_TREND)
            .min_by(|a, b| a.slope.total_cmp(&b.slope))?;
        let contradicts = |found: &LoopEvidence| {
            let fit = of_loop(found);
            let slope = fit.map(|fit| fit.slope);
            let falls_slower = (slope.or_else(|| smallest_steps_slope(found)))
                .is_some_and(|slope| slope < lowest.slope - MIN_TREND);
            let has_law = fit.is_some_and(|fit| fit.constant.is_some() || fit.whole().is_some());
            let is_other = found.index != lowest.loop_index;
            falls_slower || is_other && !has_law && leaves(found, lowest.slope.round())
        };
        (!contractible().any(contradicts)).then_some(lowest)
    }

    /// The slope of the defect of the Jacobian between two step sizes, if it contradicts a law of loop integrals; 0 if the
    /// Jacobian has no defect and the loops have a large one.
    fn contradicting_slope(&self, fit: &Fit) -> Option<f64> {
        let is_hidden = || {
            let worst = self.worst(StepEvidence::is_significant);
            let defect = worst.map_or(0.0, |(_, step)| step.defect.magnitude());
            self.jacobian_bound()
                .is_some_and(|bound| defect > SIGNIFICANT * bound)
        };
        let Some(JacobianDecay {
            step_sizes: [large, small],
            defects: [before, after],
        }) = self.evidence.jacobian_decay
        else {
            return is_hidden().then_some(0.0);
        };
        let range = (large / small).abs().ln();
        let slope = |defect: f64| (before.magnitude() / defect.max(0.0)).ln() / range;
        let slope_of_loop = |at: &dyn Fn(f64) -> Option<f64>| -> Option<f64> {
            Some((at(large)? / at(small)?).abs().ln() / range)
        };
        // Both the law and the defects themselves: the largest need not follow the law of the smallest ones.
        let of_law = slope_of_loop(&|h| fit.at(self.loops, h))?;
        let of_loop = self.loops.iter().find(|of| of.index == fit.loop_index)?;
        let measured = slope_of_loop(&|h| {
            let step = of_loop
                .steps
                .iter()
                .find(|step| step.step_size == Some(h))?;
            Some(step.defect.signed)
        });
        // Loops can hide lower orders than the Jacobian shows; its one point can hide the order of the loops, not the next one.
        let lowest = slope(after.magnitude() + after.uncertainty) - 1.0 - MIN_TREND;
        let highest = slope(after.magnitude() - after.uncertainty) + MIN_TREND;
        let agrees = |of_loop: f64| (lowest..=highest).contains(&of_loop);
        let agree = agrees(of_law) || measured.is_some_and(agrees);
        (!agree).then(|| slope(after.magnitude()))
    }

    /// The largest change of a loop integral that shows that a map is not symplectic. If loops are broken, only changes count
    /// that the jumps are too small to cause.
    fn largest_change(&self) -> Option<(&'a LoopEvidence, &'a StepEvidence)> {
        if self.is_sampled() || !self.steps().any(|(_, step)| step.jump.is_some()) {
            return self.worst(StepEvidence::is_significant);
        }
        // Evidence that does not say it has 0.
        let known = |step: &StepEvidence| match step.reach_of_jumps {
            0.0 => f64::INFINITY,
            reach => reach,
        };
        let broken = self.steps().filter(|(_, step)| step.jump.is_some());
        let reach = broken.map(|(_, step)| known(step)).fold(0.0, f64::max);
        let changes = |step: &&StepEvidence| {
            let closed = step.closing.map_or(step.defect, |closing| closing.closed);
            let least = |of: Defect| CERTAIN * (of.uncertainty() + reach);
            !step.misses_the_grid()
                && step.defect.magnitude() > least(step.defect)
                && closed.magnitude() > least(closed)
        };
        (self.steps())
            .filter(|(found, step)| !found.winds && changes(step))
            .max_by(|a, b| a.1.defect.magnitude().total_cmp(&b.1.defect.magnitude()))
    }

    /// Whether loops are broken and change by much more than their jumps explain.
    fn changes_beside_breaks(&self) -> bool {
        let is_broken = self.steps().any(|(_, step)| step.jump.is_some());
        is_broken && !self.is_sampled() && self.largest_change().is_some()
    }

    fn not_symplectic(&self) -> Option<Decision> {
        let (found, step) = self.largest_change()?;
        let defect = step.defect.magnitude();
        let is_broken = self.changes_beside_breaks();
        let law = self.law_of_loops().filter(|_| !is_broken);
        let other_slope = law.and_then(|law| self.contradicting_slope(law));
        let trend = law.filter(|_| other_slope.is_none());
        if defect < MAX_UNCONFIRMED_DEFECT && law.is_none() && !self.is_confirmed() {
            return None;
        }
        let name = self.name(found, step);
        let mut decision = Decision::new(
            VerdictKind::NotSymplectic,
            Finding::Changes(ChangeFinding::Changes {
                defect,
                step: name,
                law: trend.cloned(),
            }),
        );
        decision.order = trend.and_then(Fit::whole);
        decision
            .findings
            .push(Finding::Changes(ChangeFinding::Significant {
                change: change(&step.defect),
                loop_index: found.index,
                step: name,
            }));
        let threshold = self.fails_to_converge();
        decision
            .findings
            .extend(threshold.iter().map(|(finding, _)| finding.clone()));
        decision.findings.extend(moves_rest(found));
        // The law of the stated order comes first.
        let mut fits: Vec<&Fit> = self.fits.iter().collect();
        fits.sort_by_key(|fit| trend != Some(*fit));
        decision.findings.extend(fits.into_iter().map(|fit| {
            Finding::Changes(ChangeFinding::Law {
                fit: fit.clone(),
                between_breaks: is_broken,
            })
        }));
        let singular = self.evidence.survey.singular;
        if let Some(rank) = singular.and_then(|singular| singular.degenerate) {
            decision
                .findings
                .push(Finding::Domain(DomainFinding::LosesRank { rank }));
            decision.advice.push(Advice::LoopOnManifold);
            return Some(decision);
        }
        if let (Some(law), Some(by_jacobian), Some(decay)) =
            (law, other_slope, self.evidence.jacobian_decay)
        {
            decision
                .findings
                .push(Finding::Changes(ChangeFinding::OrdersDiffer {
                    by_jacobian,
                    by_loops: law.clone(),
                    step_sizes: decay.step_sizes,
                }));
        }
        if is_broken {
            decision
                .findings
                .extend(self.findings_on_breaks().into_iter().flatten());
            decision.advice.push(Advice::TightenSolver);
        } else if let Some((_, converges)) = threshold {
            decision.advice.push(Advice::LetStepConverge { converges });
        } else {
            decision.advice.extend(self.advice_on_order(law.is_some()));
        }
        Some(decision)
    }

    /// A defect at the larger step sizes that is gone at the next smaller one, faster than any order makes it fall, and that
    /// smaller step size. Every loop with several step sizes has to show it.
    fn fails_to_converge(&self) -> Option<(Finding, f64)> {
        let sizes = |step: &StepEvidence| step.step_size.map_or(0.0, f64::abs);
        let significant = |step: &&StepEvidence| step.is_significant();
        let swept = || {
            self.loops
                .iter()
                .filter(|found| !found.winds && found.steps.len() > 1)
        };
        let steps = || swept().flat_map(|found| &found.steps);
        let last = steps()
            .filter(significant)
            .min_by(|a, b| sizes(a).total_cmp(&sizes(b)))?;
        let (h, defect) = (sizes(last), last.defect.magnitude());
        let below = || steps().filter(|step| sizes(step) < h);
        let next = below().max_by(|a, b| sizes(a).total_cmp(&sizes(b)))?;
        let gone = |step: &StepEvidence| step.bound() < defect * (sizes(step) / h).powf(MAX_ORDER);
        let bound = below().map(StepEvidence::bound).fold(0.0, f64::max);
        let finding = Finding::Changes(ChangeFinding::FailsToConverge {
            defect,
            step: Step::Size(last.step_size?),
            smaller: Step::Size(next.step_size?),
            bound,
        });
        let of_next = |step: &&StepEvidence| sizes(step) == sizes(next);
        (below().filter(of_next).all(gone)).then_some((finding, next.step_size?))
    }

    /// Whether a small defect without a law in h is confirmed: significant at two step sizes of one loop, or at
    /// one by far. Noise of the map's states is part of the uncertainty, as the spectrum shows it.
    fn is_confirmed(&self) -> bool {
        (self.loops.iter().filter(|found| !found.winds)).any(|found| {
            let significant = || found.steps.iter().filter(|step| step.is_significant());
            let far =
                |step: &StepEvidence| step.defect.magnitude() > CERTAIN * step.defect.uncertainty();
            significant().count() >= 2 || significant().any(far)
        })
    }

    /// The step draws random numbers: what it does to a loop differs from run to run.
    fn random_numbers(&self) -> Option<Decision> {
        let scatter = self.evidence.survey.scatter.filter(Scatter::is_random)?;
        let mut decision = Decision::new(
            VerdictKind::Undecided,
            Finding::Map(MapFinding::Scatter(scatter)),
        );
        decision.advice.push(Advice::SameRandomNumbers);
        Some(decision)
    }

    /// What would show the order of a defect, of all loops that were swept over step sizes.
    fn advice_on_order(&self, has_law: bool) -> Option<Advice> {
        if has_law || self.evidence.survey.ignores_step_size {
            return None;
        }
        if self.steps().any(|(_, step)| step.step_size.is_none()) {
            return self.is_sampled().then_some(Advice::StateStepSizes);
        }
        // More step sizes show no other order.
        if constant_defect(self.loops, self.fits, self.evidence.jacobian_decay).is_some() {
            return None;
        }
        let given = self.loops.first()?.steps.len();
        let spent = self.evidence.missing(Check::GivenLoop);
        let asked = given + spent + self.failed_steps();
        if asked < MIN_STEP_SIZES_OF_LAW + 1 {
            return Some(Advice::MoreStepSizes { given: asked });
        }
        if spent > 0 {
            // Half of what a larger budget adds is kept for random loops.
            let of_each = self.evidence.evaluations.of(Check::GivenLoop) / given.max(1);
            let wanted = 2 * spent * of_each;
            return Some(Advice::MoreEvaluations { wanted });
        }
        let swept = || self.loops.iter().filter(|found| !found.winds);
        let significant = |found: &LoopEvidence| {
            let steps = found.steps.iter().filter(|step| step.is_significant());
            steps.count()
        };
        let drowned = swept().map(significant).max()? < MIN_STEP_SIZES_OF_LAW;
        // Smaller steps help only if the defects at the smallest ones are still above their uncertainty.
        let shrinks = |found: &LoopEvidence| {
            let known = known_data(found);
            known.len() >= MIN_STEP_SIZES_OF_LAW && clear(&known).first() == known.first()
        };
        if !drowned && !swept().any(shrinks) {
            return None;
        }
        Some(Advice::NoOrder { given, drowned })
    }

    /// The findings that every verdict has: the survey, many steps, where a defect comes from, the Jacobian.
    fn further_findings(&self, kind: VerdictKind, digits: Option<f64>) -> Vec<Finding> {
        let evidence = self.evidence;
        let mut findings = Vec::new();
        if let Some((found, step)) = self.largest_step()
            && !self.is_sampled()
            && let Some(exponent) = step
                .regularity
                .filter(|s| super::findings::roughness(*s).is_some())
        {
            let step = self.name(found, step);
            findings.push(Finding::Map(MapFinding::Regularity { exponent, step }));
        }
        if let Some(given) = self.loops.first() {
            let repeated = given
                .repeated_row
                .map(|row| Finding::Samples(SampleFinding::RepeatedRow { row }));
            let unequal = given.widest_gap.map(|widest| {
                Finding::Samples(SampleFinding::UnequalRows {
                    widest,
                    over_mean: widest * given.samples as f64,
                })
            });
            findings.extend(repeated.into_iter().chain(unequal));
        }
        findings.extend(
            evidence
                .survey
                .output_precision
                .map(|of| Finding::Map(MapFinding::Precision(of))),
        );
        let inside = evidence.survey.single_inside && evidence.survey.output_precision.is_none();
        findings.extend(inside.then_some(Finding::Map(MapFinding::SingleInside)));
        // If it is the reason of the verdict, it stands first.
        let scatter = evidence.survey.scatter;
        findings.extend(
            scatter
                .filter(|of| !of.is_random())
                .map(|of| Finding::Map(MapFinding::Scatter(of))),
        );
        findings.extend(
            (evidence.survey.ignores_step_size)
                .then_some(Finding::Map(MapFinding::IgnoresStepSize)),
        );
        findings.extend(
            evidence
                .survey
                .wrong_period
                .map(|of| Finding::Map(MapFinding::WrongPeriod(of))),
        );
        findings.extend(evidence.long_time.map(|steps| {
            Finding::Run(RunFinding::ManySteps {
                growth: long_time::growth(&steps),
                steps,
            })
        }));
        if let Some(localisation) = &evidence.localisation {
            let step = localisation.step_size.map_or(Step::Map, Step::Size);
            if !localisation.substeps.is_empty() {
                let substeps = localisation.substeps.clone();
                findings.push(Finding::Localisation(LocalisationFinding::Substeps {
                    substeps,
                    step,
                }));
            }
            if super::findings::largest_sector(&localisation.sectors).is_some() {
                let sectors = localisation.sectors.clone();
                findings.push(Finding::Localisation(LocalisationFinding::Sectors {
                    sectors,
                    step,
                }));
            }
        }
        if let Some(jacobian) = &evidence.jacobian
            && evidence.survey.singular.is_none()
            && evidence.survey.degenerate_form.is_none()
        {
            let finding = compare_jacobian(jacobian, kind, digits);
            findings.push(Finding::Run(RunFinding::Jacobian { finding }));
            findings.extend(
                (jacobian.blocks.clone())
                    .map(|blocks| Finding::Localisation(LocalisationFinding::Blocks { blocks })),
            );
        }
        findings.extend((evidence.omissions.iter()).map(|omission| {
            Finding::Run(RunFinding::Omitted {
                omission: omission.clone(),
            })
        }));
        if !self.is_sampled() && evidence.evaluations.made > 0 {
            findings.push(Finding::Run(RunFinding::Evaluations {
                made: evidence.evaluations.made,
                budget: evidence.evaluations.budget,
            }));
        }
        findings
    }

    /// Whether the Jacobian of a step is not symplectic.
    fn jacobian_refutes(&self) -> bool {
        (self.evidence.jacobian.as_ref()).is_some_and(|jacobian| {
            matches!(jacobian.verdict(), JacobianVerdict::NotSymplectic { .. })
        })
    }

    /// The strongest motion of a loop, and the step size that makes it, if it is known.
    fn strongest_motion(&self) -> Option<(Motion, Option<f64>)> {
        Motion::strongest(self.loops)
    }

    /// Whether something was left out that evaluations would have told.
    fn wants_evaluations(&self) -> Option<Advice> {
        let by_budget = |omission: &Omission| {
            let of_budget = matches!(
                omission.why,
                OmissionReason::Budget { .. } | OmissionReason::Unresolved
            );
            of_budget && omission.check != Check::SampleSweep
        };
        let wanted = self.evidence.evaluations.wanted;
        (wanted > 0 && self.evidence.omissions.iter().any(by_budget))
            .then_some(Advice::MoreEvaluations { wanted })
    }
}

/// A defect as findings carry it.
fn change(defect: &Defect) -> Change {
    Change {
        signed: defect.signed,
        uncertainty: Some(defect.uncertainty()).filter(|u| u.is_finite()),
    }
}

/// Whether the loop moves more than the given one.
fn moves_rest(found: &LoopEvidence) -> Option<Finding> {
    let loop_index = found.index;
    (found.kind == LoopKind::Extended)
        .then_some(Finding::Bounds(BoundFinding::MovesRest { loop_index }))
}

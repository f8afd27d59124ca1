//! From the evidence to the verdict.

mod broken;
mod conserved;
mod groups;
mod undecided;

use super::finding::{Advice, Change, Finding, Step, StepRange};
use super::jacobian::{JacobianVerdict, compare_jacobian};
use super::order::{Fit, fit_order, smallest_steps_slope};
use super::thresholds::{FAR, FEWEST_POINTS, SMALL, TREND};
use super::{Verdict, VerdictKind, long_time};
use crate::evidence::{
    Evidence, LoopEvidence, LoopKind, Motion, Omission, Origin, Scatter, StepEvidence,
};
use crate::rules::Defect;

/// Reaches the verdict. Pure: the same evidence gives the same verdict, whoever measured it.
///
/// A symplectic map conserves the loop integral of every closed loop exactly, at every step size. So one
/// significant defect proves that a map is not symplectic, and so does one break; the absence of both bounds the
/// defect for the loops and steps that were tried.
pub fn judge(evidence: &Evidence) -> Verdict {
    // Beside the manifold that a map projects onto it conserves nothing, and need not.
    let counted = match evidence.survey.singular {
        Some(_) => &evidence.loops[..evidence.loops.len().min(1)],
        None => &evidence.loops,
    };
    let fits: Vec<Fit> = counted.iter().filter_map(fit_order).collect();
    let case = Case {
        evidence,
        loops: counted,
        fits: &fits,
    };
    let mut decision = case.decide();
    if evidence.survey.is_rounded()
        && decision.kind != VerdictKind::NotSymplectic
        && !decision.advice.contains(&Advice::MoreDigits)
    {
        // Where rounding is what hides an answer, that comes first.
        let first = matches!(
            decision.because,
            Finding::WeakBound { .. } | Finding::Unexplained { .. } | Finding::SmallJumps { .. }
        ) && !matches!(decision.advice[..], [Advice::SmallerLoop { .. }, ..]);
        let place = if first { 0 } else { decision.advice.len() };
        decision.advice.insert(place, Advice::MoreDigits);
    }
    let mut findings = vec![decision.because];
    findings.append(&mut decision.findings);
    findings.extend(case.further_findings(decision.kind, decision.digits));
    Verdict {
        kind: decision.kind,
        digits: decision.digits,
        order: decision.order,
        conserved_once_closed: decision.conserved_once_closed,
        findings,
        advice: decision.advice,
        fits,
    }
}

/// What a case comes to, before the findings that stand beside every verdict.
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
}

struct Case<'a> {
    evidence: &'a Evidence,
    /// The loops that lie in the domain of the map.
    loops: &'a [LoopEvidence],
    fits: &'a [Fit],
}

impl<'a> Case<'a> {
    fn decide(&self) -> Decision {
        if self.steps().next().is_none() && self.loops.iter().all(|found| found.failure.is_none()) {
            let mut decision = Decision::new(VerdictKind::Undecided, Finding::NothingMeasured);
            decision.advice.push(Advice::MeasureLoop);
            return decision;
        }
        (self.no_closed_loop())
            .or_else(|| self.random_numbers())
            .or_else(|| self.beside_manifold())
            .or_else(|| self.broken())
            .or_else(|| self.not_contracted())
            .or_else(|| self.outside_its_domain())
            .or_else(|| self.not_symplectic())
            .or_else(|| self.projects())
            .or_else(|| self.undecided())
            .unwrap_or_else(|| self.symplectic())
    }

    fn is_sampled(&self) -> bool {
        self.evidence.origin == Origin::Samples
    }

    /// Every step with its loop.
    fn steps(&self) -> impl Iterator<Item = (&'a LoopEvidence, &'a StepEvidence)> + use<'a> {
        (self.loops.iter()).flat_map(|found| found.steps.iter().map(move |step| (found, step)))
    }

    /// The step with the largest defect among those that `wanted` picks. Loops that wind prove nothing: a
    /// symplectic map need not be exact.
    fn worst(
        &self,
        wanted: impl Fn(&StepEvidence) -> bool,
    ) -> Option<(&'a LoopEvidence, &'a StepEvidence)> {
        (self.steps())
            .filter(|(found, step)| !found.winds && wanted(step))
            .max_by(|a, b| a.1.defect.magnitude().total_cmp(&b.1.defect.magnitude()))
    }

    /// How the findings name a step of a loop.
    fn name(&self, found: &LoopEvidence, step: &StepEvidence) -> Step {
        match step.step_size {
            Some(h) => Step::Size(h),
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

    /// The law of the lowest order: a symmetric loop can hide terms of lower order. None where the defects of another loop
    /// fall more slowly at the smallest steps, without a law of their own.
    fn trend(&self) -> Option<&'a Fit> {
        let contractible = || self.loops.iter().filter(|found| !found.winds);
        let of_loop =
            |found: &LoopEvidence| (self.fits.iter()).find(|fit| fit.loop_index == found.index);
        let lowest = contractible()
            .filter_map(of_loop)
            .filter(|fit| fit.slope > TREND)
            .min_by(|a, b| a.slope.total_cmp(&b.slope))?;
        let falls_slower = |found: &LoopEvidence| {
            of_loop(found).is_none()
                && smallest_steps_slope(found).is_some_and(|slope| slope < lowest.slope - TREND)
        };
        (!contractible().any(falls_slower)).then_some(lowest)
    }

    fn not_symplectic(&self) -> Option<Decision> {
        let (found, step) = self.worst(StepEvidence::is_significant)?;
        let defect = step.defect.magnitude();
        let trend = self.trend();
        if defect < SMALL && trend.is_none() && !self.is_confirmed() {
            return None;
        }
        let name = self.name(found, step);
        let mut decision = Decision::new(
            VerdictKind::NotSymplectic,
            Finding::Changes {
                defect,
                step: name,
                law: trend.cloned(),
            },
        );
        decision.order = trend.and_then(Fit::whole);
        decision.findings.push(Finding::Significant {
            change: change(&step.defect),
            loop_index: found.index,
            step: name,
        });
        decision.findings.extend(moves_rest(found));
        decision
            .findings
            .extend(self.fits.iter().map(|fit| Finding::Law {
                fit: fit.clone(),
                between_breaks: false,
            }));
        decision
            .advice
            .extend(self.advice_on_order(trend.is_some()));
        Some(decision)
    }

    /// Whether a small defect without a law in h is confirmed: significant at two step sizes of one loop, or at
    /// one by far. Noise of the map's states is part of the uncertainty, as the spectrum shows it.
    fn is_confirmed(&self) -> bool {
        (self.loops.iter().filter(|found| !found.winds)).any(|found| {
            let significant = || found.steps.iter().filter(|step| step.is_significant());
            let far =
                |step: &StepEvidence| step.defect.magnitude() > FAR * step.defect.uncertainty();
            significant().count() >= 2 || significant().any(far)
        })
    }

    /// The step draws random numbers: what it does to a loop differs from run to run.
    fn random_numbers(&self) -> Option<Decision> {
        let scatter = self.evidence.survey.scatter.filter(Scatter::is_random)?;
        let mut decision = Decision::new(VerdictKind::Undecided, Finding::Scatter(scatter));
        decision.advice.push(Advice::SameRandomNumbers);
        Some(decision)
    }

    /// What would show the order of a defect.
    fn advice_on_order(&self, has_trend: bool) -> Option<Advice> {
        if has_trend || self.evidence.survey.ignores_step_size {
            return None;
        }
        let steps = self.loops.first().map_or(&[][..], |given| &given.steps);
        if steps.iter().any(|step| step.step_size.is_none()) {
            return Some(Advice::StateStepSizes);
        }
        if !self.fits.is_empty() && self.fits.iter().all(|fit| fit.slope <= TREND) {
            return Some(Advice::DefectDoesNotFall);
        }
        let given = steps.len();
        if given < FEWEST_POINTS + 1 {
            return Some(Advice::MoreStepSizes { given });
        }
        let significant = steps.iter().filter(|step| step.is_significant()).count();
        let drowned = significant < FEWEST_POINTS;
        Some(Advice::NoOrder { given, drowned })
    }

    /// What stands beside every verdict: the survey, many steps, where a defect comes from, the Jacobian.
    fn further_findings(&self, kind: VerdictKind, digits: Option<f64>) -> Vec<Finding> {
        let evidence = self.evidence;
        let mut findings = Vec::new();
        if let Some((found, step)) = self.largest_step()
            && !self.is_sampled()
            && let Some(exponent) = step
                .regularity
                .filter(|s| super::text::roughness(*s).is_some())
        {
            let step = self.name(found, step);
            findings.push(Finding::Regularity { exponent, step });
        }
        findings.extend(evidence.survey.output_precision.map(Finding::Precision));
        let inside = evidence.survey.single_inside && evidence.survey.output_precision.is_none();
        findings.extend(inside.then_some(Finding::SingleInside));
        // If it is the reason of the verdict, it stands first.
        let scatter = evidence.survey.scatter;
        findings.extend(scatter.filter(|of| !of.is_random()).map(Finding::Scatter));
        findings.extend((evidence.survey.ignores_step_size).then_some(Finding::IgnoresStepSize));
        findings.extend(evidence.long_time.map(|steps| Finding::ManySteps {
            growth: long_time::growth(&steps),
            steps,
        }));
        if let Some(localisation) = &evidence.localisation {
            let step = Step::Size(localisation.step_size);
            if !localisation.substeps.is_empty() {
                let substeps = localisation.substeps.clone();
                findings.push(Finding::Substeps { substeps, step });
            }
            if super::text::largest_sector(&localisation.sectors).is_some() {
                let sectors = localisation.sectors.clone();
                findings.push(Finding::Sectors { sectors, step });
            }
        }
        if let Some(jacobian) = &evidence.jacobian
            && evidence.survey.singular.is_none()
        {
            let finding = compare_jacobian(jacobian, kind, digits);
            findings.push(Finding::Jacobian { finding });
        }
        findings.extend(
            (evidence.omissions.iter()).map(|omission| Finding::Omitted {
                omission: omission.clone(),
            }),
        );
        if !self.is_sampled() && evidence.evaluations.made > 0 {
            findings.push(Finding::Evaluations {
                made: evidence.evaluations.made,
                budget: evidence.evaluations.budget,
            });
        }
        findings
    }

    /// Whether the Jacobian of a step is not symplectic.
    fn jacobian_refutes(&self) -> bool {
        (self.evidence.jacobian.as_ref()).is_some_and(|jacobian| {
            matches!(jacobian.verdict(), JacobianVerdict::NotSymplectic { .. })
        })
    }

    /// The strongest motion of a loop, and the step size that makes it, where it is known. Of shears, the one that
    /// deforms its loop most.
    fn strongest_motion(&self) -> Option<(Motion, Option<f64>)> {
        // Loops that wind, or bound no defect, acquit nobody, unless there are no others.
        let counts = |found: &&LoopEvidence| !found.winds && found.is_bounded();
        let counted: Vec<&LoopEvidence> = self.loops.iter().filter(counts).collect();
        match counted.is_empty() {
            true => strongest_motion(&self.loops.iter().collect::<Vec<_>>()),
            false => strongest_motion(&counted),
        }
    }

    /// Whether something was left out that evaluations would have told.
    fn wants_evaluations(&self) -> Option<Advice> {
        let by_budget = |omission: &Omission| {
            matches!(
                omission,
                Omission::StepSizes { .. }
                    | Omission::RandomLoops { .. }
                    | Omission::Samples { .. }
                    | Omission::JacobianBudget
                    | Omission::LocalisationBudget
                    | Omission::ManifoldBudget
                    | Omission::ContractionBudget
                    | Omission::LongTimeBudget
            )
        };
        let wanted = self.evidence.evaluations.wanted;
        (wanted > 0 && self.evidence.omissions.iter().any(by_budget))
            .then_some(Advice::MoreEvaluations { wanted })
    }
}

/// The strongest motion of some loops, and the step size that makes it.
fn strongest_motion(loops: &[&LoopEvidence]) -> Option<(Motion, Option<f64>)> {
    let strength = |motion: &Motion| match motion.shear {
        true => (false, motion.deformation),
        false => (true, motion.phase_advance),
    };
    (loops.iter().flat_map(|found| &found.steps))
        .filter_map(|step| Some((step.motion?, step.step_size)))
        .reduce(|a, b| match strength(&b.0) > strength(&a.0) {
            true => b,
            false => a,
        })
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
    (found.kind == LoopKind::Extended).then_some(Finding::MovesRest { loop_index })
}

/// The range of the step sizes of a loop.
fn range(found: &LoopEvidence) -> StepRange {
    let sizes = (found.steps.iter()).filter_map(|step| step.step_size.map(f64::abs));
    let (low, high) = sizes.fold((f64::INFINITY, 0.0), |(l, h): (f64, f64), size| {
        (l.min(size), h.max(size))
    });
    if high == 0.0 {
        StepRange::Unknown
    } else if low == high {
        StepRange::One(high)
    } else {
        StepRange::Between(low, high)
    }
}

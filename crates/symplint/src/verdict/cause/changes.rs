//! Why loop integrals change.

use super::blocks::MAX_SLOPE_OF_MODEL;
use super::{Cause, CauseKind, Clues};
use crate::evidence::{Origin, StepEvidence};
use crate::signal::{CERTAIN, SIGNIFICANT};
use crate::text::{self, one_digit, significant, with_uncertainty};
use crate::verdict::advice::Advice;
use crate::verdict::findings::{
    ChangeFinding, DomainFinding, Finding, LocalisationFinding, Step, culprits,
};
use crate::verdict::properties::{Property, PropertyName, noise};
use crate::verdict::thresholds::MIN_TREND;

/// Larger defects are not taken for those of a tolerance. Conventional: the largest that solvers have by default.
const MAX_TOLERANCE: f64 = 1e-6;

impl Clues<'_> {
    /// A coordinate has one value at some samples of the given loop.
    pub(super) fn clipped_on_loop(&self) -> Option<Cause> {
        let survey = &self.evidence.survey;
        let held = survey.held.filter(|_| !survey.is_rounded())?;
        let states = format!(
            "At {:.0}% of the samples of your loop, {}[{}] = {} after the largest step",
            100.0 * held.part,
            held.coordinate,
            held.dof,
            significant(held.value)
        );
        Some(Cause::clipped(&states, held.coordinate, held.dof))
    }

    /// The step projects onto a manifold.
    pub(super) fn projection(&self) -> Option<Cause> {
        let rank = self.findings.iter().find_map(|finding| match finding {
            Finding::Domain(DomainFinding::LosesRank { rank }) => Some(rank),
            _ => None,
        })?;
        Some(Cause::new(
            CauseKind::Projection,
            format!(
                "The step projects: its Jacobian has rank {} of {}. Steps that remove the momentum of the centre of mass, keep a \
                 constraint or clip a coordinate do this.",
                rank.rank, rank.of
            ),
            Advice::LoopOnManifold.to_string(),
        ))
    }

    /// An iteration does not converge at the larger step sizes.
    pub(super) fn no_convergence(&self) -> Option<Cause> {
        let advice = self
            .advice
            .iter()
            .find(|advice| matches!(advice, Advice::LetStepConverge { .. }))?;
        let finding = (self.findings.iter()).find(|finding| {
            matches!(
                finding,
                Finding::Changes(ChangeFinding::FailsToConverge { .. })
            )
        })?;
        Some(Cause::new(
            CauseKind::NoConvergence,
            finding.to_string(),
            advice.to_string(),
        ))
    }

    /// The result is the same for every step size.
    pub(super) fn ignores_step_size(&self) -> Option<Cause> {
        self.evidence.survey.ignores_step_size.then(|| {
            Cause::new(
                CauseKind::IgnoresStepSize,
                "The step gives the same result for every step size, to the last bit.".into(),
                "If the function is a right-hand side, which returns dq/dt and dp/dt, give a step of an integrator (`check_field` tests \
                 the right-hand side itself). If it has a time step of its own, let it use h. If it is a map without a step size, pass \
                 step_sizes = \"none\".",
            )
        })
    }

    /// Few of the substeps change the loop.
    pub(super) fn substep(&self) -> Option<Cause> {
        let found = self.evidence.localisation.as_ref()?;
        let (guilty, others) = culprits(&found.substeps);
        let are_known = others.iter().all(|of| of.uncertainty.is_some());
        if guilty.is_empty() || guilty.len() > others.len() || !are_known {
            return None;
        }
        let finding = LocalisationFinding::Substeps {
            substeps: found.substeps.clone(),
            step: found.step_size.map_or(Step::Map, Step::Size),
        };
        let (which, them) = match guilty.len() {
            1 => ("this substep", "it"),
            _ => ("these substeps", "each of them"),
        };
        Some(Cause::new(
            CauseKind::Substep,
            finding.to_string(),
            format!(
                "Look at {which} for friction, a wrong or rounded coefficient, a force that is not a gradient (`check_force`) and momenta \
                 that are not canonical, and check {them} alone, as a map without other substeps."
            ),
        ))
    }

    /// Whether the defect is the same at all step sizes.
    pub(super) fn is_constant(&self) -> bool {
        self.slope().is_some_and(|slope| slope.abs() <= MIN_TREND)
    }

    /// A small defect that does not depend on the step size, or that the noise of the map can make.
    pub(super) fn level_of_a_tolerance(&self) -> Option<Cause> {
        let steps = self.evidence.loops.iter().flat_map(|found| &found.steps);
        let significant = steps.filter(|step| step.is_significant());
        let largest = significant
            .map(|step| step.defect.magnitude())
            .reduce(f64::max)
            .filter(|largest| *largest < MAX_TOLERANCE)?;
        let defect = one_digit(largest);
        let text = match self.noise() {
            _ if self.is_constant() => format!(
                "The change, at most {defect}, does not depend on the step size, as errors of a tolerance or of a rounded constant do not. \
                 Errors of a method do."
            ),
            Some(noise) if largest < CERTAIN * noise => format!(
                "The change, at most {defect}, follows no power of h. The results of neighbouring states scatter by {} of the size of the \
                 loop, which is more than rounding explains. Errors of this size can cause the change, for example in a solver that stops \
                 at a tolerance.",
                one_digit(noise)
            ),
            _ => return None,
        };
        Some(Cause::new(
            CauseKind::SolverTolerance,
            text,
            "Tighten the tolerances of solvers inside the step, and look for constants and tables with few digits.",
        ))
    }

    /// The noise of a map in double precision, if neither loops nor the Jacobian show a defect that depends on the step size as the defect
    /// of a method does.
    fn noise(&self) -> Option<f64> {
        let jacobian = self.evidence.jacobian.as_ref()?;
        let is_smooth = !self.fits.is_empty() || jacobian.shows_defect();
        match is_smooth || self.evidence.survey.is_rounded() {
            true => None,
            false => noise(self.evidence),
        }
    }

    /// A conformally symplectic map.
    fn conformal(&self) -> Option<&Property> {
        let mut properties = self.properties.iter();
        properties.find(|property| {
            property.name == PropertyName::Conformal && property.holds == Some(true)
        })
    }

    /// All areas change their sign.
    pub(super) fn swapped(&self) -> Option<Cause> {
        if self.evidence.origin == Origin::Samples {
            return self.swapped_samples();
        }
        let [factor, of_factor] = self.conformal()?.factor?;
        ((factor + 1.0).abs() <= SIGNIFICANT * of_factor).then(|| {
            Cause::new(
                CauseKind::Swapped,
                "A step changes the sign of all areas, on all loops and in the Jacobian, and nothing else: q and p are swapped, or one of \
                 them has the wrong sign."
                    .into(),
                "Check that the step returns q and p in this order, and the signs of both.",
            )
        })
    }

    /// The integrals of all loops that another code advanced change their sign, to their uncertainty.
    fn swapped_samples(&self) -> Option<Cause> {
        let mut steps = (self.evidence.loops.iter()).flat_map(|found| &found.steps);
        let is_swapped = |step: &StepEvidence| {
            let uncertainty = step.defect.uncertainty();
            (step.defect.signed + 2.0).abs() <= SIGNIFICANT * uncertainty
                && step.defect.magnitude() > CERTAIN * uncertainty
        };
        steps.all(is_swapped).then(|| {
            Cause::new(
                CauseKind::Swapped,
                "The loop integrals after the step are those before it with the other sign: q and p are swapped, one of them has the \
                 wrong sign, or the samples are in the opposite order."
                    .into(),
                "Check the columns of the states after the step, the signs of q and p, and the order of the samples.",
            )
        })
    }

    /// All areas change by one factor.
    pub(super) fn friction(&self) -> Option<Cause> {
        let conformal = self.conformal()?;
        let [factor, of_factor] = conformal.factor.filter(|[factor, _]| *factor > 0.0)?;
        let value = text::factor(factor, of_factor);
        let kind = if factor < 1.0 { "friction" } else { "growth" };
        let jacobian = self.evidence.jacobian.as_ref();
        let by = match jacobian.is_some_and(|of| of.volume.is_some() && of.shows_defect()) {
            true => ", on all loops and in the Jacobian,",
            false => ", on all loops,",
        };
        let is_of_method = self.slope().is_some_and(|slope| slope > MAX_SLOPE_OF_MODEL);
        let meaning = match conformal.rate {
            // A factor that does not depend on the step size is not friction.
            _ if self.is_constant() => {
                " at all step sizes, as if the step returns momenta in other units than it takes".to_owned()
            }
            _ if is_of_method => ", and the change falls faster than h, which friction does not. A method that is not symplectic does this \
             if the forces on the loops are linear. Momenta that the step returns in other units do, too"
                .to_owned(),
            Some([rate, of_rate]) => {
                let sign = if rate > 0.0 { "−" } else { "" };
                let rate = with_uncertainty(rate.abs(), of_rate);
                format!(
                    ". Uniform {kind} e^({sign}γh) with γ = {rate} does this, and so does a reference momentum (a unit of p) that changes \
                     in the step"
                )
            }
            None => ". Uniform friction does this, and so does a reference momentum (a unit of p) that changes in the step".to_owned(),
        };
        let first = match is_of_method {
            true => self.remedy(),
            false => format!(
                "If the step has uniform {kind} on purpose, this result is expected: the step is conformally symplectic."
            ),
        };
        let remedy = format!(
            "{first} If momenta are divided by a reference momentum that the step changes, multiply them by it before and after the step."
        );
        let text = format!("A step multiplies all areas{by} by {value}{meaning}.");
        Some(Cause::new(CauseKind::Friction, text, remedy))
    }
}

//! Why loop integrals change.

use super::{Cause, CauseKind, Clues};
use crate::evidence::SIGNIFICANT;
use crate::verdict::advice::Advice;
use crate::verdict::findings::{ChangeFinding, DomainFinding, Finding};
use crate::verdict::number::{one_digit, within};
use crate::verdict::properties::{Property, PropertyName};

impl Clues<'_> {
    /// The step projects onto a manifold.
    pub(super) fn projection(&self) -> Option<Cause> {
        let rank = self.findings.iter().find_map(|finding| match finding {
            Finding::Domain(DomainFinding::LosesRank { rank }) => Some(rank),
            _ => None,
        })?;
        Some(Cause::new(
            CauseKind::Projection,
            format!(
                "The step projects: its Jacobian has rank {} of {}, as that of a step which removes the momentum of the centre of mass \
                 or keeps a constraint.",
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
                 the right-hand side itself). If it is a map without a step size, say so: step_sizes = \"none\".",
            )
        })
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
        let [factor, of_factor] = self.conformal()?.factor?;
        ((factor + 1.0).abs() <= SIGNIFICANT * of_factor).then(|| {
            Cause::new(
                CauseKind::Swapped,
                "A step changes the sign of all areas, of the Jacobian and of all loops, and nothing else: q and p are swapped, or one \
                 of them has the wrong sign."
                    .into(),
                "Check that the step returns q and p in this order, and the signs of both.",
            )
        })
    }

    /// All areas change by one factor.
    pub(super) fn friction(&self) -> Option<Cause> {
        let conformal = self.conformal()?;
        let [factor, of_factor] = conformal.factor.filter(|[factor, _]| *factor > 0.0)?;
        let (value, error) = (within(factor, of_factor), one_digit(of_factor));
        let meaning = if factor < 1.0 { "friction" } else { "growth" };
        let rate = conformal.rate.map_or(String::new(), |[rate, of_rate]| {
            let (rate, error) = (within(rate, of_rate), one_digit(of_rate));
            format!(", as uniform {meaning} e^(−γh) with γ = {rate} ± {error} does")
        });
        Some(Cause::new(
            CauseKind::Friction,
            format!(
                "A step multiplies all areas, of the Jacobian and of all loops, by {value} ± {error}{rate}, or momenta in units that \
                 the step changes."
            ),
            "If the step has uniform friction on purpose, it does what it should: it is conformally symplectic. If momenta are \
             divided by a reference momentum that the step changes, multiply them by it before and after the step.",
        ))
    }
}

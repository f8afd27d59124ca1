//! Why loop integrals change.

use super::{Cause, CauseKind, Clues};
use crate::verdict::advice::Advice;
use crate::verdict::findings::{ChangeFinding, DomainFinding, Finding};
use crate::verdict::number::{one_digit, within};
use crate::verdict::properties::PropertyName;

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

    /// All areas change by one factor.
    pub(super) fn friction(&self) -> Option<Cause> {
        let mut properties = self.properties.iter();
        let conformal = properties.find(|property| {
            property.name == PropertyName::Conformal && property.holds == Some(true)
        })?;
        let [factor, of_factor] = conformal.factor?;
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

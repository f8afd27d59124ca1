//! Properties of a map besides the verdict on its loop integrals.

use std::fmt::{self, Display, Formatter};

use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

use super::VerdictKind;
use super::number::{one_digit, two_digits, within};
use crate::evidence::{
    Evidence, LoopEvidence, ReturnDefect, SIGNIFICANT, StepEvidence, UNEXPLAINED, WEAKEST_BOUND,
};
use crate::jacobian::{JacobianMethod, TangentDefect, VolumeEvidence};

/// A property of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum PropertyName {
    /// All loop integrals are conserved.
    Symplectic,
    /// All areas, and so all loop integrals, change by one factor.
    Conformal,
    /// det DΦ = 1.
    Volume,
    /// ρ Φ_h ρ Φ_h = id, where ρ changes the signs of the momenta, or those that were given.
    Reversible,
    /// Φ_−h Φ_h = id.
    Symmetric,
}

/// Whether a map has a property.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Property {
    /// Which.
    pub name: PropertyName,
    /// `None` if it was not tested, or the test is not precise enough.
    pub holds: Option<bool>,
    /// The largest deviation from it, relative: of the loop integral, of det DΦ from 1, of a state from where it began in half ranges
    /// of the loop.
    pub defect: Option<f64>,
    /// Half the width of the interval in which the defect lies.
    pub uncertainty: Option<f64>,
    /// The factor by which a step multiplies all areas, and its uncertainty, of a conformally symplectic map.
    pub factor: Option<[f64; 2]>,
    /// The rate γ of uniform damping e^(−γh), and its uncertainty.
    pub rate: Option<[f64; 2]>,
    /// Whether it follows from the verdict, so that reports need not print it.
    pub implied: bool,
}

/// Whether a defect shows that a property holds.
fn holds(defect: f64, uncertainty: f64, least_defect: f64) -> Option<bool> {
    if defect > least_defect.max(SIGNIFICANT * uncertainty) {
        Some(false)
    } else if defect <= least_defect.max(UNEXPLAINED * uncertainty)
        && defect + uncertainty <= WEAKEST_BOUND
    {
        Some(true)
    } else {
        None
    }
}

impl Property {
    fn new(name: PropertyName, holds: Option<bool>) -> Self {
        Property {
            name,
            holds,
            defect: None,
            uncertainty: None,
            factor: None,
            rate: None,
            implied: false,
        }
    }

    fn measured(name: PropertyName, defect: f64, uncertainty: f64, least: f64) -> Self {
        Property {
            defect: Some(defect),
            uncertainty: Some(uncertainty),
            ..Property::new(name, holds(defect, uncertainty, least))
        }
    }
}

/// All properties that were tested, or follow from the verdict.
pub(super) fn properties(
    evidence: &Evidence,
    kind: VerdictKind,
    digits: Option<f64>,
) -> Vec<Property> {
    let symplectic = Property {
        defect: digits.map(|digits| 10f64.powf(-digits)),
        implied: true,
        ..Property::new(
            PropertyName::Symplectic,
            match kind {
                VerdictKind::Symplectic => Some(true),
                VerdictKind::BrokenLoops | VerdictKind::NotSymplectic => Some(false),
                VerdictKind::Undecided => None,
            },
        )
    };
    let implied = [PropertyName::Conformal, PropertyName::Volume].map(|name| Property {
        implied: true,
        ..Property::new(name, Some(true))
    });
    let implied = (implied.into_iter()).filter(|_| kind == VerdictKind::Symplectic);
    let jacobian = (evidence.jacobian.as_ref()).filter(|_| kind != VerdictKind::Symplectic);
    let of_jacobian = jacobian.and_then(|found| Some((found.method, found.volume?)));
    let of_jacobian = of_jacobian.into_iter().flat_map(|(method, found)| {
        let conformal = conformal(evidence, kind, method, &found);
        [Some(volume_preserving(method, &found)), conformal]
    });
    let structure = evidence.structure.unwrap_or_default();
    let returns = [
        (PropertyName::Reversible, structure.reversible),
        (PropertyName::Symmetric, structure.symmetric),
    ];
    let returns = returns.into_iter().map(|(name, found)| {
        let ReturnDefect {
            defect,
            uncertainty,
            ..
        } = found?;
        Some(Property::measured(name, defect, uncertainty, 0.0))
    });
    (std::iter::once(symplectic).chain(implied))
        .map(Some)
        .chain(of_jacobian)
        .chain(returns)
        .flatten()
        .collect()
}

fn volume_preserving(method: JacobianMethod, found: &VolumeEvidence) -> Property {
    let TangentDefect {
        signed,
        uncertainty,
        ..
    } = found.determinant;
    let least = method.least_defect();
    Property::measured(PropertyName::Volume, signed.abs(), uncertainty, least)
}

/// Whether all areas change by one factor, if a Jacobian shows that they change.
fn conformal(
    evidence: &Evidence,
    kind: VerdictKind,
    method: JacobianMethod,
    found: &VolumeEvidence,
) -> Option<Property> {
    let least = method.least_defect();
    let (factor, of_factor) = (found.factor, found.factor_uncertainty);
    // With the factor 1 it is symplectic, and a loop that breaks has no factor.
    let changes = (factor - 1.0).abs() > least.max(SIGNIFICANT * of_factor) && factor > 0.0;
    let worst = found.from_conformal;
    let of_jacobian = (worst.magnitude(), worst.uncertainty);
    // The Jacobian at some states, and loops, should have the same factor.
    let h = evidence.jacobian.as_ref()?.step_size;
    let of_loops = loops_of(evidence, h).map(|step| {
        let of_loop = 1.0 + step.defect.signed * step.initial.signum();
        let difference = (of_loop - factor).abs();
        (difference, step.defect.uncertainty() + of_factor)
    });
    let excess = |(defect, uncertainty): (f64, f64)| defect / uncertainty;
    let (defect, uncertainty) =
        (of_loops.filter(|(_, uncertainty)| uncertainty.is_finite())).fold(of_jacobian, |a, b| {
            if excess(b) > excess(a) { b } else { a }
        });
    let property = Property::measured(PropertyName::Conformal, defect, uncertainty, least);
    let holds = match property.holds {
        Some(true) if kind == VerdictKind::BrokenLoops => Some(false),
        Some(true) if !changes => return None,
        holds => holds,
    };
    let rate = |h: f64| [-factor.ln() / h, of_factor / (factor * h.abs())];
    let of_one_factor = holds == Some(true);
    Some(Property {
        holds,
        factor: of_one_factor.then_some([factor, of_factor]),
        rate: h.filter(|_| of_one_factor).map(rate),
        ..property
    })
}

/// Steps of this size that loops made which neither break nor wind.
fn loops_of(evidence: &Evidence, h: Option<f64>) -> impl Iterator<Item = &StepEvidence> {
    let counts = |found: &&LoopEvidence| !found.winds;
    let steps = (evidence.loops.iter().filter(counts)).flat_map(|found| &found.steps);
    steps.filter(move |step| step.step_size == h && step.jump.is_none() && !step.misses_the_grid())
}

impl Display for PropertyName {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            PropertyName::Symplectic => "symplectic",
            PropertyName::Conformal => "conformally symplectic",
            PropertyName::Volume => "volume preserving",
            PropertyName::Reversible => "time-reversible",
            PropertyName::Symmetric => "symmetric",
        })
    }
}

impl Display for Property {
    /// `not volume preserving (|det DΦ − 1| = 0.058)`.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.holds {
            Some(true) => write!(f, "{}", self.name)?,
            Some(false) => write!(f, "not {}", self.name)?,
            None => write!(f, "unknown whether {}", self.name)?,
        }
        if let Some([factor, of_factor]) = self.factor {
            let (value, error) = (within(factor, of_factor), one_digit(of_factor));
            write!(f, " (a step multiplies all areas by {value} ± {error}")?;
            if let Some([rate, of_rate]) = self.rate {
                let motion = if rate > 0.0 { "damping" } else { "growth" };
                let (value, error) = (within(rate, of_rate), one_digit(of_rate));
                write!(f, ": uniform {motion} e^(−γh), γ = {value} ± {error}")?;
            }
            return f.write_str(")");
        }
        let (Some(defect), Some(uncertainty)) = (self.defect, self.uncertainty) else {
            return Ok(());
        };
        let bound = one_digit(defect + uncertainty);
        let value = match self.holds {
            Some(_) => two_digits(defect),
            None => format!("{} ± {}", two_digits(defect), one_digit(uncertainty)),
        };
        match (self.name, self.holds == Some(true)) {
            (PropertyName::Symplectic, _) => write!(f, " (|E| = {value})"),
            (PropertyName::Volume, true) => write!(f, " (|det DΦ − 1| ≤ {bound})"),
            (PropertyName::Volume, false) => write!(f, " (|det DΦ − 1| = {value})"),
            (PropertyName::Conformal, _) => {
                write!(f, " (the factors of areas differ by {value})")
            }
            (PropertyName::Reversible | PropertyName::Symmetric, true) => {
                write!(f, " (to {bound} of the loop)")
            }
            (PropertyName::Reversible | PropertyName::Symmetric, false) => {
                write!(f, " (states return to a distance of {value} of the loop)")
            }
        }
    }
}

impl Serialize for Property {
    /// With `holds` as `yes`, `no` or `unknown`, and the property as a `text`.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Property", 8)?;
        fields.serialize_field("name", &self.name)?;
        let holds = match self.holds {
            Some(true) => "yes",
            Some(false) => "no",
            None => "unknown",
        };
        fields.serialize_field("holds", holds)?;
        fields.serialize_field("defect", &self.defect)?;
        fields.serialize_field("uncertainty", &self.uncertainty)?;
        fields.serialize_field("factor", &self.factor)?;
        fields.serialize_field("rate", &self.rate)?;
        fields.serialize_field("implied", &self.implied)?;
        fields.serialize_field("text", &self.to_string())?;
        fields.end()
    }
}

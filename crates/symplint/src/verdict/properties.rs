//! Properties of a map besides the verdict on its loop integrals.

use std::fmt::{self, Display, Formatter};

use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

use super::VerdictKind;
use super::long_time::{Growth, growth_of_energy};
use super::thresholds::MAX_DISTANCE_TO_WHOLE;
use crate::evidence::{
    EnergyAtStep, EnergyInTime, Evidence, LoopEvidence, MAX_BOUND_ON_DEFECT, StepEvidence,
    StructureEvidence,
};
use crate::jacobian::TangentDefect;
use crate::signal::{SIGNIFICANT, UNEXPLAINED};
use crate::text::{self, one_digit, two_digits, with_uncertainty};

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
    /// ρ Φ_h ρ Φ_h = id, where ρ changes the signs of the momenta, or is given.
    Reversible,
    /// Φ_−h Φ_h = id.
    Symmetric,
    /// A step does not change the energy that was given.
    Energy,
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
    /// of the loop, of the energy in units of its range on the loop.
    pub defect: Option<f64>,
    /// Half the width of the interval in which the defect lies.
    pub uncertainty: Option<f64>,
    /// The factor by which a step multiplies all areas, and its uncertainty, of a conformally symplectic map.
    pub factor: Option<[f64; 2]>,
    /// The rate γ of uniform damping e^(−γh), and its uncertainty.
    pub rate: Option<[f64; 2]>,
    /// The coordinate that misses its start most if steps back do not undo a step: `q` or `p`, and the degree of freedom.
    pub place: Option<(char, usize)>,
    /// Whether the user gave the signs, or the map, that reverse time.
    pub given_reversal: bool,
    /// The energy in many steps, if they were asked for, in units of its range on the loop.
    pub in_time: Option<(EnergyInTime, Growth)>,
    /// The k of a change of the energy by a step that is proportional to h^k.
    pub order: Option<f64>,
    /// Whether it follows from the verdict or is not known, so that reports need not print it.
    pub implied: bool,
}

/// A smaller distance of a state from its start, in half ranges of the loop, may be the residual of a stage that is solved to round-off.
/// Calibrated: as the least defect of a tangent map, which has the same cause.
const MIN_RETURN_DEFECT: f64 = 1e-12;

/// As many loops that change by one factor show that all do. Conventional: loops are random, and a factor of each has ten digits or more.
const MIN_LOOPS: usize = 5;

/// A property that is not known to this uncertainty is not worth a line. Conventional.
const MAX_UNCERTAINTY: f64 = 1e-2;

/// Whether a defect shows that a property holds.
fn holds(defect: f64, uncertainty: f64, least_defect: f64) -> Option<bool> {
    if defect > least_defect.max(SIGNIFICANT * uncertainty) {
        Some(false)
    } else if defect <= least_defect.max(UNEXPLAINED * uncertainty)
        && defect + uncertainty <= MAX_BOUND_ON_DEFECT
    {
        Some(true)
    } else {
        None
    }
}

impl Property {
    /// Whether it holds, and does not hold for a step with friction. (A step with a thermostat can be time-reversible.)
    pub(super) fn excludes_friction(&self) -> bool {
        self.name == PropertyName::Volume && self.holds == Some(true)
    }

    fn new(name: PropertyName, holds: Option<bool>) -> Self {
        Property {
            name,
            holds,
            defect: None,
            uncertainty: None,
            factor: None,
            rate: None,
            place: None,
            given_reversal: false,
            in_time: None,
            order: None,
            implied: false,
        }
    }

    fn measured(name: PropertyName, defect: f64, uncertainty: f64, least: f64) -> Self {
        let holds = holds(defect, uncertainty, least);
        Property {
            defect: Some(defect),
            uncertainty: Some(uncertainty),
            // A bound as weak as this tells nothing.
            implied: holds.is_none() && uncertainty > MAX_UNCERTAINTY,
            ..Property::new(name, holds)
        }
    }

    /// It follows from the verdict, or nothing more can be said about it.
    fn implied(name: PropertyName, holds: Option<bool>) -> Self {
        Property {
            implied: true,
            ..Property::new(name, holds)
        }
    }
}

/// All properties that were tested, or follow from the verdict.
pub(super) fn properties(evidence: &Evidence, kind: VerdictKind) -> Vec<Property> {
    let is_symplectic = match kind {
        VerdictKind::Symplectic => Some(true),
        VerdictKind::BrokenLoops | VerdictKind::NotSymplectic => Some(false),
        VerdictKind::Undecided => None,
    };
    let mut properties = vec![Property::implied(PropertyName::Symplectic, is_symplectic)];
    let Some(structure) = evidence.structure else {
        return properties;
    };
    let survey = &evidence.survey;
    // A map that projects, or a degenerate form, has its properties on the manifold or leaf alone.
    let is_degenerate = survey.singular.is_some() || survey.degenerate_form.is_some();
    properties.push(match kind {
        VerdictKind::Symplectic => Property::implied(PropertyName::Conformal, Some(true)),
        _ => conformal(evidence, &structure, kind)
            .filter(|_| !is_degenerate)
            .unwrap_or_else(|| Property::implied(PropertyName::Conformal, None)),
    });
    if !structure.on_manifold {
        properties.push(match (kind, structure.dof) {
            (VerdictKind::Symplectic, _) => Property::implied(PropertyName::Volume, Some(true)),
            // Areas are volumes.
            (VerdictKind::NotSymplectic, 1) => Property::implied(PropertyName::Volume, Some(false)),
            (_, 1) => Property::implied(PropertyName::Volume, None),
            _ => volume_preserving(evidence)
                .filter(|_| !is_degenerate)
                .unwrap_or_else(|| Property::implied(PropertyName::Volume, None)),
        });
    }
    let is_reversal = structure.given_reversal || !structure.on_manifold;
    for (name, found, is_asked_for) in [
        (PropertyName::Reversible, structure.reversible, is_reversal),
        (
            PropertyName::Symmetric,
            structure.symmetric,
            structure.asked_for_symmetry,
        ),
    ] {
        if !is_asked_for {
            continue;
        }
        properties.push(match found.filter(|_| !is_degenerate) {
            Some(found) => Property {
                place: Some((found.coordinate, found.dof)),
                given_reversal: structure.given_reversal,
                ..Property::measured(name, found.defect, found.uncertainty, MIN_RETURN_DEFECT)
            },
            None => Property::implied(name, None),
        });
    }
    let in_time = evidence.long_time.and_then(|steps| steps.energy);
    properties.extend(structure.energy.map(|found| Property {
        in_time: in_time.filter(|_| found.range > 0.0).map(|of| {
            let relative = EnergyInTime {
                early: of.early / found.range,
                late: of.late / found.range,
                most: of.most / found.range,
                least: of.least / found.range,
                change: of.change / found.range,
                ..of
            };
            (relative, growth_of_energy(&relative))
        }),
        order: found.by_step_size.as_ref().and_then(order_of_energy),
        ..Property::measured(
            PropertyName::Energy,
            found.change,
            found.uncertainty,
            MIN_RETURN_DEFECT,
        )
    }));
    properties
}

/// The whole number that is the slope of log |change| over log h between neighbouring step sizes.
fn order_of_energy(found: &[EnergyAtStep; 3]) -> Option<f64> {
    let slope = |pair: &[EnergyAtStep]| {
        let [large, small] = [pair[0], pair[1]];
        let ratio = (large.step_size / small.step_size).abs().ln();
        let error = large.uncertainty / large.change + small.uncertainty / small.change;
        ((large.change / small.change).ln() / ratio, error / ratio)
    };
    let whole = slope(&found[1..]).0.round();
    let agrees =
        |(slope, error): (f64, f64)| (slope - whole).abs() + error <= MAX_DISTANCE_TO_WHOLE;
    (whole > 0.0 && found.windows(2).map(slope).all(agrees)).then_some(whole)
}

fn volume_preserving(evidence: &Evidence) -> Option<Property> {
    let jacobian = evidence.jacobian.as_ref()?;
    let TangentDefect {
        signed,
        uncertainty,
        ..
    } = jacobian.volume?.determinant;
    let least = jacobian.method.least_defect();
    Some(Property::measured(
        PropertyName::Volume,
        signed.abs(),
        uncertainty,
        least,
    ))
}

/// Whether all areas change by one factor, for the Jacobian and for all loops.
fn conformal(
    evidence: &Evidence,
    structure: &StructureEvidence,
    kind: VerdictKind,
) -> Option<Property> {
    let jacobian = evidence.jacobian.as_ref()?;
    let (h, least) = (jacobian.step_size, jacobian.method.least_defect());
    let of_loops = || {
        let factors = loops_of(evidence, h).map(|step| {
            let factor = 1.0 + step.defect.signed * step.initial.signum();
            (factor, step.defect.uncertainty())
        });
        factors.filter(|(_, uncertainty)| uncertainty.is_finite())
    };
    let best = of_loops().min_by(|a, b| a.1.total_cmp(&b.1));
    let are_many = !jacobian.projected && of_loops().count() >= MIN_LOOPS;
    // Random tangent vectors in many degrees of freedom show no factor: many loops do.
    let by_loops_alone = !jacobian.full && are_many;
    // A change that is too small for the derivatives is known from many loops, if all agree within their uncertainties.
    let agree = |(factor, of_factor): (f64, f64)| {
        of_loops()
            .all(|(other, of_other)| (other - factor).abs() <= UNEXPLAINED * (of_factor + of_other))
    };
    let is_known = are_many && noise(evidence).is_none() && best.is_some_and(agree);
    let least_change = match is_known {
        true => 0.0,
        false => least,
    };
    let (of_jacobian, of_factor, worst) = match jacobian.volume {
        Some(found) => {
            let worst = found.from_conformal;
            let worst = (worst.magnitude(), worst.uncertainty);
            (found.factor, found.factor_uncertainty, worst)
        }
        None => {
            let (factor, uncertainty) = best.filter(|_| by_loops_alone)?;
            (factor, uncertainty, (0.0, uncertainty))
        }
    };
    let differences = of_loops().map(|(factor, uncertainty)| {
        let difference = (factor - of_jacobian).abs();
        (difference, uncertainty + of_factor)
    });
    let excess = |(defect, uncertainty): (f64, f64)| defect / uncertainty;
    let (defect, uncertainty) =
        differences.fold(worst, |a, b| if excess(b) > excess(a) { b } else { a });
    let property = Property::measured(PropertyName::Conformal, defect, uncertainty, least);
    if property.holds != Some(true) {
        return Some(property);
    }
    // Loops have more digits than differences. Factors differ by up to the defect, and factors of loops by the differences seen.
    let of_jacobian = (of_jacobian, of_factor.max(defect));
    let of_best = best.map(|(factor, uncertainty)| {
        let beyond = of_loops().map(|(other, of_other)| (other - factor).abs() - of_other);
        (factor, beyond.fold(uncertainty, f64::max))
    });
    let more_certain = of_best.filter(|of_best| of_best.1 < of_jacobian.1);
    let (factor, of_factor) = more_certain.unwrap_or(of_jacobian);
    let changes = (factor - 1.0).abs() > least_change.max(SIGNIFICANT * of_factor);
    // A loop that breaks has no factor, and a map with the factor 1 is symplectic.
    if kind == VerdictKind::BrokenLoops || !changes {
        return None;
    }
    let time = h
        .filter(|_| factor > 0.0)
        .map(|h| h * structure.steps as f64);
    Some(Property {
        factor: Some([factor, of_factor]),
        rate: time.map(|time| [-factor.ln() / time, of_factor / (factor * time.abs())]),
        ..property
    })
}

/// The noise of the map, of one coordinate relative to its size on the loop, if rounding does not explain it.
pub(super) fn noise(evidence: &Evidence) -> Option<f64> {
    let steps = evidence.loops.iter().flat_map(|found| &found.steps);
    let rounding = steps.map(|step| step.defect.roundoff).fold(0.0, f64::max);
    let noise = evidence.jacobian.as_ref()?.noise;
    (noise > UNEXPLAINED * rounding).then_some(noise)
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
            PropertyName::Energy => "energy conserving",
        })
    }
}

impl Display for Property {
    /// `not volume preserving (|det M − 1| = 0.058)`.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.holds {
            Some(true) => write!(f, "{}", self.name)?,
            Some(false) => write!(f, "not {}", self.name)?,
            None => write!(f, "unknown whether {}", self.name)?,
        }
        if let Some([factor, of_factor]) = self.factor {
            let factor = text::factor(factor, of_factor);
            write!(f, " (a step multiplies all areas by {factor}")?;
            if let Some([rate, of_rate]) = self.rate {
                let motion = match rate > 0.0 {
                    true => "damping e^(−γh)",
                    false => "growth e^(γh)",
                };
                let rate = with_uncertainty(rate.abs(), of_rate);
                write!(f, ": uniform {motion}, γ = {rate}")?;
            }
            return f.write_str(")");
        }
        let (Some(defect), Some(uncertainty)) = (self.defect, self.uncertainty) else {
            return Ok(());
        };
        let bound = one_digit(defect + uncertainty);
        let value = match self.holds {
            Some(_) => two_digits(defect),
            None => with_uncertainty(defect, uncertainty),
        };
        let signs = match self.given_reversal {
            true => "the given reversal",
            false => "p → −p",
        };
        let way = match self.name {
            PropertyName::Symplectic => return Ok(()),
            PropertyName::Conformal => {
                return write!(
                    f,
                    " (a step multiplies areas by factors that differ by {value})"
                );
            }
            PropertyName::Volume => {
                return match self.holds {
                    Some(true) => write!(f, " (|det M − 1| ≤ {bound})"),
                    _ => write!(f, " (|det M − 1| = {value})"),
                };
            }
            PropertyName::Energy => {
                let value = if self.holds == Some(true) {
                    bound
                } else {
                    value
                };
                write!(
                    f,
                    " (a step changes the energy by up to {value} of its range on the loop"
                )?;
                if let Some(order) = self.order {
                    write!(f, ", in proportion to {}", text::power_of_h(order))?;
                }
                match &self.in_time {
                    Some((found, growth)) => write!(f, "; {}", in_time(found, *growth))?,
                    None if self.holds == Some(false) => {
                        f.write_str("; whether the change adds up was not tested: set `steps`")?;
                    }
                    None => {}
                }
                return f.write_str(")");
            }
            PropertyName::Reversible => format!("step, {signs}, step"),
            PropertyName::Symmetric => "a step of h, then −h".to_owned(),
        };
        match (self.holds, self.place) {
            (Some(true), _) | (_, None) => {
                write!(f, " ({way}: back at the start to {bound} of the radius)")
            }
            (_, Some((coordinate, dof))) => {
                write!(
                    f,
                    " ({way}: {coordinate}[{dof}] misses the start by {value} of the radius)"
                )
            }
        }
    }
}

/// What many steps do to the energy.
fn in_time(found: &EnergyInTime, growth: Growth) -> String {
    let EnergyInTime {
        steps, early, late, ..
    } = *found;
    let (early, late, most) = (
        two_digits(early),
        two_digits(late),
        two_digits(early.max(late)),
    );
    match growth {
        Growth::None => format!("{steps} steps by up to {most}: it is conserved"),
        Growth::Bounded => format!("{steps} steps by up to {most}: the change stays bounded"),
        Growth::Grows => format!(
            "the energy drifts: by up to {early} in the first quarter of {steps} steps, and {late} in the last"
        ),
        Growth::Undecided => format!(
            "{steps} steps by up to {most}, which shows neither a bound nor a drift: take more steps"
        ),
    }
}

impl Serialize for Property {
    /// With `holds` as `yes`, `no` or `unknown`, and the property as a `text`.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Property", 10)?;
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
        fields.serialize_field("growth", &self.in_time.map(|(_, growth)| growth))?;
        fields.serialize_field("order", &self.order)?;
        fields.serialize_field("implied", &self.implied)?;
        fields.serialize_field("text", &self.to_string())?;
        fields.end()
    }
}

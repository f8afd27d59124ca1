//! Many steps: does a defect stay bounded, or does it grow?
//!
//! A method that is conjugate to a symplectic one, Φ = χ⁻¹ ∘ Ψ ∘ χ, changes loop integrals in every
//! step, but n steps change them no more than one: Φⁿ = χ⁻¹ ∘ Ψⁿ ∘ χ. Its defect varies and returns. That
//! of other methods adds up (HLW, chapter VI.8, on conjugate symplecticity).

use serde::Serialize;

use super::thresholds::{
    MAX_RETURN, MAX_ROUND_OFF_DEFECT, MAX_VARIATION, MIN_DRIFT, MIN_GROWTH, MIN_STEPS,
};
use crate::evidence::{EnergyInTime, LongTime};

/// What becomes of a defect in many steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Growth {
    /// No step shows a defect of 1e-11 or more.
    None,
    /// It stays of one size and returns: the method may be conjugate to a symplectic one.
    Bounded,
    /// It adds up.
    Grows,
    /// The steps that the samples resolve do not tell.
    Undecided,
}

/// Judges the energies of many steps, in units of their range. States of a symplectic map come back to their energies; if all of them stay away, a drift has come
/// to an end.
pub(super) fn growth_of_energy(found: &EnergyInTime) -> Growth {
    if found.steps < MIN_STEPS {
        Growth::Undecided
    } else if found.early.max(found.late) < MAX_ROUND_OFF_DEFECT {
        Growth::None
    } else if found.late > MIN_GROWTH * found.early || found.least > MIN_DRIFT * found.most {
        Growth::Grows
    } else if found.late < MAX_VARIATION * found.early && found.least < MAX_RETURN * found.most {
        Growth::Bounded
    } else {
        Growth::Undecided
    }
}

/// Judges the defects of many steps.
pub(super) fn growth(found: &LongTime) -> Growth {
    if found.steps < MIN_STEPS {
        Growth::Undecided
    } else if found.largest < MAX_ROUND_OFF_DEFECT {
        Growth::None
    } else if found.late > MIN_GROWTH * found.early {
        Growth::Grows
    } else if found.late < MAX_VARIATION * found.early && found.least < MAX_RETURN * found.largest {
        Growth::Bounded
    } else {
        Growth::Undecided
    }
}

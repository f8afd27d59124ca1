//! Structure of a map besides its loop integrals.

use serde::{Deserialize, Serialize};

/// Whether steps back undo a step of the largest size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StructureEvidence {
    /// Degrees of freedom.
    pub dof: usize,
    /// Steps of size h that the map makes: more than one if it is composed with itself.
    pub steps: usize,
    /// Whether the map acts on a manifold: a constraint, or the graph of a one-form. det DΦ has no meaning there.
    pub on_manifold: bool,
    /// Whether the user gave the reversal ρ, as signs or as a map; otherwise ρ changes the signs of all momenta.
    pub given_reversal: bool,
    /// Whether the test of symmetry was asked for.
    pub asked_for_symmetry: bool,
    /// States that were tested.
    pub states: usize,
    /// ρ Φ_h ρ Φ_h against the identity. `None` if it was not tested: an [omission](super::Omission) has the reason, or the map acts
    /// on a manifold.
    pub reversible: Option<ReturnDefect>,
    /// Φ_−h Φ_h against the identity. `None` if it was not tested.
    pub symmetric: Option<ReturnDefect>,
    /// How a step changes the energy. `None` if the map has none, or the test was left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy: Option<EnergyChange>,
}

/// The largest change of the energy of a state by a step, in units of the range of the energy of all states that were tested.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnergyChange {
    /// The change.
    pub change: f64,
    /// The change that rounding and noise of the map and of the energy explain.
    pub uncertainty: f64,
    /// The range of the energy of all states that were tested, in its own unit.
    #[serde(default)]
    pub range: f64,
    /// The change at the three smallest step sizes at which it is significant, the largest first. `None` if there are fewer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by_step_size: Option<[EnergyAtStep; 3]>,
}

/// The largest change of the energy of a state by a step of some size, in the same units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnergyAtStep {
    /// The step size.
    pub step_size: f64,
    /// The change.
    pub change: f64,
    /// The change that rounding and noise explain.
    pub uncertainty: f64,
}

/// The largest distance between a state and the state to which the map returns it, in units of half the range of the coordinate on
/// the loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReturnDefect {
    /// The loop parameter of the state. The state lies between the loop at this parameter and the middle of the loop.
    pub s: f64,
    /// `q` or `p`.
    pub coordinate: char,
    /// The degree of freedom.
    pub dof: usize,
    /// The distance.
    pub defect: f64,
    /// The distance that rounding and noise of the map explain.
    pub uncertainty: f64,
}

//! Structure of a map besides its loop integrals.

use serde::{Deserialize, Serialize};

/// Whether steps back undo one step of the largest size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StructureEvidence {
    /// ρ Φ_h ρ Φ_h against the identity, where ρ changes the signs of coordinates: of all momenta by default. `None` if the map
    /// fails there, or was not tested.
    pub reversible: Option<ReturnDefect>,
    /// Φ_−h Φ_h against the identity. `None` if the map fails there, or was not tested.
    pub symmetric: Option<ReturnDefect>,
}

/// The largest distance between a state and the state to which the map returns it, in units of half the range of the coordinate on
/// the loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReturnDefect {
    /// The loop parameter of the state.
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

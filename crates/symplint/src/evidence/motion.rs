//! How one step moves a loop.

use serde::{Deserialize, Serialize};

/// How much one step moves the samples of a loop against each other: whether it could show a defect at all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Motion {
    /// The largest motion of a coordinate against the mean motion, over half its range on the loop. It depends on
    /// units.
    pub deformation: f64,
    /// By how much the motions on the loop are advanced, in radians:
    ///
    /// ```text
    /// θ² = Σ_i |w_i| ε_i(Δγ) / Σ_i |w_i| ε_i(γ)
    /// ```
    ///
    /// γ are the samples, Δγ = Φ(γ) − γ their changes, w_i the weight of a momentum, and ε_i the rms emittance in the
    /// plane of (q_i, p_i), √(⟨q²⟩⟨p²⟩ − ⟨qp⟩²) of deviations from the mean. Emittances are the same in all units
    /// and canonical scalings of a degree of freedom. (In a plane in which the loop winds round a period ⟨qp⟩ is left
    /// out: p may be a function of q there.) For an oscillation of frequency ω, θ = 2 sin(hω/2), the spectral
    /// radius of DΦ − 1; for a translation, a free flight or a kick alone it is 0.
    pub phase_advance: f64,
    /// By how much the ratio of the range of q to the range of p differs from the ratio that the step suggests, in the degree
    /// of freedom where they differ most: √((Δq/q) / (Δp/p)) or its inverse, with the ranges of the loop and of its changes.
    /// 1 for balanced radii; 0 if it is not known.
    #[serde(default)]
    pub imbalance: f64,
    /// Whether the step leaves all positions, or all momenta, in their places against each other: a kick alone, or a
    /// free flight, to the last bits.
    pub shear: bool,
}

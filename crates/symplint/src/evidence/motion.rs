//! How one step moves a loop.

use serde::{Deserialize, Serialize};

use super::{LoopEvidence, StepEvidence};
use crate::signal::SIGNIFICANT;

/// A step that advances the motions on its loops by less than this, in radians, tests nothing. The defect of a method of
/// order 4 has to stand clear of the bound on the defect, too: [`defect_of_order_4`]. Methods of order 8 and more need
/// steps of a radian to show one; the findings tell θ.
pub(crate) const MIN_PHASE_ADVANCE: f64 = 0.05;

/// A kick or a free flight alone, or a Jacobian, that deforms a loop, or tangent vectors, by less than this part of
/// their size tests nothing. Calibrated on the truth table: explicit midpoint and Heun steps of all its systems show
/// a defect from 0.2 on.
pub(crate) const MIN_DEFORMATION: f64 = 0.2;

/// Changes below this part of the values may be rounding errors of the map alone. Conventional: four digits more than one rounding.
pub(crate) const MAX_ROUNDING_CHANGE: f64 = 1e-12;

/// Motions that grow by no more than this factor do not depend on the step size, which is at least four times as large.
/// Conventional.
const MAX_GROWTH_WITHOUT_STEP_SIZE: f64 = 2.0;

/// The defect of Runge and Kutta's method of order 4 on a harmonic oscillator, |R(iθ)|² − 1 = −θ^6/72 + ….
pub(crate) fn defect_of_order_4(phase_advance: f64) -> f64 {
    phase_advance.powi(6) / 72.0
}

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
    /// free flight, to the rounding of the map. `false` if all changes may be rounding.
    pub shear: bool,
    /// Whether any state moves at all.
    #[serde(default)]
    pub moves: bool,
}

impl Motion {
    /// Whether all changes may be rounding errors.
    pub(crate) fn is_rounding(&self) -> bool {
        !self.shear && self.deformation < MAX_ROUNDING_CHANGE
    }

    /// Whether a method that is not symplectic would show a defect above this bound.
    pub(crate) fn tests(&self, bound: f64) -> bool {
        match self.shear {
            true => self.deformation >= MIN_DEFORMATION,
            false => {
                self.phase_advance >= MIN_PHASE_ADVANCE
                    && defect_of_order_4(self.phase_advance) >= bound
            }
        }
    }

    /// The strongest motion of the loops that count, and the step size that makes it, if it is known. Of shears, the
    /// one that deforms its loop most.
    pub(crate) fn strongest(loops: &[LoopEvidence]) -> Option<(Motion, Option<f64>)> {
        // Loops that wind, or bound no defect, do not count, unless there are no others.
        let counts = |found: &&LoopEvidence| !found.winds && found.is_bounded();
        let counted: Vec<&LoopEvidence> = loops.iter().filter(counts).collect();
        match counted.is_empty() {
            true => Self::strongest_of(&loops.iter().collect::<Vec<_>>()),
            false => Self::strongest_of(&counted),
        }
    }

    /// The strongest motion of all these loops, and the step size that makes it.
    pub(crate) fn strongest_of(loops: &[&LoopEvidence]) -> Option<(Motion, Option<f64>)> {
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
}

/// A random loop after a larger step, or a larger one for a map without a step size: it is measured if no other loop
/// moves enough to show the defect of an accurate method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Reach {
    /// The step size, or the radii of the loop, are this number of times the largest ones of the other loops.
    pub factor: f64,
    /// The result of the step: it is resolved, and has no breaks.
    pub step: StepEvidence,
}

impl Reach {
    /// Of a step that is resolved and has no breaks.
    pub(crate) fn of(factor: f64, step: StepEvidence) -> Option<Self> {
        let conserved = step.is_bounded() && !step.is_unexplained();
        let resolved = step.is_significant() || conserved && !step.misses_the_grid();
        (resolved && step.jump.is_none()).then_some(Reach { factor, step })
    }

    /// Whether the loop integral changes.
    pub fn shows_defect(&self) -> bool {
        self.step.is_significant()
    }

    /// Whether the larger step moves the loop enough to show a defect above its bound; or is a kick or a free flight alone, as
    /// this motion is; or moves no more than this: then the map is not an approximation that gets worse with h.
    pub(crate) fn settles(&self, motion: Motion) -> bool {
        let shows = |moved: Motion| match moved.shear {
            true => moved.deformation >= MIN_DEFORMATION,
            false => defect_of_order_4(moved.phase_advance) >= SIGNIFICANT * self.step.bound(),
        };
        (self.step.motion).is_some_and(|moved| {
            shows(moved) || motion.shear && moved.shear || !self.is_further(motion)
        })
    }

    /// Whether the loop moves more than by this motion.
    pub(crate) fn is_further(&self, motion: Motion) -> bool {
        let far = |moved: f64, before: f64| moved > MAX_GROWTH_WITHOUT_STEP_SIZE * before;
        (self.step.motion).is_none_or(|moved| match (motion.shear, moved.shear) {
            (true, true) => far(moved.deformation, motion.deformation),
            (false, true) => true,
            _ => far(moved.phase_advance, motion.phase_advance),
        })
    }
}

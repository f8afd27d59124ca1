//! A planet.

use symplint::state::{Rows, RowsMut};

use crate::error::ModelError;
use crate::hamiltonian::Separable;
use crate::tangent::DriftKickTangent;

/// The Kepler problem in the plane, H = |p|²/2 − μ/√(|q|² + ε²) (HLW, section I.2, for μ = 1 and
/// ε = 0).
///
/// Two degrees of freedom. Energy and angular momentum q_1 p_2 − q_2 p_1 are conserved. Without
/// the softening ε a collision gives states that are not finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kepler {
    mu: f64,
    softening: f64,
}

impl Kepler {
    /// Attraction of strength `mu`, softened at the distance `softening`; 0 for none.
    ///
    /// # Errors
    /// If a parameter is not finite, or the softening is negative.
    pub fn new(mu: f64, softening: f64) -> Result<Self, ModelError> {
        ModelError::check_finite("mu of the Kepler problem", mu)?;
        if !(softening.is_finite() && softening >= 0.0) {
            return Err(ModelError::OutOfRange {
                what: "the softening of the Kepler problem",
                value: softening,
                remedy: "give a finite number that is not negative",
            });
        }
        Ok(Kepler { mu, softening })
    }

    /// √(|q|² + ε²).
    fn distance(&self, x: f64, y: f64) -> f64 {
        (x * x + y * y + self.softening * self.softening).sqrt()
    }
}

impl Separable for Kepler {
    fn dof(&self) -> usize {
        2
    }

    fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>) {
        let (x, y) = (q.row(0), q.row(1));
        for (i, own) in [x, y].into_iter().enumerate() {
            for (((p, own), x), y) in p.row_mut(i).iter_mut().zip(own).zip(x).zip(y) {
                let distance = self.distance(*x, *y);
                *p -= tau * self.mu * own / (distance * distance * distance);
            }
        }
    }

    fn potential_energy(&self, q: Rows<'_>, out: &mut [f64]) {
        for ((out, x), y) in out.iter_mut().zip(q.row(0)).zip(q.row(1)) {
            *out = -self.mu / self.distance(*x, *y);
        }
    }

    fn tangent(&self) -> Option<&dyn DriftKickTangent> {
        Some(self)
    }
}

impl DriftKickTangent for Kepler {
    fn kick_tangent(&self, tau: f64, q: Rows<'_>, dq: Rows<'_>, dp: &mut RowsMut<'_>) {
        for k in 0..q.len() {
            let (x, y) = (q.row(0)[k], q.row(1)[k]);
            let (dx, dy) = (dq.row(0)[k], dq.row(1)[k]);
            let distance = self.distance(x, y);
            let pull = tau * self.mu / (distance * distance * distance);
            // Of q/r³ with r dr = q·dq.
            let stretch = 3.0 * (x * dx + y * dy) / (distance * distance);
            dp.row_mut(0)[k] -= pull * (dx - stretch * x);
            dp.row_mut(1)[k] -= pull * (dy - stretch * y);
        }
    }
}

//! A planet.

use symplint::{Rows, RowsMut};

use crate::error::ModelError;
use crate::hamiltonian::Separable;

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
}

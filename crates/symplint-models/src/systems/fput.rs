//! The springs of Fermi, Pasta, Ulam and Tsingou.

use super::chain::Bond;
use crate::error::ModelError;

/// A spring with a quadratic and a cubic term in its force: φ = r²/2 + α r³/3 + β r⁴/4 (E. Fermi, J.
/// Pasta & S. Ulam, "Studies of nonlinear problems", Los Alamos report LA-1940 (1955)).
///
/// With α ≠ 0 and β = 0 large elongations break it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FputBond {
    alpha: f64,
    beta: f64,
}

impl FputBond {
    /// A spring with the given terms.
    ///
    /// # Errors
    /// If α or β is not finite.
    pub fn new(alpha: f64, beta: f64) -> Result<Self, ModelError> {
        ModelError::check_finite("alpha of the chain", alpha)?;
        ModelError::check_finite("beta of the chain", beta)?;
        Ok(FputBond { alpha, beta })
    }
}

impl Bond for FputBond {
    fn energy(&self, r: f64) -> f64 {
        r * r * (0.5 + r * (self.alpha / 3.0 + r * self.beta / 4.0))
    }

    fn tension(&self, r: f64) -> f64 {
        r * (1.0 + r * (self.alpha + r * self.beta))
    }

    fn stiffness(&self, r: f64) -> f64 {
        1.0 + r * (2.0 * self.alpha + 3.0 * r * self.beta)
    }
}

//! Springs that do not know of each other.

use symplint::state::{Rows, RowsMut};

use crate::error::ModelError;
use crate::hamiltonian::Separable;
use crate::tangent::DriftKickTangent;

/// Independent harmonic oscillators of unit mass: H = ½ Σ (p_i² + ω_i² q_i²).
///
/// The flow is known: each degree of freedom turns at its angular frequency ω_i.
#[derive(Clone, Debug, PartialEq)]
pub struct HarmonicOscillator {
    frequencies: Vec<f64>,
}

impl HarmonicOscillator {
    /// One oscillator for each angular frequency; 0 is a free particle.
    ///
    /// # Errors
    /// If the list of frequencies is empty, or the square of a frequency is not finite.
    pub fn new(frequencies: Vec<f64>) -> Result<Self, ModelError> {
        if frequencies.is_empty() {
            return Err(ModelError::Empty {
                system: "a set",
                parts: "oscillators",
            });
        }
        for &value in &frequencies {
            if !(value * value).is_finite() {
                return Err(ModelError::OutOfRange {
                    what: "a frequency of the harmonic oscillator",
                    value,
                    remedy: "give a number whose square is finite",
                });
            }
        }
        Ok(HarmonicOscillator { frequencies })
    }

    /// The angular frequencies ω_i.
    pub fn frequencies(&self) -> &[f64] {
        &self.frequencies
    }
}

impl Separable for HarmonicOscillator {
    fn dof(&self) -> usize {
        self.frequencies.len()
    }

    fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>) {
        for (i, frequency) in self.frequencies.iter().enumerate() {
            let pull = tau * frequency * frequency;
            for (p, q) in p.row_mut(i).iter_mut().zip(q.row(i)) {
                *p -= pull * q;
            }
        }
    }

    fn potential_energy(&self, q: Rows<'_>, out: &mut [f64]) {
        out.fill(0.0);
        for (i, frequency) in self.frequencies.iter().enumerate() {
            for (out, q) in out.iter_mut().zip(q.row(i)) {
                *out += 0.5 * (frequency * q).powi(2);
            }
        }
    }

    fn tangent(&self) -> Option<&dyn DriftKickTangent> {
        Some(self)
    }
}

impl DriftKickTangent for HarmonicOscillator {
    fn kick_tangent(&self, tau: f64, _q: Rows<'_>, dq: Rows<'_>, dp: &mut RowsMut<'_>) {
        // The force is linear.
        self.kick(tau, dq, dp);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequencies_are_checked() {
        for frequencies in [vec![], vec![f64::NAN], vec![1.0, 1e200]] {
            assert!(HarmonicOscillator::new(frequencies).is_err());
        }
    }
}

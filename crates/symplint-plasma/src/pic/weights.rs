//! Weights of particles.

use symplint_models::ModelError;

/// How much charge, and as much mass, each particle carries.
#[derive(Clone, Debug, PartialEq)]
pub enum ParticleWeights {
    /// The same for all `particles`, so that their density in the box is `density`: n_0 L^D / N_p.
    Equal {
        /// N_p.
        particles: usize,
        /// n_0.
        density: f64,
    },
    /// One for each particle.
    Each(Vec<f64>),
}

impl ParticleWeights {
    /// The weight of every particle in a box of the given volume.
    ///
    /// # Errors
    /// If the number of particles is 0, a weight or the density is zero or not finite, or the sum of the weights is not finite.
    pub(crate) fn of_box(self, volume: f64) -> Result<Vec<f64>, ModelError> {
        let weights = match self {
            ParticleWeights::Each(weights) => weights,
            ParticleWeights::Equal { particles, density } => {
                let share = volume / particles.max(1) as f64;
                check_not_zero("the density of the particles", density)?;
                vec![density * share; particles]
            }
        };
        if weights.is_empty() {
            return Err(ModelError::Empty {
                system: "a plasma",
                parts: "particles",
            });
        }
        for &weight in &weights {
            check_not_zero("the weight of a particle", weight)?;
        }
        let total: f64 = weights.iter().sum();
        ModelError::check_finite("the total weight of the particles", total)?;
        Ok(weights)
    }
}

fn check_not_zero(what: &'static str, value: f64) -> Result<(), ModelError> {
    if value.is_finite() && value != 0.0 {
        return Ok(());
    }
    Err(ModelError::OutOfRange {
        what,
        value,
        remedy: "give a finite number other than 0",
    })
}

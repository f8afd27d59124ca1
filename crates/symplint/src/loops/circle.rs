//! Circles in the (q_i, p_i) planes: the loop of the paper.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::Loop;
use super::turn::sin_cos_turn;
use crate::error::Error;
use crate::signal::unit;
use crate::state::Block;
use crate::state::scratch;

/// q_i = q0_i + r_i sin 2π(s + φ_i), p_i = p0_i + r_i cos 2π(s + φ_i).
///
/// With one radius and no phases it is the loop of Barham & Burby, section 4: every degree of
/// freedom runs the same circle round its own centre, and ∮ p·dq = π Σ r_i².
///
/// ```
/// use symplint::{Circle, Ensemble, LoopIntegral, Rule};
///
/// let circle = Circle::new(vec![3.0, -1.0], vec![0.5, 0.0], 0.1)?;
/// let ensemble = Ensemble::sample(&circle, 64)?;
/// let integral = LoopIntegral::of(&ensemble, &Rule::Pseudospectral)?;
/// assert!((integral.value - 2.0 * std::f64::consts::PI * 0.01).abs() < 1e-15);
/// # Ok::<(), symplint::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Circle {
    q0: Vec<f64>,
    p0: Vec<f64>,
    radii: Vec<f64>,
    /// (sin 2πφ_i, cos 2πφ_i), none where all phases are zero.
    phases: Option<Vec<(f64, f64)>>,
}

impl Circle {
    /// The same circle of radius `radius` round (q0_i, p0_i) in every degree of freedom.
    ///
    /// # Errors
    /// If `q0` and `p0` differ in length, a centre is not finite, or the radius is not
    /// positive and finite.
    pub fn new(q0: Vec<f64>, p0: Vec<f64>, radius: f64) -> Result<Self, Error> {
        Error::check_length("centre p0", q0.len(), p0.len())?;
        check_centre("q", &q0)?;
        check_centre("p", &p0)?;
        if !(radius.is_finite() && radius > 0.0) {
            return Err(Error::OutOfRange {
                what: "radius of the loop",
                value: radius,
                remedy: "give a positive finite radius",
            });
        }
        Ok(Circle {
            radii: vec![radius; q0.len()],
            q0,
            p0,
            phases: None,
        })
    }

    /// Keeps the circle on the degrees of freedom named; the others stay at their centres.
    ///
    /// # Errors
    /// If one does not exist or none is named.
    pub fn on(mut self, dofs: &[usize]) -> Result<Self, Error> {
        if dofs.is_empty() {
            return Err(Error::OutOfRange {
                what: "number of degrees of freedom that the loop moves",
                value: 0.0,
                remedy: "name one or more",
            });
        }
        let radii = std::mem::replace(&mut self.radii, vec![0.0; self.q0.len()]);
        for &dof in dofs {
            match radii.get(dof) {
                Some(&radius) => self.radii[dof] = radius,
                None => {
                    return Err(Error::NoSuchDof {
                        dof,
                        count: radii.len(),
                    });
                }
            }
        }
        Ok(self)
    }

    /// Starts each degree of freedom at a random phase, so that planes are no longer in step.
    pub fn with_random_phases(mut self, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let phases = self.q0.iter().map(|_| sin_cos_turn(unit(&mut random)));
        self.phases = Some(phases.collect());
        self
    }
}

fn check_centre(coordinate: &'static str, values: &[f64]) -> Result<(), Error> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(dof) => Err(Error::BadCentre {
            coordinate,
            dof,
            value: values[dof],
        }),
    }
}

impl Loop for Circle {
    fn dof(&self) -> usize {
        self.q0.len()
    }

    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        let n = s.len();
        scratch::with_buffer(2 * n, |buffer| {
            let (sin, cos) = buffer.split_at_mut(n);
            for (k, &s) in s.iter().enumerate() {
                (sin[k], cos[k]) = sin_cos_turn(s);
            }
            for i in 0..self.dof() {
                let r = self.radii[i];
                // sin(a + φ) and cos(a + φ) by the addition theorems.
                let (sin_phase, cos_phase) = self.phases.as_ref().map_or((0.0, 1.0), |f| f[i]);
                let (along, across) = (r * cos_phase, r * sin_phase);
                let q = block.q.row_mut(i);
                for k in 0..n {
                    q[k] = self.q0[i] + (along * sin[k] + across * cos[k]);
                }
                let p = block.p.row_mut(i);
                for k in 0..n {
                    p[k] = self.p0[i] + (along * cos[k] - across * sin[k]);
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rules::{LoopIntegral, Rule};
    use crate::state::Ensemble;
    use std::f64::consts::PI;

    #[test]
    fn chosen_degrees_of_freedom_move_and_the_others_rest() {
        let circle = Circle::new(vec![1.0, 2.0, 3.0], vec![0.0; 3], 0.5)
            .and_then(|circle| circle.on(&[1]))
            .unwrap();
        let ensemble = Ensemble::sample(&circle, 32).unwrap();
        assert!(ensemble.q().row(0).iter().all(|&q| q == 1.0));
        assert!(ensemble.p().row(2).iter().all(|&p| p == 0.0));
        let integral = LoopIntegral::of(&ensemble, &Rule::Pseudospectral).unwrap();
        assert!((integral.value - PI * 0.25).abs() < 1e-15);
        assert_eq!(integral.contributions[0], 0.0);
    }

    #[test]
    fn phases_keep_the_integral_and_move_the_start() {
        let circle = Circle::new(vec![0.0; 5], vec![0.0; 5], 1.0)
            .unwrap()
            .with_random_phases(7);
        let ensemble = Ensemble::sample(&circle, 32).unwrap();
        assert!(ensemble.q().row(0)[0] != ensemble.q().row(1)[0]);
        let integral = LoopIntegral::of(&ensemble, &Rule::Pseudospectral).unwrap();
        for contribution in &integral.contributions {
            assert!((contribution - PI).abs() < 3e-15);
        }
    }

    #[test]
    fn a_radius_or_centre_that_means_nothing_is_refused() {
        assert!(Circle::new(vec![0.0], vec![0.0], -1.0).is_err());
        assert!(Circle::new(vec![0.0], vec![0.0, 1.0], 1.0).is_err());
        assert!(Circle::new(vec![f64::NAN], vec![0.0], 1.0).is_err());
        let circle = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
        assert_eq!(
            circle.on(&[1]).unwrap_err(),
            Error::NoSuchDof { dof: 1, count: 1 }
        );
    }
}

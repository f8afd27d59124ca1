//! Pendula in a ring, coupled by springs.

use symplint::{Rows, RowsMut};

use crate::error::ModelError;
use crate::hamiltonian::Separable;
use crate::random::Uniform;
use crate::tangent::DriftKickTangent;

/// A ring of N pendula, each coupled to its two neighbours by springs:
/// H = ½ |p|² + α Σ cos q_i + ½ k Σ (q_{i+1} − q_i)², the last neighbouring the first
/// (Barham & Burby, section 4.4, where the last sum is written qᵀLq).
///
/// The force on pendulum i is α sin q_i + k (q_{i+1} − 2 q_i + q_{i−1}). A single pendulum is its
/// own neighbour and feels no spring; two are coupled by two springs. No position is periodic by
/// itself: springs tell turns apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PendulumArray {
    pendula: usize,
    alpha: f64,
    k: f64,
}

impl PendulumArray {
    /// A ring of `pendula` pendula of strength `alpha`, with springs of stiffness `k`.
    ///
    /// # Errors
    /// If there is no pendulum, or `alpha` or `k` is not finite.
    pub fn new(pendula: usize, alpha: f64, k: f64) -> Result<Self, ModelError> {
        if pendula == 0 {
            return Err(ModelError::Empty {
                system: "an array",
                parts: "pendula",
            });
        }
        ModelError::check_finite("alpha of the pendulum array", alpha)?;
        ModelError::check_finite("k of the pendulum array", k)?;
        Ok(PendulumArray { pendula, alpha, k })
    }

    /// Positions, then momenta, drawn uniformly from [0, 1), as in Barham & Burby, section 4.4.
    ///
    /// N values each; the same seed gives the same bits everywhere.
    pub fn uniform_state(&self, seed: u64) -> (Vec<f64>, Vec<f64>) {
        let mut uniform = Uniform::from_seed(seed);
        let q = uniform.by_ref().take(self.pendula).collect();
        let p = uniform.take(self.pendula).collect();
        (q, p)
    }

    /// The neighbours i − 1 and i + 1 of pendulum i round the ring.
    fn neighbours(&self, i: usize) -> (usize, usize) {
        let last = self.pendula - 1;
        (
            if i == 0 { last } else { i - 1 },
            if i == last { 0 } else { i + 1 },
        )
    }
}

impl Separable for PendulumArray {
    fn dof(&self) -> usize {
        self.pendula
    }

    fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>) {
        let (pull, spring) = (tau * self.alpha, tau * self.k);
        for i in 0..self.pendula {
            let (left, right) = self.neighbours(i);
            let neighbours = q.row(left).iter().zip(q.row(right));
            let states = p.row_mut(i).iter_mut().zip(q.row(i));
            for ((p, q), (left, right)) in states.zip(neighbours) {
                *p += pull * q.sin() + spring * ((right - q) - (q - left));
            }
        }
    }

    fn potential_energy(&self, q: Rows<'_>, out: &mut [f64]) {
        out.fill(0.0);
        for i in 0..self.pendula {
            let (_, right) = self.neighbours(i);
            for ((out, q), right) in out.iter_mut().zip(q.row(i)).zip(q.row(right)) {
                *out += self.alpha * q.cos() + 0.5 * self.k * (right - q).powi(2);
            }
        }
    }

    fn tangent(&self) -> Option<&dyn DriftKickTangent> {
        Some(self)
    }
}

impl DriftKickTangent for PendulumArray {
    fn kick_tangent(&self, tau: f64, q: Rows<'_>, dq: Rows<'_>, dp: &mut RowsMut<'_>) {
        let (pull, spring) = (tau * self.alpha, tau * self.k);
        for i in 0..self.pendula {
            let (left, right) = self.neighbours(i);
            let neighbours = dq.row(left).iter().zip(dq.row(right));
            let tangents = dp.row_mut(i).iter_mut().zip(dq.row(i)).zip(q.row(i));
            for (((dp, dq), q), (left, right)) in tangents.zip(neighbours) {
                *dp += pull * q.cos() * dq + spring * ((right - dq) - (dq - left));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The force from the paper's matrix form α sin q − k L q, L dense.
    fn dense_force(array: &PendulumArray, q: &[f64]) -> Vec<f64> {
        let n = q.len();
        let mut laplacian = vec![vec![0.0; n]; n];
        for i in 0..n {
            laplacian[i][i] += 2.0;
            laplacian[i][(i + 1) % n] -= 1.0;
            laplacian[i][(i + n - 1) % n] -= 1.0;
        }
        (0..n)
            .map(|i| {
                let pull: f64 = laplacian[i].iter().zip(q).map(|(l, q)| l * q).sum();
                array.alpha * q[i].sin() - array.k * pull
            })
            .collect()
    }

    #[test]
    fn forces_are_those_of_the_circulant_matrix() {
        for pendula in [1, 2, 3, 8] {
            let array = PendulumArray::new(pendula, 0.7, 1.3).unwrap();
            let (q, mut p) = (array.uniform_state(5).0, vec![0.0; pendula]);
            array.kick(
                1.0,
                Rows::new(&q, pendula, 1, 1),
                &mut RowsMut::new(&mut p, pendula, 1, 1),
            );
            for (got, expected) in p.iter().zip(dense_force(&array, &q)) {
                assert!((got - expected).abs() < 1e-15, "{pendula} pendula");
            }
        }
    }

    #[test]
    fn the_initial_state_depends_on_the_seed_alone() {
        let array = PendulumArray::new(16, 1.0, 1.0).unwrap();
        let (q, p) = array.uniform_state(42);
        assert_eq!((q.len(), p.len()), (16, 16));
        assert_ne!(q, p);
        assert_eq!(array.uniform_state(42), (q.clone(), p));
        assert_ne!(array.uniform_state(43).0, q);
    }

    #[test]
    fn parameters_are_checked() {
        assert!(PendulumArray::new(0, 1.0, 1.0).is_err());
        assert!(PendulumArray::new(3, f64::NAN, 1.0).is_err());
        assert!(PendulumArray::new(3, 1.0, f64::INFINITY).is_err());
    }
}

//! Pendula in a ring, coupled by springs.

use symplint::state::{Rows, RowsMut};

use crate::elementary::{Arithmetic, LANES, LaneMap, Lanes, cos, dispatched, map_lanes, sin};
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
    /// If the number of pendula is 0, or `alpha` or `k` is not finite.
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

    fn ring_kick(&self, tau: f64) -> RingKick {
        RingKick {
            pull: tau * self.alpha,
            spring: tau * self.k,
        }
    }
}

/// The neighbours i − 1 and i + 1 of pendulum i in a ring of `pendula` pendula.
fn neighbours(pendula: usize, i: usize) -> (usize, usize) {
    let last = pendula - 1;
    (
        if i == 0 { last } else { i - 1 },
        if i == last { 0 } else { i + 1 },
    )
}

/// The kick of one pendulum.
struct RingKick {
    pull: f64,
    spring: f64,
}

impl LaneMap<3, 1> for RingKick {
    #[inline(always)]
    fn apply<M: Arithmetic>(
        &self,
        [left, q, right]: [Lanes; 3],
        [mut p]: [Lanes; 1],
    ) -> [Lanes; 1] {
        let sin = sin::<M>(q);
        for k in 0..LANES {
            p[k] += self.pull * sin[k] + self.spring * ((right[k] - q[k]) - (q[k] - left[k]));
        }
        [p]
    }
}

/// Kicks pendulum i.
#[inline(always)]
fn kick_row<M: Arithmetic>(kick: &RingKick, i: usize, q: Rows<'_>, p: &mut RowsMut<'_>) {
    let (left, right) = neighbours(q.count(), i);
    map_lanes::<M, 3, 1>(kick, [left, i, right].map(|i| q.row(i)), [p.row_mut(i)]);
}

dispatched! {
    fn kick_ring<M>(kick: &RingKick, q: Rows<'_>, p: &mut RowsMut<'_>) {
        for i in 0..q.count() {
            kick_row::<M>(kick, i, q, p);
        }
    }
}

/// Lets pendulum i drift.
#[inline(always)]
fn drift_row(tau: f64, i: usize, p: Rows<'_>, q: &mut RowsMut<'_>) {
    for (q, p) in q.row_mut(i).iter_mut().zip(p.row(i)) {
        *q += tau * p;
    }
}

dispatched! {
    /// Drift, kick and drift of three pendula or more in one sweep along the ring, so that only a few
    /// rows are in use at a time: a pendulum is kicked as soon as its right neighbour has drifted,
    /// and drifts on when that neighbour is kicked.
    fn sweep_ring<M>(
        drifts: [f64; 2],
        kick: &RingKick,
        q: &mut RowsMut<'_>,
        p: &mut RowsMut<'_>,
    ) {
        let ([before, after], last) = (drifts, q.count() - 1);
        // Pendulum 0 needs the last one drifted, and is needed by it unchanged until the end.
        for i in [last, 0, 1] {
            drift_row(before, i, p.as_rows(), q);
        }
        for i in 0..=last {
            if (2..last).contains(&(i + 1)) {
                drift_row(before, i + 1, p.as_rows(), q);
            }
            kick_row::<M>(kick, i, q.as_rows(), p);
            if i > 1 {
                drift_row(after, i - 1, p.as_rows(), q);
            }
        }
        for i in [last, 0] {
            drift_row(after, i, p.as_rows(), q);
        }
    }
}

/// What one pendulum and the spring to its right add to the energy.
struct RingEnergy {
    alpha: f64,
    k: f64,
}

impl LaneMap<2, 1> for RingEnergy {
    #[inline(always)]
    fn apply<M: Arithmetic>(&self, [q, right]: [Lanes; 2], [mut out]: [Lanes; 1]) -> [Lanes; 1] {
        let cos = cos::<M>(q);
        for k in 0..LANES {
            out[k] += self.alpha * cos[k] + 0.5 * self.k * (right[k] - q[k]).powi(2);
        }
        [out]
    }
}

dispatched! {
    fn add_ring_energy<M>(energy: &RingEnergy, q: Rows<'_>, out: &mut [f64]) {
        for i in 0..q.count() {
            let (_, right) = neighbours(q.count(), i);
            map_lanes::<M, 2, 1>(energy, [i, right].map(|i| q.row(i)), [&mut *out]);
        }
    }
}

impl Separable for PendulumArray {
    fn dof(&self) -> usize {
        self.pendula
    }

    fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>) {
        kick_ring(&self.ring_kick(tau), q, p);
    }

    fn drift_kick_drift(
        &self,
        [before, tau, after]: [f64; 3],
        q: &mut RowsMut<'_>,
        p: &mut RowsMut<'_>,
    ) {
        if self.pendula < 3 {
            self.drift(before, p.as_rows(), q);
            self.kick(tau, q.as_rows(), p);
            self.drift(after, p.as_rows(), q);
            return;
        }
        sweep_ring([before, after], &self.ring_kick(tau), q, p);
    }

    fn potential_energy(&self, q: Rows<'_>, out: &mut [f64]) {
        let energy = RingEnergy {
            alpha: self.alpha,
            k: self.k,
        };
        out.fill(0.0);
        add_ring_energy(&energy, q, out);
    }

    fn tangent(&self) -> Option<&dyn DriftKickTangent> {
        Some(self)
    }
}

impl DriftKickTangent for PendulumArray {
    fn kick_tangent(&self, tau: f64, q: Rows<'_>, dq: Rows<'_>, dp: &mut RowsMut<'_>) {
        let (pull, spring) = (tau * self.alpha, tau * self.k);
        for i in 0..self.pendula {
            let (left, right) = neighbours(self.pendula, i);
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

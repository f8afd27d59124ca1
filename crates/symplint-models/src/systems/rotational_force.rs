//! A force that no potential has.

use symplint::state::{Rows, RowsMut};

use super::HenonHeiles;
use crate::error::ModelError;
use crate::hamiltonian::{DriftKick, Separable};
use crate::tangent::DriftKickTangent;

/// The Hénon–Heiles system with a further, rotational force: q̇ = p, ṗ = −∇V + κ (−q_2, q_1).
///
/// The turning part has the curl 2κ and no potential, so no energy exists, and a kick by it maps
/// dq ∧ dp to something else: dp_1 ∧ dq_1 + dp_2 ∧ dq_2 gains 2κτ dq_1 ∧ dq_2. Splitting methods
/// can be applied, Störmer–Verlet among them, and none is symplectic; they still conserve volumes.
/// Two degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotationalForce {
    strength: f64,
}

impl RotationalForce {
    /// The system with a turning force of strength κ = `strength`; at 0 it is Hénon–Heiles.
    ///
    /// # Errors
    /// If the strength is not finite.
    pub fn new(strength: f64) -> Result<Self, ModelError> {
        ModelError::check_finite("the strength of the rotational force", strength)?;
        Ok(RotationalForce { strength })
    }

    /// p += τ κ (−q_2, q_1).
    fn turn(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>) {
        let turn = tau * self.strength;
        for (p, y) in p.row_mut(0).iter_mut().zip(q.row(1)) {
            *p -= turn * y;
        }
        for (p, x) in p.row_mut(1).iter_mut().zip(q.row(0)) {
            *p += turn * x;
        }
    }
}

impl DriftKick for RotationalForce {
    fn dof(&self) -> usize {
        2
    }

    fn drift(&self, tau: f64, p: Rows<'_>, q: &mut RowsMut<'_>) {
        Separable::drift(&HenonHeiles, tau, p, q);
    }

    fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>) {
        Separable::kick(&HenonHeiles, tau, q, p);
        self.turn(tau, q, p);
    }

    fn tangent(&self) -> Option<&dyn DriftKickTangent> {
        Some(self)
    }
}

impl DriftKickTangent for RotationalForce {
    fn kick_tangent(&self, tau: f64, q: Rows<'_>, dq: Rows<'_>, dp: &mut RowsMut<'_>) {
        HenonHeiles.kick_tangent(tau, q, dq, dp);
        // The turning part is linear.
        self.turn(tau, dq, dp);
    }
}

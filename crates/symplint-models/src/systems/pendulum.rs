//! The nonlinear pendulum.

use symplint::state::{Rows, RowsMut};

use crate::elementary::{add_cos, add_sin, cos_into, sin_into};
use crate::hamiltonian::Separable;
use crate::tangent::DriftKickTangent;

/// From where the angle of the pendulum is counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PendulumPotential {
    /// V = cos q: stable at q = π, an x-point at q = 0. The figures of Barham & Burby.
    #[default]
    Cos,
    /// V = sin q: stable at q = −π/2. Their text.
    Sin,
}

/// The nonlinear pendulum H = p²/2 + cos q, or + sin q (Barham & Burby, section 3.2).
///
/// One degree of freedom. V has the period 2π; positions are not wrapped into it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pendulum {
    /// The potential V.
    pub potential: PendulumPotential,
}

impl Pendulum {
    /// A pendulum in the given potential.
    pub fn new(potential: PendulumPotential) -> Self {
        Pendulum { potential }
    }
}

impl Separable for Pendulum {
    fn dof(&self) -> usize {
        1
    }

    fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>) {
        match self.potential {
            PendulumPotential::Cos => add_sin(tau, q.row(0), p.row_mut(0)),
            PendulumPotential::Sin => add_cos(-tau, q.row(0), p.row_mut(0)),
        }
    }

    fn potential_energy(&self, q: Rows<'_>, out: &mut [f64]) {
        match self.potential {
            PendulumPotential::Cos => cos_into(q.row(0), out),
            PendulumPotential::Sin => sin_into(q.row(0), out),
        }
    }

    fn tangent(&self) -> Option<&dyn DriftKickTangent> {
        Some(self)
    }
}

impl DriftKickTangent for Pendulum {
    fn kick_tangent(&self, tau: f64, q: Rows<'_>, dq: Rows<'_>, dp: &mut RowsMut<'_>) {
        let tangents = dp.row_mut(0).iter_mut().zip(dq.row(0)).zip(q.row(0));
        match self.potential {
            PendulumPotential::Cos => tangents.for_each(|((dp, dq), q)| *dp += tau * q.cos() * dq),
            PendulumPotential::Sin => tangents.for_each(|((dp, dq), q)| *dp += tau * q.sin() * dq),
        }
    }
}

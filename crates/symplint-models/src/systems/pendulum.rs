//! The nonlinear pendulum.

use symplint::{Rows, RowsMut};

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
        let states = p.row_mut(0).iter_mut().zip(q.row(0));
        match self.potential {
            PendulumPotential::Cos => states.for_each(|(p, q)| *p += tau * q.sin()),
            PendulumPotential::Sin => states.for_each(|(p, q)| *p -= tau * q.cos()),
        }
    }

    fn potential_energy(&self, q: Rows<'_>, out: &mut [f64]) {
        for (out, q) in out.iter_mut().zip(q.row(0)) {
            *out = match self.potential {
                PendulumPotential::Cos => q.cos(),
                PendulumPotential::Sin => q.sin(),
            };
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

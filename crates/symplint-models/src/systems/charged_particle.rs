//! A charge in a magnetic field that grows in one direction.

use symplint::state::{Rows, RowsMut};

use crate::error::ModelError;
use crate::hamiltonian::Hamiltonian;
use crate::tangent::{HamiltonianTangent, PhasePoints, SlopeTangent};

/// A particle of unit mass and charge in the plane, with a magnetic field B = b + g x across it and
/// the electric potential φ = ω² (x² + y²)/2: H = |p − A(q)|²/2 + φ(q) with A = (0, b x + g x²/2).
///
/// Two degrees of freedom, not separable. Momenta are canonical; the velocity is p − A(q). Where
/// ω = 0, p_y is conserved and so is the speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChargedParticle {
    field: f64,
    gradient: f64,
    omega: f64,
}

impl ChargedParticle {
    /// A charge in the field `field` + `gradient` x, bound with the frequency `omega`; 0 for no
    /// electric field.
    ///
    /// # Errors
    /// If a parameter is not finite, or the square of `omega` is not.
    pub fn new(field: f64, gradient: f64, omega: f64) -> Result<Self, ModelError> {
        ModelError::check_finite("the magnetic field", field)?;
        ModelError::check_finite("the gradient of the magnetic field", gradient)?;
        if !(omega * omega).is_finite() {
            return Err(ModelError::OutOfRange {
                what: "omega of the charged particle",
                value: omega,
                remedy: "give a number whose square is finite",
            });
        }
        Ok(ChargedParticle {
            field,
            gradient,
            omega,
        })
    }

    /// B at x.
    pub fn magnetic_field(&self, x: f64) -> f64 {
        self.field + self.gradient * x
    }

    /// ∂B/∂x, the same everywhere.
    pub fn magnetic_gradient(&self) -> f64 {
        self.gradient
    }

    /// A_y at x; A_x vanishes.
    pub fn vector_potential(&self, x: f64) -> f64 {
        x * (self.field + 0.5 * self.gradient * x)
    }

    /// −∇φ at (x, y).
    pub fn electric_field(&self, x: f64, y: f64) -> [f64; 2] {
        let stiffness = self.omega * self.omega;
        [-stiffness * x, -stiffness * y]
    }
}

impl Hamiltonian for ChargedParticle {
    fn dof(&self) -> usize {
        2
    }

    fn energy(&self, q: Rows<'_>, p: Rows<'_>, out: &mut [f64]) {
        for (k, out) in out.iter_mut().enumerate() {
            let (x, y) = (q.row(0)[k], q.row(1)[k]);
            let (vx, vy) = (p.row(0)[k], p.row(1)[k] - self.vector_potential(x));
            let potential = self.omega * self.omega * (x * x + y * y);
            *out = 0.5 * (vx * vx + vy * vy + potential);
        }
    }

    fn add_velocity(&self, tau: f64, q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>) {
        for (out, p) in out.row_mut(0).iter_mut().zip(p.row(0)) {
            *out += tau * p;
        }
        for ((out, p), x) in out.row_mut(1).iter_mut().zip(p.row(1)).zip(q.row(0)) {
            *out += tau * (p - self.vector_potential(*x));
        }
    }

    fn add_force(&self, tau: f64, q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>) {
        let stiffness = self.omega * self.omega;
        for ((out, p), x) in out.row_mut(0).iter_mut().zip(p.row(1)).zip(q.row(0)) {
            let turn = (p - self.vector_potential(*x)) * self.magnetic_field(*x);
            *out += tau * (turn - stiffness * x);
        }
        for (out, y) in out.row_mut(1).iter_mut().zip(q.row(1)) {
            *out -= tau * stiffness * y;
        }
    }

    fn tangent(&self) -> Option<SlopeTangent<'_>> {
        Some(SlopeTangent::General(self))
    }
}

impl HamiltonianTangent for ChargedParticle {
    fn add_velocity_tangent(
        &self,
        tau: f64,
        at: PhasePoints<'_>,
        along: PhasePoints<'_>,
        out: &mut RowsMut<'_>,
    ) {
        for k in 0..at.q.len() {
            let field = self.magnetic_field(at.q.row(0)[k]);
            out.row_mut(0)[k] += tau * along.p.row(0)[k];
            out.row_mut(1)[k] += tau * (along.p.row(1)[k] - field * along.q.row(0)[k]);
        }
    }

    fn add_force_tangent(
        &self,
        tau: f64,
        at: PhasePoints<'_>,
        along: PhasePoints<'_>,
        out: &mut RowsMut<'_>,
    ) {
        let stiffness = self.omega * self.omega;
        for k in 0..at.q.len() {
            let (x, dx) = (at.q.row(0)[k], along.q.row(0)[k]);
            let field = self.magnetic_field(x);
            let vy = at.p.row(1)[k] - self.vector_potential(x);
            let dvy = along.p.row(1)[k] - field * dx;
            let turn = dvy * field + vy * self.gradient * dx;
            out.row_mut(0)[k] += tau * (turn - stiffness * dx);
            out.row_mut(1)[k] -= tau * stiffness * along.q.row(1)[k];
        }
    }
}

//! Derivatives of forces and velocities: how tangent vectors move along with states.
//!
//! The derivatives that a system supplies here make the steps of all integrators [`TangentMap`](symplint::map::TangentMap)s.
//! If a force has jumps or kinks, its derivative is the derivative of the piece in which the state lies.
//!
//! As in [`DriftKick`](crate::DriftKick) and [`Hamiltonian`](crate::Hamiltonian), all methods work on
//! rows: row i holds degree of freedom i of every sample of a block.

use symplint::StepFailure;
use symplint::state::{Rows, RowsMut};

/// The derivatives of drifts and kicks, along tangent vectors (dq, dp).
///
/// ```
/// use symplint::TimeAdvance;
/// use symplint::state::{Rows, RowsMut};
/// use symplint_models::integrators::{Splitting, Variant, splitting_methods};
/// use symplint_models::{DriftKickTangent, Separable};
///
/// /// A stiffening spring, H = p²/2 + q⁴/4.
/// struct Quartic;
///
/// impl Separable for Quartic {
///     fn dof(&self) -> usize {
///         1
///     }
///     fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>) {
///         for (p, q) in p.row_mut(0).iter_mut().zip(q.row(0)) {
///             *p -= tau * q.powi(3);
///         }
///     }
///     fn potential_energy(&self, q: Rows<'_>, out: &mut [f64]) {
///         for (out, q) in out.iter_mut().zip(q.row(0)) {
///             *out = 0.25 * q.powi(4);
///         }
///     }
///     fn tangent(&self) -> Option<&dyn DriftKickTangent> {
///         Some(self)
///     }
/// }
///
/// impl DriftKickTangent for Quartic {
///     fn kick_tangent(&self, tau: f64, q: Rows<'_>, dq: Rows<'_>, dp: &mut RowsMut<'_>) {
///         for ((dp, dq), q) in dp.row_mut(0).iter_mut().zip(dq.row(0)).zip(q.row(0)) {
///             *dp -= tau * 3.0 * q * q * dq;
///         }
///     }
/// }
///
/// let step = Splitting::new(splitting_methods::yoshida4(Variant::PositionFirst), Quartic);
/// assert!(step.capabilities().tangent.is_some());
/// ```
pub trait DriftKickTangent: Send + Sync {
    /// The derivative of a drift for a time `tau`: dq += τ v'(p) dp. By default v = p.
    fn drift_tangent(&self, tau: f64, p: Rows<'_>, dp: Rows<'_>, dq: &mut RowsMut<'_>) {
        let _ = p;
        for i in 0..dp.count() {
            for (dq, dp) in dq.row_mut(i).iter_mut().zip(dp.row(i)) {
                *dq += tau * dp;
            }
        }
    }

    /// The derivative of a kick for a time `tau`: dp += τ F'(q) dq, which is dp −= τ V''(q) dq for a
    /// force with a potential.
    fn kick_tangent(&self, tau: f64, q: Rows<'_>, dq: Rows<'_>, dp: &mut RowsMut<'_>);
}

/// The derivatives of velocity and force of a Hamiltonian, along tangent vectors (dq, dp).
pub trait HamiltonianTangent: Send + Sync {
    /// Adds changes of the velocity: `out` += τ (∂²H/∂p∂q dq + ∂²H/∂p² dp).
    fn add_velocity_tangent(
        &self,
        tau: f64,
        at: PhasePoints<'_>,
        along: PhasePoints<'_>,
        out: &mut RowsMut<'_>,
    );

    /// Adds changes of the force: `out` −= τ (∂²H/∂q² dq + ∂²H/∂q∂p dp).
    fn add_force_tangent(
        &self,
        tau: f64,
        at: PhasePoints<'_>,
        along: PhasePoints<'_>,
        out: &mut RowsMut<'_>,
    );
}

/// Positions and momenta of a block, or the components of its tangent vectors along them.
#[derive(Clone, Copy)]
pub struct PhasePoints<'a> {
    /// Positions, d rows.
    pub q: Rows<'a>,
    /// Momenta, d rows.
    pub p: Rows<'a>,
}

/// Why a step has no tangent map, though its type has.
pub(crate) fn no_tangent() -> StepFailure {
    StepFailure {
        sample: 0,
        reason: "the system supplies no derivative of its force; ask `tangent` of the map first"
            .into(),
    }
}

/// The derivatives that a [`Hamiltonian`](crate::Hamiltonian) has, of either kind.
#[derive(Clone, Copy)]
pub enum SlopeTangent<'a> {
    /// Velocities depend on momenta only and forces on positions only.
    Separable(&'a dyn DriftKickTangent),
    /// Both on both.
    General(&'a dyn HamiltonianTangent),
}

impl SlopeTangent<'_> {
    /// Adds changes of the velocity, as [`HamiltonianTangent::add_velocity_tangent`].
    pub fn add_velocity(
        &self,
        tau: f64,
        at: PhasePoints<'_>,
        along: PhasePoints<'_>,
        out: &mut RowsMut<'_>,
    ) {
        match self {
            SlopeTangent::Separable(system) => system.drift_tangent(tau, at.p, along.p, out),
            SlopeTangent::General(system) => system.add_velocity_tangent(tau, at, along, out),
        }
    }

    /// Adds changes of the force, as [`HamiltonianTangent::add_force_tangent`].
    pub fn add_force(
        &self,
        tau: f64,
        at: PhasePoints<'_>,
        along: PhasePoints<'_>,
        out: &mut RowsMut<'_>,
    ) {
        match self {
            SlopeTangent::Separable(system) => system.kick_tangent(tau, at.q, along.q, out),
            SlopeTangent::General(system) => system.add_force_tangent(tau, at, along, out),
        }
    }
}

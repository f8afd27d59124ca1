//! Hamiltonians as the integrators see them: forces and velocities on blocks of samples.
//!
//! All methods work on rows: row i holds degree of freedom i of every sample of a block.
//! Rows of one call have the same length; methods panic where they do not.

use std::sync::Arc;

use multiversion::multiversion;
use symplint::Coordinates;
use symplint::state::{Rows, RowsMut, scratch};

use crate::tangent::{DriftKickTangent, SlopeTangent};

/// A separable Hamiltonian H(q, p) = T(p) + V(q), whose two parts have exact flows.
///
/// A system with T = |p|²/2 supplies [`dof`](Self::dof), [`kick`](Self::kick) and
/// [`potential_energy`](Self::potential_energy).
pub trait Separable: Send + Sync {
    /// Degrees of freedom d.
    fn dof(&self) -> usize;

    /// The exact flow of T for a time `tau`: q += τ ∂T/∂p. By default T = |p|²/2.
    fn drift(&self, tau: f64, p: Rows<'_>, q: &mut RowsMut<'_>) {
        add_multiple(tau, p, q);
    }

    /// The exact flow of V for a time `tau`: p −= τ ∂V/∂q.
    fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>);

    /// A drift, a kick and a drift for the times `taus`, to the last bit as one after the other. By
    /// default it is just that; a system whose forces are local can do it in one pass over memory.
    fn drift_kick_drift(&self, taus: [f64; 3], q: &mut RowsMut<'_>, p: &mut RowsMut<'_>) {
        self.drift(taus[0], p.as_rows(), q);
        self.kick(taus[1], q.as_rows(), p);
        self.drift(taus[2], p.as_rows(), q);
    }

    /// Writes T of every sample into `out`. By default T = |p|²/2.
    fn kinetic_energy(&self, p: Rows<'_>, out: &mut [f64]) {
        out.fill(0.0);
        for i in 0..p.count() {
            for (out, p) in out.iter_mut().zip(p.row(i)) {
                *out += 0.5 * p * p;
            }
        }
    }

    /// Writes V of every sample into `out`.
    fn potential_energy(&self, q: Rows<'_>, out: &mut [f64]);

    /// Which positions are periodic, and what makes momenta canonical. By default nothing is
    /// periodic and p is canonical without a weight.
    fn coordinates(&self) -> Coordinates {
        Coordinates::plain(self.dof())
    }

    /// The derivatives of drifts and kicks, if the system supplies them. By default it does not.
    fn tangent(&self) -> Option<&dyn DriftKickTangent> {
        None
    }
}

/// Drifts q += τ v(p) and kicks p += τ F(q), whether or not F is the gradient of an energy.
///
/// Every [`Separable`] system is one of these, with v = ∂T/∂p and F = −∂V/∂q. Implement it for a
/// force that has no potential: no energy exists then, and a kick is not symplectic. Import only
/// the trait that is meant, as both have the same methods.
pub trait DriftKick: Send + Sync {
    /// Degrees of freedom d.
    fn dof(&self) -> usize;

    /// Positions move with their velocities for a time `tau`: q += τ v(p).
    fn drift(&self, tau: f64, p: Rows<'_>, q: &mut RowsMut<'_>);

    /// Momenta follow the force for a time `tau`: p += τ F(q).
    fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>);

    /// A drift, a kick and a drift for the times `taus`, to the last bit as one after the other. By
    /// default it is just that; a system whose forces are local can do it in one pass over memory.
    fn drift_kick_drift(&self, taus: [f64; 3], q: &mut RowsMut<'_>, p: &mut RowsMut<'_>) {
        self.drift(taus[0], p.as_rows(), q);
        self.kick(taus[1], q.as_rows(), p);
        self.drift(taus[2], p.as_rows(), q);
    }

    /// Which positions are periodic, and what makes momenta canonical. By default nothing is
    /// periodic and p is canonical without a weight.
    fn coordinates(&self) -> Coordinates {
        Coordinates::plain(self.dof())
    }

    /// The derivatives of drifts and kicks, if the system supplies them. By default it does not.
    fn tangent(&self) -> Option<&dyn DriftKickTangent> {
        None
    }
}

/// out += factor × rows.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn add_multiple(factor: f64, rows: Rows<'_>, out: &mut RowsMut<'_>) {
    let add = |out: &mut [f64], row: &[f64]| {
        for (out, value) in out.iter_mut().zip(row) {
            *out += factor * value;
        }
    };
    // A row has one value if there is one sample: they are taken all at once.
    if let (Some(out), Some(rows)) = (out.as_mut_slice(), rows.as_slice()) {
        assert_eq!(out.len(), rows.len(), "both have the same shape");
        return add(out, rows);
    }
    for i in 0..rows.count() {
        add(out.row_mut(i), rows.row(i));
    }
}

impl<S: Separable + ?Sized> DriftKick for S {
    fn dof(&self) -> usize {
        Separable::dof(self)
    }

    fn drift(&self, tau: f64, p: Rows<'_>, q: &mut RowsMut<'_>) {
        Separable::drift(self, tau, p, q);
    }

    fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>) {
        Separable::kick(self, tau, q, p);
    }

    fn drift_kick_drift(&self, taus: [f64; 3], q: &mut RowsMut<'_>, p: &mut RowsMut<'_>) {
        Separable::drift_kick_drift(self, taus, q, p);
    }

    fn coordinates(&self) -> Coordinates {
        Separable::coordinates(self)
    }

    fn tangent(&self) -> Option<&dyn DriftKickTangent> {
        Separable::tangent(self)
    }
}

/// Any Hamiltonian H(q, p), separable or not.
///
/// Every [`Separable`] system is one of these; import only the trait that is meant, as both
/// have a `dof` and `coordinates`.
pub trait Hamiltonian: Send + Sync {
    /// Degrees of freedom d.
    fn dof(&self) -> usize;

    /// Writes H of every sample into `out`.
    fn energy(&self, q: Rows<'_>, p: Rows<'_>, out: &mut [f64]);

    /// Adds velocities: `out` += τ ∂H/∂p.
    fn add_velocity(&self, tau: f64, q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>);

    /// Adds forces: `out` −= τ ∂H/∂q.
    fn add_force(&self, tau: f64, q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>);

    /// Which positions are periodic, and what makes momenta canonical. By default nothing is
    /// periodic and p is canonical without a weight.
    fn coordinates(&self) -> Coordinates {
        Coordinates::plain(self.dof())
    }

    /// The derivatives of velocity and force, if the system supplies them. By default it does not.
    fn tangent(&self) -> Option<SlopeTangent<'_>> {
        None
    }
}

impl<S: Separable + ?Sized> Hamiltonian for S {
    fn dof(&self) -> usize {
        Separable::dof(self)
    }

    fn energy(&self, q: Rows<'_>, p: Rows<'_>, out: &mut [f64]) {
        self.kinetic_energy(p, out);
        scratch::with_buffer(out.len(), |potential| {
            self.potential_energy(q, potential);
            for (out, potential) in out.iter_mut().zip(potential) {
                *out += *potential;
            }
        });
    }

    fn add_velocity(&self, tau: f64, _q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>) {
        Separable::drift(self, tau, p, out);
    }

    fn add_force(&self, tau: f64, q: Rows<'_>, _p: Rows<'_>, out: &mut RowsMut<'_>) {
        Separable::kick(self, tau, q, out);
    }

    fn coordinates(&self) -> Coordinates {
        Separable::coordinates(self)
    }

    fn tangent(&self) -> Option<SlopeTangent<'_>> {
        Separable::tangent(self).map(SlopeTangent::Separable)
    }
}

macro_rules! forward_separable {
    ($($pointer:ty),*) => {$(
        impl<S: Separable + ?Sized> Separable for $pointer {
            fn dof(&self) -> usize {
                Separable::dof(&**self)
            }
            fn drift(&self, tau: f64, p: Rows<'_>, q: &mut RowsMut<'_>) {
                Separable::drift(&**self, tau, p, q);
            }
            fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>) {
                Separable::kick(&**self, tau, q, p);
            }
            fn drift_kick_drift(&self, taus: [f64; 3], q: &mut RowsMut<'_>, p: &mut RowsMut<'_>) {
                Separable::drift_kick_drift(&**self, taus, q, p);
            }
            fn kinetic_energy(&self, p: Rows<'_>, out: &mut [f64]) {
                (**self).kinetic_energy(p, out);
            }
            fn potential_energy(&self, q: Rows<'_>, out: &mut [f64]) {
                (**self).potential_energy(q, out);
            }
            fn coordinates(&self) -> Coordinates {
                Separable::coordinates(&**self)
            }
            fn tangent(&self) -> Option<&dyn DriftKickTangent> {
                Separable::tangent(&**self)
            }
        }
    )*};
}
forward_separable!(&S, Box<S>, Arc<S>);

/// Shared systems that are known only as trait objects. (Pointers to a [`Separable`] are
/// covered by being separable.)
impl Hamiltonian for Arc<dyn Hamiltonian> {
    fn dof(&self) -> usize {
        (**self).dof()
    }

    fn energy(&self, q: Rows<'_>, p: Rows<'_>, out: &mut [f64]) {
        (**self).energy(q, p, out);
    }

    fn add_velocity(&self, tau: f64, q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>) {
        (**self).add_velocity(tau, q, p, out);
    }

    fn add_force(&self, tau: f64, q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>) {
        (**self).add_force(tau, q, p, out);
    }

    fn coordinates(&self) -> Coordinates {
        (**self).coordinates()
    }

    fn tangent(&self) -> Option<SlopeTangent<'_>> {
        (**self).tangent()
    }
}

impl DriftKick for Arc<dyn DriftKick> {
    fn dof(&self) -> usize {
        (**self).dof()
    }

    fn drift(&self, tau: f64, p: Rows<'_>, q: &mut RowsMut<'_>) {
        (**self).drift(tau, p, q);
    }

    fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>) {
        (**self).kick(tau, q, p);
    }

    fn drift_kick_drift(&self, taus: [f64; 3], q: &mut RowsMut<'_>, p: &mut RowsMut<'_>) {
        (**self).drift_kick_drift(taus, q, p);
    }

    fn coordinates(&self) -> Coordinates {
        (**self).coordinates()
    }

    fn tangent(&self) -> Option<&dyn DriftKickTangent> {
        (**self).tangent()
    }
}

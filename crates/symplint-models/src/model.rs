//! A system of any kind, as integrators are chosen for it.

use std::sync::Arc;

use symplint::TimeAdvance;

use crate::hamiltonian::{DriftKick, Hamiltonian, Separable};
use crate::split_hamiltonian::SplitHamiltonian;
use crate::systems::ChargedParticle;

/// A system of one of the kinds there are. The kind says which integrators can advance it.
#[derive(Clone)]
pub enum Model {
    /// H = T(p) + V(q): every integrator but Boris.
    Separable(Arc<dyn Separable>),
    /// H(q, p): Runge–Kutta methods, explicit and implicit.
    General(Arc<dyn Hamiltonian>),
    /// H = H_0 + … + H_n−1, each part with an exact flow: splitting methods, and what `General` has.
    Split(Arc<dyn SplitHamiltonian>),
    /// A force without a potential: splitting methods.
    Forced(Arc<dyn DriftKick>),
    /// A charge in a magnetic field: what `General` has, and Boris.
    Charged(ChargedParticle),
    /// A map that is given directly, with nothing to integrate.
    Map(Arc<dyn TimeAdvance>),
}

impl Model {
    /// Degrees of freedom d.
    pub fn dof(&self) -> usize {
        match self {
            Model::Separable(system) => Separable::dof(system),
            Model::General(system) => Hamiltonian::dof(system),
            Model::Split(system) => Hamiltonian::dof(system),
            Model::Forced(system) => DriftKick::dof(system),
            Model::Charged(system) => Hamiltonian::dof(system),
            Model::Map(map) => map.dof(),
        }
    }

    /// The Hamiltonian, if there is one that is known.
    pub fn hamiltonian(&self) -> Option<&dyn Hamiltonian> {
        match self {
            Model::Separable(system) => Some(system),
            Model::General(system) => Some(system),
            Model::Split(system) => Some(system),
            Model::Charged(system) => Some(system),
            Model::Forced(_) | Model::Map(_) => None,
        }
    }

    /// What kind of system it is, in words that complete "this is …".
    pub fn kind(&self) -> &'static str {
        match self {
            Model::Separable(_) => "a separable Hamiltonian",
            Model::General(_) => "a Hamiltonian that is not separable",
            Model::Split(system) => system.kind(),
            Model::Forced(_) => "a force without a potential",
            Model::Charged(_) => "a charge in a magnetic field",
            Model::Map(_) => "a map, with nothing to integrate",
        }
    }
}

impl From<Arc<dyn Separable>> for Model {
    fn from(system: Arc<dyn Separable>) -> Self {
        Model::Separable(system)
    }
}

impl<S: Separable + 'static> From<Arc<S>> for Model {
    fn from(system: Arc<S>) -> Self {
        Model::Separable(system)
    }
}

//! The energy of a system that has one.

use symplint::map::Capabilities;
use symplint::{Block, StepFailure, TimeAdvance};
use symplint_models::Model;

/// A step of a system, which also gives its energy.
pub struct WithEnergy<M> {
    pub map: M,
    pub model: Model,
}

impl<M: TimeAdvance> TimeAdvance for WithEnergy<M> {
    fn dof(&self) -> usize {
        self.map.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.map.advance(h, block)
    }

    fn capabilities(&self) -> Capabilities<'_> {
        let inner = self.map.capabilities();
        Capabilities {
            energy: match self.model.hamiltonian() {
                Some(system) => Some(Box::new(|q, p, energies| system.energy(q, p, energies))),
                None => inner.energy,
            },
            ..inner
        }
    }
}

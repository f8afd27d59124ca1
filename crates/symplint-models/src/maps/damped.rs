//! A map with a friction that does not belong there.

use symplint::map::{Capabilities, Parts, Substeps, TangentMap};
use symplint::{Block, StepFailure, TimeAdvance};

use crate::error::ModelError;
use crate::tangent::no_tangent;

/// A map followed by a friction: momenta are multiplied by exp(−γh).
///
/// It shrinks every loop integral of a symplectic map by exp(−γh) exactly, so the defect is
/// 1 − exp(−γh), of order h: conformally symplectic (R. I. McLachlan & M. Perlmutter, "Conformal
/// Hamiltonian systems", J. Geom. Phys. 39 (2001) 276).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DampedMap<M> {
    map: M,
    rate: f64,
}

impl<M: TimeAdvance> DampedMap<M> {
    /// `map`, damped at the rate γ = `rate`; a negative rate drives.
    ///
    /// # Errors
    /// If the rate is not finite.
    pub fn new(map: M, rate: f64) -> Result<Self, ModelError> {
        ModelError::check_finite("the rate of damping", rate)?;
        Ok(DampedMap { map, rate })
    }

    fn damp(&self, h: f64, block: &mut Block<'_>) {
        let factor = (-self.rate * h).exp();
        for i in 0..block.dof() {
            for p in block.p.row_mut(i) {
                *p *= factor;
            }
        }
    }
}

impl<M: TimeAdvance> TimeAdvance for DampedMap<M> {
    fn dof(&self) -> usize {
        self.map.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.map.advance(h, block)?;
        self.damp(h, block);
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        let of_map = self.map.capabilities();
        Capabilities {
            substeps: Some(self),
            tangent: of_map.tangent.map(|_| self as &dyn TangentMap),
            ..of_map.for_another_step()
        }
    }
}

impl<M: TimeAdvance> Substeps for DampedMap<M> {
    fn substeps(&self) -> usize {
        Parts::of(&self.map).count() + 1
    }

    fn advance_substep(
        &self,
        substep: usize,
        h: f64,
        block: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        let parts = Parts::of(&self.map);
        if substep < parts.count() {
            return parts.advance(substep, h, block);
        }
        self.damp(h, block);
        Ok(())
    }

    fn substep_name(&self, substep: usize) -> String {
        let parts = Parts::of(&self.map);
        if substep < parts.count() {
            return parts.name(substep);
        }
        "friction".into()
    }
}

impl<M: TimeAdvance> TangentMap for DampedMap<M> {
    fn advance_tangents(
        &self,
        h: f64,
        states: &mut Block<'_>,
        tangents: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        let of_map = self.map.capabilities().tangent.ok_or_else(no_tangent)?;
        of_map.advance_tangents(h, states, tangents)?;
        self.damp(h, states);
        // The friction is linear.
        self.damp(h, tangents);
        Ok(())
    }
}

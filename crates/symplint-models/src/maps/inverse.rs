//! The inverse of a map.

use symplint::map::Capabilities;
use symplint::{Block, StepFailure, TimeAdvance};

use super::Invertible;

/// The map (Φ_h)^{-1}. It has no tangent map: its Jacobians are central differences.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inverse<M>(pub M);

impl<M: Invertible> TimeAdvance for Inverse<M> {
    fn dof(&self) -> usize {
        self.0.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.0.advance_inverse(h, block)
    }

    fn capabilities(&self) -> Capabilities<'_> {
        self.0.capabilities().for_another_step()
    }
}

impl<M: Invertible> Invertible for Inverse<M> {
    fn advance_inverse(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.0.advance(h, block)
    }
}

//! The adjoint of a map.

use symplint::map::Capabilities;
use symplint::{Block, StepFailure, TimeAdvance};

use super::Invertible;

/// The adjoint map Φ*_h = (Φ_{−h})^{-1} (HLW, section II.3).
///
/// A map that is its own adjoint is called symmetric; its order is even. The adjoint has no tangent map: its
/// Jacobians are central differences.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adjoint<M>(pub M);

impl<M: Invertible> TimeAdvance for Adjoint<M> {
    fn dof(&self) -> usize {
        self.0.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.0.advance_inverse(-h, block)
    }

    fn capabilities(&self) -> Capabilities<'_> {
        self.0.capabilities().for_another_step()
    }
}

impl<M: Invertible> Invertible for Adjoint<M> {
    fn advance_inverse(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.0.advance(-h, block)
    }
}

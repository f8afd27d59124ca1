//! Several steps of one map.

use symplint::map::{Constraint, TangentMap};
use symplint::{Block, Coordinates, StepFailure, TimeAdvance};

use super::Invertible;
use crate::error::ModelError;
use crate::tangent::no_tangent;

/// The map Φ_h ∘ … ∘ Φ_h of n steps of size h each: it advances by a time n h.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repeat<M> {
    map: M,
    steps: usize,
}

impl<M: TimeAdvance> Repeat<M> {
    /// `steps` steps of `map`.
    ///
    /// # Errors
    /// If `steps` is 0.
    pub fn new(map: M, steps: usize) -> Result<Self, ModelError> {
        if steps == 0 {
            return Err(ModelError::NoSteps);
        }
        Ok(Repeat { map, steps })
    }
}

impl<M: TimeAdvance> TimeAdvance for Repeat<M> {
    fn dof(&self) -> usize {
        self.map.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        (0..self.steps).try_for_each(|_| self.map.advance(h, block))
    }

    fn coordinates(&self) -> Coordinates {
        self.map.coordinates()
    }

    fn constraint(&self) -> Option<&dyn Constraint> {
        self.map.constraint()
    }

    fn tangent(&self) -> Option<&dyn TangentMap> {
        self.map.tangent().map(|_| self as &dyn TangentMap)
    }
}

/// The chain rule.
impl<M: TimeAdvance> TangentMap for Repeat<M> {
    fn advance_tangents(
        &self,
        h: f64,
        states: &mut Block<'_>,
        tangents: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        let of_map = self.map.tangent().ok_or_else(no_tangent)?;
        (0..self.steps).try_for_each(|_| of_map.advance_tangents(h, states, tangents))
    }
}

impl<M: Invertible> Invertible for Repeat<M> {
    fn advance_inverse(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        (0..self.steps).try_for_each(|_| self.map.advance_inverse(h, block))
    }
}

//! Several steps of one map.

use super::{Capabilities, Parts, StepFailure, Substeps, TangentMap, TimeAdvance};
use crate::error::Error;
use crate::state::Block;

/// The map Φ_h ∘ … ∘ Φ_h of n steps of size h each: it advances by a time n h.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repeat<M> {
    map: M,
    steps: usize,
}

impl<M> Repeat<M> {
    /// `steps` steps of `map`.
    ///
    /// # Errors
    /// If `steps` is 0.
    pub fn new(map: M, steps: usize) -> Result<Self, Error> {
        match steps {
            0 => Err(Error::OutOfRange {
                what: "number of repetitions",
                value: 0.0,
                remedy: "give 1 or more",
            }),
            _ => Ok(Repeat { map, steps }),
        }
    }

    /// The map that is repeated.
    pub fn map(&self) -> &M {
        &self.map
    }

    /// How many times it is applied.
    pub fn steps(&self) -> usize {
        self.steps
    }
}

impl<M: TimeAdvance> TimeAdvance for Repeat<M> {
    fn dof(&self) -> usize {
        self.map.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        (0..self.steps).try_for_each(|_| self.map.advance(h, block))
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

impl<M: TimeAdvance> Substeps for Repeat<M> {
    fn substeps(&self) -> usize {
        self.steps.saturating_mul(Parts::of(&self.map).count())
    }

    fn advance_substep(
        &self,
        substep: usize,
        h: f64,
        block: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        let parts = Parts::of(&self.map);
        parts.advance(substep % parts.count(), h, block)
    }

    fn substep_name(&self, substep: usize) -> String {
        let parts = Parts::of(&self.map);
        let (step, substep) = (substep / parts.count(), substep % parts.count());
        format!("{} of step {}", parts.name(substep), step + 1)
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
        let of_map = self.map.capabilities().tangent.ok_or_else(|| StepFailure {
            sample: 0,
            reason: "the map has no tangent map".into(),
        })?;
        (0..self.steps).try_for_each(|_| of_map.advance_tangents(h, states, tangents))
    }
}

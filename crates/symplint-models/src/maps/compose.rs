//! Maps one after the other.

use symplint::map::{Capabilities, Parts, Substeps, TangentMap};
use symplint::{Block, StepFailure, TimeAdvance};

use super::Invertible;
use crate::error::ModelError;
use crate::tangent::no_tangent;

/// Maps one after the other, each with its fraction of the step: Φ^n_{c_n h} ∘ … ∘ Φ^1_{c_1 h}.
///
/// Maps of different types go together as `Box<dyn TimeAdvance>` or `Box<dyn Invertible>`.
///
/// ```
/// use symplint_models::integrators::{Splitting, Variant, splitting_methods};
/// use symplint_models::maps::Compose;
/// use symplint_models::systems::Pendulum;
///
/// // The triple jump: three steps of order 2 make one of order 4.
/// let step = Splitting::new(splitting_methods::strang(Variant::PositionFirst), Pendulum::default());
/// let outer = 1.0 / (2.0 - 2.0_f64.cbrt());
/// let jump = Compose::new(vec![(outer, &step), (1.0 - 2.0 * outer, &step), (outer, &step)])?;
/// # Ok::<(), symplint_models::ModelError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Compose<M> {
    parts: Vec<(f64, M)>,
}

impl<M: TimeAdvance> Compose<M> {
    /// The composition of `parts`, pairs of a fraction and a map, the first to be applied first.
    ///
    /// # Errors
    /// If `parts` is empty, a fraction is not finite, or parts differ in their degrees of freedom,
    /// periods or momentum weights.
    pub fn new(parts: Vec<(f64, M)>) -> Result<Self, ModelError> {
        let Some((_, first)) = parts.first() else {
            return Err(ModelError::EmptyComposition);
        };
        let (dof, coordinates) = (first.dof(), first.capabilities().coordinates);
        for (part, (fraction, map)) in parts.iter().enumerate() {
            ModelError::check_finite("the fraction of a composed map", *fraction)?;
            if map.dof() != dof {
                return Err(ModelError::ComposedDof {
                    part,
                    expected: dof,
                    got: map.dof(),
                });
            }
            if map.capabilities().coordinates != coordinates {
                return Err(ModelError::ComposedCoordinates { part });
            }
        }
        Ok(Compose { parts })
    }

    /// The part that a substep belongs to, with its fraction, and which of its substeps it is.
    fn part(&self, substep: usize) -> (f64, &M, usize) {
        let mut before = 0;
        for (fraction, map) in &self.parts {
            let substeps = Parts::of(map).count();
            if substep < before + substeps {
                return (*fraction, map, substep - before);
            }
            before += substeps;
        }
        panic!("substep {substep} of {before}");
    }
}

impl<M: TimeAdvance> TimeAdvance for Compose<M> {
    fn dof(&self) -> usize {
        self.parts[0].1.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.parts
            .iter()
            .try_for_each(|(fraction, map)| map.advance(fraction * h, block))
    }

    fn capabilities(&self) -> Capabilities<'_> {
        let has_tangent = |(_, map): &(f64, M)| map.capabilities().tangent.is_some();
        let each = self.parts.iter().all(has_tangent);
        Capabilities {
            substeps: Some(self),
            tangent: each.then_some(self as &dyn TangentMap),
            ..self.parts[0].1.capabilities().for_another_step()
        }
    }
}

impl<M: TimeAdvance> Substeps for Compose<M> {
    fn substeps(&self) -> usize {
        self.parts
            .iter()
            .map(|(_, map)| Parts::of(map).count())
            .sum()
    }

    fn advance_substep(
        &self,
        substep: usize,
        h: f64,
        block: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        let (fraction, map, substep) = self.part(substep);
        Parts::of(map).advance(substep, fraction * h, block)
    }

    fn substep_name(&self, substep: usize) -> String {
        let (fraction, map, substep) = self.part(substep);
        let name = Parts::of(map).name(substep);
        match fraction {
            1.0 => name,
            _ => format!("{name} with h times {fraction:.4}"),
        }
    }
}

/// The chain rule.
impl<M: TimeAdvance> TangentMap for Compose<M> {
    fn advance_tangents(
        &self,
        h: f64,
        states: &mut Block<'_>,
        tangents: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        self.parts.iter().try_for_each(|(fraction, map)| {
            let of_map = map.capabilities().tangent.ok_or_else(no_tangent)?;
            of_map.advance_tangents(fraction * h, states, tangents)
        })
    }
}

impl<M: Invertible> Invertible for Compose<M> {
    fn advance_inverse(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.parts
            .iter()
            .rev()
            .try_for_each(|(fraction, map)| map.advance_inverse(fraction * h, block))
    }
}

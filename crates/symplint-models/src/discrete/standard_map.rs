//! The kicked rotor.

use std::f64::consts::TAU;

use symplint::map::TangentMap;
use symplint::{Block, Coordinates, StepFailure, TimeAdvance};

use crate::elementary::add_sin;
use crate::error::ModelError;

/// The standard map on the cylinder: p' = p + K h sin q, q' = q + h p' mod 2π (B. V. Chirikov, "A
/// universal instability of many-dimensional oscillator systems", Phys. Rep. 52 (1979) 263, at
/// h = 1).
///
/// It is symplectic Euler, kick first, on the pendulum H = p²/2 + K cos q. The angle is stored
/// wrapped, 0 ≤ q' < 2π, and its period is stated in the [coordinates](TimeAdvance::coordinates).
/// One degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StandardMap {
    strength: f64,
}

impl StandardMap {
    /// The map with kicks of strength K.
    ///
    /// # Errors
    /// If the strength is not finite.
    pub fn new(strength: f64) -> Result<Self, ModelError> {
        ModelError::check_finite("the strength of the standard map", strength)?;
        Ok(StandardMap { strength })
    }
}

impl TimeAdvance for StandardMap {
    fn dof(&self) -> usize {
        1
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        add_sin(self.strength * h, block.q.row(0), block.p.row_mut(0));
        for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row(0)) {
            let angle = (*q + h * p).rem_euclid(TAU);
            // A negative angle smaller than the rounding error of 2π gives 2π itself.
            *q = if angle < TAU { angle } else { 0.0 };
        }
        Ok(())
    }

    fn coordinates(&self) -> Coordinates {
        Coordinates::plain(1)
            .with_periods(vec![TAU])
            .expect("one finite period for one degree of freedom")
    }

    fn tangent(&self) -> Option<&dyn TangentMap> {
        Some(self)
    }
}

/// Wrapping moves states by whole periods and leaves tangent vectors alone.
impl TangentMap for StandardMap {
    fn advance_tangents(
        &self,
        h: f64,
        states: &mut Block<'_>,
        tangents: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        let kick = self.strength * h;
        let along = tangents.q.row_mut(0).iter_mut().zip(tangents.p.row_mut(0));
        for ((dq, dp), q) in along.zip(states.q.row(0)) {
            *dp += kick * q.cos() * *dq;
            *dq += h * *dp;
        }
        self.advance(h, states)
    }
}

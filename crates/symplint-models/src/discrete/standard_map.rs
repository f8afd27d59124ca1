//! The kicked rotor.

use std::f64::consts::TAU;

use symplint::map::{Capabilities, TangentMap};
use symplint::{Block, Coordinates, StepFailure, TimeAdvance};

use crate::elementary::add_sin;
use crate::error::ModelError;

/// The standard map on the cylinder, or on the torus: p' = p + K h sin q, q' = q + h p' mod 2π (B. V. Chirikov, "A
/// universal instability of many-dimensional oscillator systems", Phys. Rep. 52 (1979) 263, at
/// h = 1).
///
/// It is symplectic Euler, kick first, on the pendulum H = p²/2 + K cos q. The angle is stored
/// wrapped, 0 ≤ q' < 2π, and its period is stated in the [coordinates](Capabilities::coordinates); on the torus, so is
/// the momentum.
/// One degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StandardMap {
    strength: f64,
    torus: bool,
}

impl StandardMap {
    /// The map with kicks of strength K.
    ///
    /// # Errors
    /// If the strength is not finite.
    pub fn new(strength: f64) -> Result<Self, ModelError> {
        ModelError::check_finite("the strength of the standard map", strength)?;
        Ok(StandardMap {
            strength,
            torus: false,
        })
    }

    /// The same with the momentum modulo 2π, too. A step of size h goes round the torus only where h is a whole number;
    /// others are refused.
    pub fn on_torus(self) -> Self {
        StandardMap {
            torus: true,
            ..self
        }
    }
}

impl TimeAdvance for StandardMap {
    fn dof(&self) -> usize {
        1
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        if self.torus && h.fract() != 0.0 {
            return Err(StepFailure {
                sample: 0,
                reason: format!("the standard map on the torus takes whole step sizes, not {h}"),
            });
        }
        add_sin(self.strength * h, block.q.row(0), block.p.row_mut(0));
        for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row(0)) {
            *q = wrapped(*q + h * p);
        }
        if self.torus {
            for p in block.p.row_mut(0) {
                *p = wrapped(*p);
            }
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        let of_momentum = if self.torus { TAU } else { 0.0 };
        let coordinates = Coordinates::plain(1)
            .with_periods(vec![TAU])
            .and_then(|periodic| periodic.with_momentum_periods(vec![of_momentum]))
            .expect("one finite period for one degree of freedom");
        Capabilities {
            tangent: Some(self),
            ..Capabilities::of_coordinates(coordinates)
        }
    }
}

/// An angle in [0, 2π).
fn wrapped(angle: f64) -> f64 {
    let angle = angle.rem_euclid(TAU);
    // A negative angle smaller than the rounding error of 2π gives 2π itself.
    if angle < TAU { angle } else { 0.0 }
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

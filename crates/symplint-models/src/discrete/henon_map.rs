//! The quadratic map of the plane.

use symplint::map::{Capabilities, TangentMap};
use symplint::{Block, StepFailure, TimeAdvance};

use crate::error::ModelError;

/// Hénon's quadratic map in its area-preserving form, p −= h q², then a rotation by the angle αh,
/// with an optional contraction b^h of the momentum before both (M. Hénon, "Numerical study of
/// quadratic area-preserving mappings", Quart. Appl. Math. 27 (1969) 291).
///
/// At h = 1 and b = 1 it is Hénon's: q' = q cos α − (p − q²) sin α, p' = q sin α + (p − q²) cos α.
/// The determinant of the Jacobian is b^h: symplectic at b = 1, and every loop integral shrinks by
/// b^h otherwise. One degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HenonMap {
    angle: f64,
    contraction: f64,
}

impl HenonMap {
    /// The map with angle α and contraction b.
    ///
    /// # Errors
    /// If the angle is not finite, or the contraction not finite and positive.
    pub fn new(angle: f64, contraction: f64) -> Result<Self, ModelError> {
        ModelError::check_finite("the angle of the Hénon map", angle)?;
        ModelError::check_positive("the contraction of the Hénon map", contraction)?;
        Ok(HenonMap { angle, contraction })
    }
}

impl TimeAdvance for HenonMap {
    fn dof(&self) -> usize {
        1
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        let (sin, cos) = (self.angle * h).sin_cos();
        let contraction = self.contraction.powf(h);
        for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row_mut(0)) {
            let kicked = contraction * *p - h * *q * *q;
            (*q, *p) = (*q * cos - kicked * sin, *q * sin + kicked * cos);
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            tangent: Some(self),
            ..Capabilities::plain(self.dof())
        }
    }
}

impl TangentMap for HenonMap {
    fn advance_tangents(
        &self,
        h: f64,
        states: &mut Block<'_>,
        tangents: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        let (sin, cos) = (self.angle * h).sin_cos();
        let contraction = self.contraction.powf(h);
        let along = tangents.q.row_mut(0).iter_mut().zip(tangents.p.row_mut(0));
        for ((dq, dp), q) in along.zip(states.q.row(0)) {
            let kicked = contraction * *dp - 2.0 * h * q * *dq;
            (*dq, *dp) = (*dq * cos - kicked * sin, *dq * sin + kicked * cos);
        }
        self.advance(h, states)
    }
}

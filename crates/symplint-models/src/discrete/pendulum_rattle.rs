//! A pendulum in Cartesian coordinates, on a rod of fixed length.

use symplint::map::{Capabilities, Constraint};
use symplint::{Block, StepFailure, TimeAdvance};

use crate::error::ModelError;

/// A unit mass on a rod of fixed length in the plane, by RATTLE (H. C. Andersen, "Rattle: a velocity version of the SHAKE
/// algorithm", J. Comput. Phys. 52 (1983) 24): H = (p_x² + p_y²)/2 + g y on x² + y² = L², x p_x + y p_y = 0.
///
/// Two degrees of freedom, (x, y) and (p_x, p_y), of which the constraint leaves one. It is symplectic on the manifold of
/// the constraint, and takes states off the manifold onto it (B. Leimkuhler and R. D. Skeel, J. Comput. Phys. 112 (1994) 117).
/// The rod pulls along its direction before the step; how hard is the root of a quadratic equation, and no iteration is
/// needed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PendulumRattle {
    length: f64,
    gravity: f64,
}

impl PendulumRattle {
    /// A rod of this length in this gravity.
    ///
    /// # Errors
    /// If the length is not finite and positive, or gravity not finite.
    pub fn new(length: f64, gravity: f64) -> Result<Self, ModelError> {
        ModelError::check_positive("the length of the rod", length)?;
        ModelError::check_finite("gravity", gravity)?;
        Ok(PendulumRattle { length, gravity })
    }

    /// The state at this angle from the lowest position, with this momentum along the circle: (x, y) and (p_x, p_y).
    pub fn state(&self, angle: f64, momentum: f64) -> ([f64; 2], [f64; 2]) {
        let (sin, cos) = angle.sin_cos();
        let q = [self.length * sin, -self.length * cos];
        (q, [momentum * cos, momentum * sin])
    }

    fn step(&self, h: f64, q: &mut [f64; 2], p: &mut [f64; 2]) -> Result<(), &'static str> {
        let rod = *q;
        p[1] -= 0.5 * h * self.gravity;
        q[0] += h * p[0];
        q[1] += h * p[1];
        // |q + μ rod|² = L²: the root near 0.
        let (a, b) = (dot(rod, rod), dot(*q, rod));
        let c = dot(*q, *q) - self.length * self.length;
        let discriminant = b * b - a * c;
        if discriminant.is_nan() || discriminant < 0.0 || b <= 0.0 {
            return Err("the rod does not reach: the step is too large");
        }
        let pull = -c / (b + discriminant.sqrt());
        for i in 0..2 {
            q[i] += pull * rod[i];
            p[i] += pull / h * rod[i];
        }
        p[1] -= 0.5 * h * self.gravity;
        onto_tangent(*q, p);
        Ok(())
    }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Takes from p what is along the rod.
fn onto_tangent(q: [f64; 2], p: &mut [f64; 2]) {
    let along = dot(q, *p) / dot(q, q);
    p[0] -= along * q[0];
    p[1] -= along * q[1];
}

impl TimeAdvance for PendulumRattle {
    fn dof(&self) -> usize {
        2
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        for sample in 0..block.len() {
            let (mut q, mut p) = state(block, sample);
            self.step(h, &mut q, &mut p).map_err(|reason| StepFailure {
                sample,
                reason: reason.to_owned(),
            })?;
            write(block, sample, q, p);
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            constraint: Some(self),
            ..Capabilities::plain(self.dof())
        }
    }
}

/// To the nearest point of the circle, and the momentum to its tangent there.
impl Constraint for PendulumRattle {
    fn project(&self, block: &mut Block<'_>) {
        for sample in 0..block.len() {
            let (q, mut p) = state(block, sample);
            let scale = self.length / q[0].hypot(q[1]);
            let q = q.map(|x| scale * x);
            onto_tangent(q, &mut p);
            write(block, sample, q, p);
        }
    }
}

fn state(block: &Block<'_>, sample: usize) -> ([f64; 2], [f64; 2]) {
    (
        [0, 1].map(|i| block.q.row(i)[sample]),
        [0, 1].map(|i| block.p.row(i)[sample]),
    )
}

fn write(block: &mut Block<'_>, sample: usize, q: [f64; 2], p: [f64; 2]) {
    for i in 0..2 {
        block.q.row_mut(i)[sample] = q[i];
        block.p.row_mut(i)[sample] = p[i];
    }
}

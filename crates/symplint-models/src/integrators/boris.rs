//! The Boris method for a charge in a magnetic field.

use symplint::map::{Capabilities, TangentMap};
use symplint::{Block, StepFailure, TimeAdvance};

use crate::hamiltonian::Hamiltonian;
use crate::systems::ChargedParticle;

/// The Boris method, position first, in canonical variables: p becomes the velocity v = p − A(q),
/// the charge drifts for h/2, its velocity gets half the electric kick, a rotation by the angle
/// 2 atan(hB/2), and the other half of the kick, it drifts for h/2, and p = v + A(q) again (J. P.
/// Boris 1970; C. K. Birdsall & A. B. Langdon, Plasma Physics via Computer Simulation).
///
/// Order 2, symmetric. It conserves volumes in phase space, and without an electric field the
/// speed, to round-off. It is not symplectic: not in a magnetic field that varies in space, nor in a
/// uniform one with an electric field as well, though it is conjugate to a symplectic map there. In
/// a uniform field alone it is the implicit midpoint rule, and symplectic. (H. Qin et al., "Why is Boris algorithm so good?", Phys. Plasmas 20
/// (2013) 084503.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boris {
    particle: ChargedParticle,
}

impl Boris {
    /// The map for `particle`.
    pub fn new(particle: ChargedParticle) -> Self {
        Boris { particle }
    }

    /// One step of position (x, y) and velocity.
    fn step(&self, h: f64, [mut x, mut y]: [f64; 2], v: [f64; 2]) -> ([f64; 2], [f64; 2]) {
        let half = 0.5 * h;
        x += half * v[0];
        y += half * v[1];
        let kick = self.particle.electric_field(x, y).map(|e| half * e);
        let before = [v[0] + kick[0], v[1] + kick[1]];
        let t = half * self.particle.magnetic_field(x);
        let s = 2.0 * t / (1.0 + t * t);
        // v × B of a field along z turns (v_x, v_y) towards (v_y, −v_x).
        let between = [before[0] + t * before[1], before[1] - t * before[0]];
        let v = [
            before[0] + s * between[1] + kick[0],
            before[1] - s * between[0] + kick[1],
        ];
        ([x + half * v[0], y + half * v[1]], v)
    }

    /// The derivative of [`step`](Self::step), line by line.
    fn step_tangent(
        &self,
        h: f64,
        ([x, y], v): ([f64; 2], [f64; 2]),
        ([dx, dy], dv): ([f64; 2], [f64; 2]),
    ) -> ([f64; 2], [f64; 2]) {
        let half = 0.5 * h;
        let (x, y) = (x + half * v[0], y + half * v[1]);
        let (dx, dy) = (dx + half * dv[0], dy + half * dv[1]);
        let kick = self.particle.electric_field(x, y).map(|e| half * e);
        // The electric field is linear.
        let dkick = self.particle.electric_field(dx, dy).map(|e| half * e);
        let before = [v[0] + kick[0], v[1] + kick[1]];
        let dbefore = [dv[0] + dkick[0], dv[1] + dkick[1]];
        let t = half * self.particle.magnetic_field(x);
        let dt = half * self.particle.magnetic_gradient() * dx;
        let s = 2.0 * t / (1.0 + t * t);
        let ds = 2.0 * (1.0 - t * t) / (1.0 + t * t).powi(2) * dt;
        let between = [before[0] + t * before[1], before[1] - t * before[0]];
        let dbetween = [
            dbefore[0] + dt * before[1] + t * dbefore[1],
            dbefore[1] - dt * before[0] - t * dbefore[0],
        ];
        let dv = [
            dbefore[0] + ds * between[1] + s * dbetween[1] + dkick[0],
            dbefore[1] - ds * between[0] - s * dbetween[0] + dkick[1],
        ];
        ([dx + half * dv[0], dy + half * dv[1]], dv)
    }
}

impl TimeAdvance for Boris {
    fn dof(&self) -> usize {
        2
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        for k in 0..block.len() {
            let (x, y) = (block.q.row(0)[k], block.q.row(1)[k]);
            let v = [
                block.p.row(0)[k],
                block.p.row(1)[k] - self.particle.vector_potential(x),
            ];
            let ([x, y], v) = self.step(h, [x, y], v);
            block.q.row_mut(0)[k] = x;
            block.q.row_mut(1)[k] = y;
            block.p.row_mut(0)[k] = v[0];
            block.p.row_mut(1)[k] = v[1] + self.particle.vector_potential(x);
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            tangent: Some(self),
            ..Capabilities::of_coordinates(self.particle.coordinates())
        }
    }
}

impl TangentMap for Boris {
    fn advance_tangents(
        &self,
        h: f64,
        states: &mut Block<'_>,
        tangents: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        // A_y' = B.
        let turned = |x: f64, dx: f64| self.particle.magnetic_field(x) * dx;
        for k in 0..states.len() {
            let (x, y) = (states.q.row(0)[k], states.q.row(1)[k]);
            let (dx, dy) = (tangents.q.row(0)[k], tangents.q.row(1)[k]);
            let v = [
                states.p.row(0)[k],
                states.p.row(1)[k] - self.particle.vector_potential(x),
            ];
            let dv = [tangents.p.row(0)[k], tangents.p.row(1)[k] - turned(x, dx)];
            let ([dx, dy], dv) = self.step_tangent(h, ([x, y], v), ([dx, dy], dv));
            let ([x, _], _) = self.step(h, [x, y], v);
            tangents.q.row_mut(0)[k] = dx;
            tangents.q.row_mut(1)[k] = dy;
            tangents.p.row_mut(0)[k] = dv[0];
            tangents.p.row_mut(1)[k] = dv[1] + turned(x, dx);
        }
        self.advance(h, states)
    }
}

//! A charge in a magnetic field, in positions and velocities.

use super::{NonCanonicalSystem, State};
use crate::systems::ChargedParticle;

/// A [`ChargedParticle`] in the coordinates (x, y, v_x, v_y), as codes store it: ω is the derivative of
/// ϑ = v_x dx + (v_y + A_y(x)) dy. Canonical in (x, y) and p = v + A.
///
/// The symplectic step composes the exact flows of v_x²/2, v_y²/2 and φ symmetrically, order 2 (Y. He, Z. Zhou, Y. Sun, J. Liu, H. Qin,
/// Phys. Lett. A 381 (2017) 568).
#[derive(Clone, Copy, Debug)]
pub struct Velocities(pub ChargedParticle);

/// Steps of positions and velocities that are not symplectic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VelocityStep {
    /// J. P. Boris 1970: half drifts round a kick, in which the velocity turns by 2 atan(hB/2).
    Boris,
    /// The same with a turn by hB, all exact flows of fields without divergence: it conserves volumes (Y. He, Y. Sun, J. Liu, H. Qin, J.
    /// Comput. Phys. 281 (2015) 135).
    VolumePreserving,
}

impl Velocities {
    /// One of the steps that are not symplectic.
    pub fn step(&self, step: VelocityStep, h: f64, [[x, y], v]: State<2>) -> State<2> {
        let half = 0.5 * h;
        let (x, y) = (x + half * v[0], y + half * v[1]);
        let kick = self.0.electric_field(x, y).map(|e| half * e);
        let field = self.0.magnetic_field(x);
        let angle = match step {
            VelocityStep::Boris => 2.0 * (half * field).atan(),
            VelocityStep::VolumePreserving => h * field,
        };
        let (sin, cos) = angle.sin_cos();
        let [vx, vy] = [v[0] + kick[0], v[1] + kick[1]];
        let v = [cos * vx + sin * vy + kick[0], cos * vy - sin * vx + kick[1]];
        [[x + half * v[0], y + half * v[1]], v]
    }

    /// The exact flow of v_x²/2: y rests, and v_y turns by ∫ B dx.
    fn along_x(&self, tau: f64, [[x, y], [vx, vy]]: State<2>) -> State<2> {
        let to = x + tau * vx;
        let turned = self.0.vector_potential(to) - self.0.vector_potential(x);
        [[to, y], [vx, vy - turned]]
    }

    /// The exact flow of v_y²/2: x rests, and B with it.
    fn along_y(&self, tau: f64, [[x, y], [vx, vy]]: State<2>) -> State<2> {
        let step = tau * vy;
        [[x, y + step], [vx + step * self.0.magnetic_field(x), vy]]
    }

    /// The exact flow of φ.
    fn kick(&self, tau: f64, [[x, y], v]: State<2>) -> State<2> {
        let field = self.0.electric_field(x, y);
        [[x, y], [v[0] + tau * field[0], v[1] + tau * field[1]]]
    }
}

impl NonCanonicalSystem<2> for Velocities {
    fn velocity(&self, [[x, y], [vx, vy]]: State<2>) -> State<2> {
        let ([ex, ey], field) = (self.0.electric_field(x, y), self.0.magnetic_field(x));
        [[vx, vy], [ex + field * vy, ey - field * vx]]
    }

    fn energy(&self, [[x, y], [vx, vy]]: State<2>) -> f64 {
        // φ is a quadratic form: −E·x/2.
        let [ex, ey] = self.0.electric_field(x, y);
        0.5 * (vx * vx + vy * vy - ex * x - ey * y)
    }

    fn one_form(&self, [[x, _], [vx, vy]]: State<2>) -> State<2> {
        [[vx, vy + self.0.vector_potential(x)], [0.0, 0.0]]
    }

    fn symplectic_step(&self, h: f64, z: State<2>) -> Result<State<2>, &'static str> {
        let half = 0.5 * h;
        let z = self.along_y(half, self.along_x(half, z));
        let z = self.kick(h, z);
        Ok(self.along_x(half, self.along_y(half, z)))
    }
}

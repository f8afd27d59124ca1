//! The guiding centre of a gyrating charge.

use super::{NonCanonicalSystem, State};
use crate::error::ModelError;

/// The guiding centre of a charge in a sheared magnetic field, in four dimensions (R. G. Littlejohn, J. Plasma Phys. 29 (1983) 111):
/// position (x, y, z) and parallel velocity u, H = u²/2 + μ B(x) + φ(y, z), and ϑ = (A + u b)·dx, of unit mass and charge.
///
/// The field is that of A = (0, b x + g x²/2, −s x²/2): B = (0, s x, b + g x), of direction b(x). The potential is
/// φ = ε (cos y + cos z + cos(y − z)). Coordinates are taken in the order (y, z, x, u): P = (A_y + u b_y, A_z + u b_z), functions of x
/// and u, are canonical momenta of y and z.
///
/// The symplectic step is the degenerate variational integrator that is symplectic Euler in these (C. L. Ellison et al., Phys. Plasmas 25
/// (2018) 052502): P moves by φ at the old place, and x and u are found from it by Newton's method.
#[derive(Clone, Copy, Debug)]
pub struct GuidingCenter {
    field: f64,
    gradient: f64,
    shear: f64,
    moment: f64,
    potential: f64,
}

/// What depends on x alone.
struct At {
    /// B and its derivative.
    field: [f64; 2],
    /// A_y and A_z.
    potential: [f64; 2],
    /// B_y and B_z: the derivatives of A_z and A_y, but for a sign.
    components: [f64; 2],
    /// b_y and b_z.
    direction: [f64; 2],
    /// Their derivatives.
    turn: [f64; 2],
}

/// Newton iterations at most; three are enough for steps that resolve the motion.
const MAX_ITERATIONS: usize = 30;

impl GuidingCenter {
    /// In a field of b = `field`, g = `gradient` and s = `shear`, with μ = `moment` and ε = `potential`.
    ///
    /// # Errors
    /// If the field is not positive, or a number not finite.
    pub fn new(
        field: f64,
        gradient: f64,
        shear: f64,
        moment: f64,
        potential: f64,
    ) -> Result<Self, ModelError> {
        ModelError::check_positive("the magnetic field", field)?;
        ModelError::check_finite("the gradient of the magnetic field", gradient)?;
        ModelError::check_finite("the shear of the magnetic field", shear)?;
        ModelError::check_finite("the magnetic moment", moment)?;
        ModelError::check_finite("the electric potential", potential)?;
        Ok(GuidingCenter {
            field,
            gradient,
            shear,
            moment,
            potential,
        })
    }

    fn at(&self, x: f64) -> At {
        let components = [self.shear * x, self.field + self.gradient * x];
        let size = components[0].hypot(components[1]);
        let direction = components.map(|component| component / size);
        let slope = direction[0] * self.shear + direction[1] * self.gradient;
        At {
            field: [size, slope],
            potential: [
                x * (self.field + 0.5 * self.gradient * x),
                -0.5 * self.shear * x * x,
            ],
            components,
            direction,
            turn: [
                (self.shear - direction[0] * slope) / size,
                (self.gradient - direction[1] * slope) / size,
            ],
        }
    }

    /// P and its derivatives with respect to x and to u.
    fn momentum(&self, [x, u]: [f64; 2]) -> ([f64; 2], [[f64; 2]; 2]) {
        let at = self.at(x);
        let momentum = [0, 1].map(|i| at.potential[i] + u * at.direction[i]);
        let [by, bz] = at.components;
        let by_x = [bz + u * at.turn[0], -by + u * at.turn[1]];
        (momentum, [by_x, at.direction])
    }

    /// −∂φ/∂y and −∂φ/∂z.
    fn force(&self, [y, z]: [f64; 2]) -> [f64; 2] {
        let between = (y - z).sin();
        [y.sin() + between, z.sin() - between].map(|slope| self.potential * slope)
    }

    /// ∂H/∂P at fixed y and z.
    fn drift(&self, [x, u]: [f64; 2]) -> [f64; 2] {
        let (_, [by_x, by_u]) = self.momentum([x, u]);
        let slope = self.moment * self.at(x).field[1];
        // ∂H/∂x = slope and ∂H/∂u = u are the products of ∂H/∂P with the derivatives of P.
        solve([[by_x[0], by_x[1]], [by_u[0], by_u[1]]], [slope, u])
    }
}

/// The solution of two linear equations, given by their rows.
fn solve([[a, b], [c, d]]: [[f64; 2]; 2], [e, f]: [f64; 2]) -> [f64; 2] {
    let determinant = a * d - b * c;
    [(e * d - b * f) / determinant, (a * f - e * c) / determinant]
}

impl NonCanonicalSystem<2> for GuidingCenter {
    fn velocity(&self, [at, [x, u]]: State<2>) -> State<2> {
        let (_, [by_x, by_u]) = self.momentum([x, u]);
        let force = self.force(at);
        // Ṗ = force, of which x and u are functions.
        let moved = solve([[by_x[0], by_u[0]], [by_x[1], by_u[1]]], force);
        [self.drift([x, u]), moved]
    }

    fn energy(&self, [[y, z], [x, u]]: State<2>) -> f64 {
        let potential = y.cos() + z.cos() + (y - z).cos();
        0.5 * u * u + self.moment * self.at(x).field[0] + self.potential * potential
    }

    fn one_form(&self, [_, x_and_u]: State<2>) -> State<2> {
        [self.momentum(x_and_u).0, [0.0, 0.0]]
    }

    fn symplectic_step(&self, h: f64, [at, x_and_u]: State<2>) -> Result<State<2>, &'static str> {
        let (momentum, _) = self.momentum(x_and_u);
        let force = self.force(at);
        let wanted = [0, 1].map(|i| momentum[i] + h * force[i]);
        let mut found = x_and_u;
        let mut last = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            let (momentum, [by_x, by_u]) = self.momentum(found);
            let left = [wanted[0] - momentum[0], wanted[1] - momentum[1]];
            let step = solve([[by_x[0], by_u[0]], [by_x[1], by_u[1]]], left);
            let size = step[0].abs().max(step[1].abs());
            if !size.is_finite() {
                break;
            }
            // Beyond rounding steps become no smaller.
            if size >= last && last < 1e-12 {
                let drift = self.drift(found);
                return Ok([[at[0] + h * drift[0], at[1] + h * drift[1]], found]);
            }
            found = [found[0] + step[0], found[1] + step[1]];
            last = size;
        }
        Err("Newton's method finds no x and u of this momentum: the step or the loop is too large")
    }
}

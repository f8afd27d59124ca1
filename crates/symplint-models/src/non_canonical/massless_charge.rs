//! A charge without mass in a strong magnetic field.

use super::{NonCanonicalSystem, State};
use crate::error::ModelError;

/// A charge that drifts across a magnetic field B = b + g x in the electric potential φ = (x² + k y²)/2: B ẋ = −∂φ/∂y,
/// B ẏ = ∂φ/∂x, the motion of a particle whose mass goes to zero. H = φ, and ω = B dx∧dy, the derivative of
/// ϑ = A(x) dy with A = b x + g x²/2. Canonical in y and A.
///
/// The symplectic step is the flow of x²/2, along which x rests, and then that of k y²/2, along which y does.
#[derive(Clone, Copy, Debug)]
pub struct MasslessCharge {
    field: f64,
    gradient: f64,
    stiffness: f64,
}

impl MasslessCharge {
    /// A charge in the field `field` + `gradient` x, with k = `stiffness`.
    ///
    /// # Errors
    /// If the field is not positive, or a number not finite.
    pub fn new(field: f64, gradient: f64, stiffness: f64) -> Result<Self, ModelError> {
        ModelError::check_positive("the magnetic field", field)?;
        ModelError::check_finite("the gradient of the magnetic field", gradient)?;
        ModelError::check_finite("the stiffness", stiffness)?;
        Ok(MasslessCharge {
            field,
            gradient,
            stiffness,
        })
    }

    fn magnetic_field(&self, x: f64) -> f64 {
        self.field + self.gradient * x
    }

    fn vector_potential(&self, x: f64) -> f64 {
        x * (self.field + 0.5 * self.gradient * x)
    }
}

impl NonCanonicalSystem<1> for MasslessCharge {
    fn velocity(&self, [[x], [y]]: State<1>) -> State<1> {
        let field = self.magnetic_field(x);
        [[-self.stiffness * y / field], [x / field]]
    }

    fn energy(&self, [[x], [y]]: State<1>) -> f64 {
        0.5 * (x * x + self.stiffness * y * y)
    }

    fn one_form(&self, [[x], _]: State<1>) -> State<1> {
        [[0.0], [self.vector_potential(x)]]
    }

    fn symplectic_step(&self, h: f64, [[x], [y]]: State<1>) -> Result<State<1>, &'static str> {
        let y = y + h * x / self.magnetic_field(x);
        let change = -h * self.stiffness * y;
        // A(x + Δ) = A(x) + change: the root near 0 of g Δ²/2 + B Δ − change.
        let field = self.magnetic_field(x);
        let discriminant = field * field + 2.0 * self.gradient * change;
        if field.is_nan() || field <= 0.0 || discriminant.is_nan() || discriminant < 0.0 {
            return Err(
                "the magnetic field vanishes on the way: the step or the loop is too large",
            );
        }
        Ok([[x + 2.0 * change / (field + discriminant.sqrt())], [y]])
    }
}

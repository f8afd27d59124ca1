//! A particle that falls to both sides of a wedge.

use symplint::state::{Rows, RowsMut};

use crate::error::ModelError;
use crate::hamiltonian::Separable;
use crate::tangent::DriftKickTangent;

/// H = p²/2 + |q|, whose force jumps at q = 0, or smoothed H = p²/2 + √(q² + ε²).
///
/// The model of a potential that is piecewise linear (Barham & Burby, section 4.2): splitting
/// methods tear a loop that passes q = 0. At q = 0 itself, where |q| has no derivative, the
/// force is −1, that of q > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AbsoluteValue {
    epsilon: f64,
}

impl AbsoluteValue {
    /// |q| for `epsilon` = 0, otherwise √(q² + ε²).
    ///
    /// # Errors
    /// If `epsilon` is negative or not finite.
    pub fn new(epsilon: f64) -> Result<Self, ModelError> {
        if !(epsilon.is_finite() && epsilon >= 0.0) {
            return Err(ModelError::OutOfRange {
                what: "epsilon of the absolute value",
                value: epsilon,
                remedy: "give a finite number: 0 for abs(q), above 0 for sqrt(q² + epsilon²)",
            });
        }
        Ok(AbsoluteValue { epsilon })
    }

    /// The width ε over which the wedge is rounded.
    pub fn epsilon(&self) -> f64 {
        self.epsilon
    }
}

impl Separable for AbsoluteValue {
    fn dof(&self) -> usize {
        1
    }

    fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>) {
        let states = p.row_mut(0).iter_mut().zip(q.row(0));
        if self.epsilon == 0.0 {
            states.for_each(|(p, q)| *p -= if *q < 0.0 { -tau } else { tau });
        } else {
            states.for_each(|(p, q)| *p -= tau * (q / q.hypot(self.epsilon)));
        }
    }

    fn potential_energy(&self, q: Rows<'_>, out: &mut [f64]) {
        for (out, q) in out.iter_mut().zip(q.row(0)) {
            *out = q.hypot(self.epsilon);
        }
    }

    fn tangent(&self) -> Option<&dyn DriftKickTangent> {
        Some(self)
    }
}

impl DriftKickTangent for AbsoluteValue {
    fn kick_tangent(&self, tau: f64, q: Rows<'_>, dq: Rows<'_>, dp: &mut RowsMut<'_>) {
        // The force of the wedge is constant on either side of its jump.
        if self.epsilon == 0.0 {
            return;
        }
        for ((dp, dq), q) in dp.row_mut(0).iter_mut().zip(dq.row(0)).zip(q.row(0)) {
            // ε²/(q² + ε²)^{3/2}, in ratios that do not overflow.
            let root = q.hypot(self.epsilon);
            *dp -= tau * (self.epsilon / root).powi(2) / root * dq;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_force_at_the_tip_is_that_of_the_right_side() {
        let (q, mut p) = ([-2.0, -0.0, 0.0, 1e-300, 3.0], [0.0; 5]);
        let system = AbsoluteValue::new(0.0).unwrap();
        system.kick(
            0.5,
            Rows::new(&q, 1, 5, 5),
            &mut RowsMut::new(&mut p, 1, 5, 5),
        );
        assert_eq!(p, [0.5, -0.5, -0.5, -0.5, -0.5]);
    }

    #[test]
    fn epsilon_is_checked() {
        for epsilon in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(AbsoluteValue::new(epsilon).is_err());
        }
    }
}

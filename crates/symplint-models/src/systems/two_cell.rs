//! A particle that meets only its own field.

use symplint::Coordinates;
use symplint::state::{Rows, RowsMut};

use crate::error::ModelError;
use crate::hamiltonian::Separable;
use crate::periodic_grid::PeriodicGrid;
use crate::tangent::DriftKickTangent;

/// One particle on two cells with linear shapes: H = v²/2 − ¼ (|x/L| − x²/L²) on [−L, L], the ends
/// identified (Barham & Burby, appendix F).
///
/// The force (½ − |x/L|) sign(x) / 2L jumps at 0 and at L. It is what
/// `Pic1d` of the crate `symplint-plasma` has with 2 cells on a length 2L, degree 1 and one particle of weight
/// 1/L, whose energy is H/L + 1/(16 L). Positions are not wrapped; where the force jumps it is
/// that of the cell above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoCell {
    grid: PeriodicGrid,
    cell: f64,
}

impl TwoCell {
    /// Two cells of length `cell` each: L.
    ///
    /// # Errors
    /// If the length is not finite and positive.
    pub fn new(cell: f64) -> Result<Self, ModelError> {
        Ok(TwoCell {
            grid: PeriodicGrid::new(2, 2.0 * cell)?,
            cell,
        })
    }

    /// |x/L| and sign(x), with x wrapped into [−L, L].
    fn locate(&self, x: f64) -> (f64, f64) {
        // Cell 0 reaches from 0 to L, cell 1 from L to 2L, which is −L to 0.
        match self.grid.locate(x) {
            (0, fraction) => (fraction, 1.0),
            (_, fraction) => (1.0 - fraction, -1.0),
        }
    }
}

impl Separable for TwoCell {
    fn dof(&self) -> usize {
        1
    }

    fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>) {
        for (v, &x) in p.row_mut(0).iter_mut().zip(q.row(0)) {
            let (distance, sign) = self.locate(x);
            *v += tau * sign * (0.5 - distance) / (2.0 * self.cell);
        }
    }

    fn potential_energy(&self, q: Rows<'_>, out: &mut [f64]) {
        for (out, &x) in out.iter_mut().zip(q.row(0)) {
            let (distance, _) = self.locate(x);
            *out = -0.25 * (distance - distance * distance);
        }
    }

    fn coordinates(&self) -> Coordinates {
        let plain = Coordinates::plain(1);
        (plain.with_grid_spacing(self.cell)).expect("the length was checked")
    }

    fn tangent(&self) -> Option<&dyn DriftKickTangent> {
        Some(self)
    }
}

impl DriftKickTangent for TwoCell {
    fn kick_tangent(&self, tau: f64, _q: Rows<'_>, dq: Rows<'_>, dp: &mut RowsMut<'_>) {
        // Between its jumps the force falls by 1/2L over a length L.
        let slope = -0.5 * tau / (self.cell * self.cell);
        for (dp, dq) in dp.row_mut(0).iter_mut().zip(dq.row(0)) {
            *dp += slope * dq;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn force(system: &TwoCell, x: f64) -> f64 {
        let mut v = [0.0];
        system.kick(
            1.0,
            Rows::new(&[x], 1, 1, 1),
            &mut RowsMut::new(&mut v, 1, 1, 1),
        );
        v[0]
    }

    #[test]
    fn the_force_is_the_formula_of_the_appendix() {
        for length in [1.0, 0.3, 25.0] {
            let system = TwoCell::new(length).unwrap();
            for step in -99..100 {
                let y = (f64::from(step) + 0.5) / 100.0;
                let expected = (0.5 - y.abs()) * y.signum() / (2.0 * length);
                for turns in [0.0, 2.0, -6.0] {
                    let got = force(&system, (y + turns) * length);
                    assert!((got - expected).abs() < 1e-14, "x = {y} L");
                }
            }
        }
    }

    #[test]
    fn the_force_at_its_jumps_is_that_from_above() {
        let system = TwoCell::new(2.0).unwrap();
        assert_eq!(force(&system, 0.0), 0.125);
        assert!((force(&system, -1e-9) + 0.125).abs() < 1e-9);
        for end in [2.0, -2.0, 6.0] {
            assert_eq!(force(&system, end), 0.125);
        }
    }

    #[test]
    fn both_jumps_are_where_they_are_at_any_length() {
        for length in [49.0, 24.5, 628.0 / 100.0, 314.0 / 100.0, 1.0, 0.3, 0.1] {
            let system = TwoCell::new(length).unwrap();
            let most = 0.25 / length;
            // Powers of two, so that the products are exact.
            for turns in [0.0, 1.0, -1.0, 2.0, -2.0, 1024.0, -(2.0_f64.powi(40))] {
                let jump = turns * length;
                let below = force(&system, jump.next_down());
                assert_eq!(force(&system, jump), most, "{turns} × {length}");
                // The next number is the further below, the further out.
                let off = (below / most + 1.0).abs();
                assert!(off < 1e-15 * (1.0 + f64::abs(turns)), "{turns} × {length}");
            }
        }
    }

    #[test]
    fn the_length_is_checked() {
        for length in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(TwoCell::new(length).is_err(), "{length}");
        }
    }
}

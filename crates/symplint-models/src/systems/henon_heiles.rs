//! A star in a galaxy.

use symplint::state::{Rows, RowsMut};

use crate::hamiltonian::Separable;
use crate::tangent::DriftKickTangent;

/// The Hénon–Heiles system H = ½ |p|² + ½ |q|² + q_1² q_2 − q_2³/3 (HLW, section I.3).
///
/// Two degrees of freedom, neither linear nor integrable; orbits stay bounded below H = 1/6.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HenonHeiles;

impl Separable for HenonHeiles {
    fn dof(&self) -> usize {
        2
    }

    fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>) {
        let (x, y) = (q.row(0), q.row(1));
        for ((p, x), y) in p.row_mut(0).iter_mut().zip(x).zip(y) {
            *p -= tau * (x + 2.0 * x * y);
        }
        for ((p, x), y) in p.row_mut(1).iter_mut().zip(x).zip(y) {
            *p -= tau * (y + x * x - y * y);
        }
    }

    fn potential_energy(&self, q: Rows<'_>, out: &mut [f64]) {
        for ((out, x), y) in out.iter_mut().zip(q.row(0)).zip(q.row(1)) {
            *out = 0.5 * (x * x + y * y) + x * x * y - y * y * y / 3.0;
        }
    }

    fn tangent(&self) -> Option<&dyn DriftKickTangent> {
        Some(self)
    }
}

impl DriftKickTangent for HenonHeiles {
    fn kick_tangent(&self, tau: f64, q: Rows<'_>, dq: Rows<'_>, dp: &mut RowsMut<'_>) {
        for k in 0..q.len() {
            let (x, y) = (q.row(0)[k], q.row(1)[k]);
            let (dx, dy) = (dq.row(0)[k], dq.row(1)[k]);
            dp.row_mut(0)[k] -= tau * (dx + 2.0 * (x * dy + y * dx));
            dp.row_mut(1)[k] -= tau * (dy + 2.0 * (x * dx - y * dy));
        }
    }
}

//! The change of areas and volumes by a map, from its Jacobian by differences.

use nalgebra::DMatrix;
use symplint::TimeAdvance;

use crate::common::{State, stepped};

/// ∂Φ_h/∂(q, p) at a state, by differences of fourth order.
pub fn jacobian(map: &dyn TimeAdvance, h: f64, (q, p): &State) -> DMatrix<f64> {
    const STEP: f64 = 1e-3;
    let dof = q.len();
    let at = |axis: usize, k: f64| -> Vec<f64> {
        let (mut q, mut p) = (q.clone(), p.clone());
        if axis < dof {
            q[axis] += k * STEP;
        } else {
            p[axis - dof] += k * STEP;
        }
        let (q, p) = stepped(map, h, &(q, p));
        [q, p].concat()
    };
    let columns: Vec<Vec<f64>> = (0..2 * dof)
        .map(|axis| {
            let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(|k| at(axis, k));
            let rows = a.iter().zip(b).zip(c).zip(d);
            rows.map(|(((a, b), c), d)| (a - 8.0 * b + 8.0 * c - d) / (12.0 * STEP))
                .collect()
        })
        .collect();
    DMatrix::from_fn(2 * dof, 2 * dof, |i, j| columns[j][i])
}

/// The largest entry of Mᵀ J M − J with M the Jacobian: 0 for a symplectic map.
pub fn two_form_defect(map: &dyn TimeAdvance, h: f64, state: &State) -> f64 {
    let dof = state.0.len();
    let form = DMatrix::from_fn(2 * dof, 2 * dof, |i, j| {
        f64::from(u8::from(j == i + dof)) - f64::from(u8::from(i == j + dof))
    });
    let jacobian = jacobian(map, h, state);
    (jacobian.transpose() * &form * jacobian - form).amax()
}

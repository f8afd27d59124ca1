//! The derivative of the force: how the field changes where the particles are, as all of them move.
//!
//! A particle that moves by dx changes the charge of the nodes by w ∇N_i(x)·dx, and with it the
//! potential; and it sees the gradient of the old potential elsewhere:
//!
//! d(∇φ)(x_a) = ∇∇φ(x_a) dx_a + ∇(dφ)(x_a), with dφ = G Σ_a w_a ∇N(x_a)·dx_a.
//!
//! Where second derivatives of the shapes jump, as at cell boundaries for splines of degree 2, they are
//! those of the cell above. One sample at a time: this is for few tangent vectors.

use symplint::state::{Rows, RowsMut, scratch};

use super::mesh::Mesh;
use super::system::Pic;
use symplint_models::DriftKickTangent;

impl<const D: usize> DriftKickTangent for Pic<D> {
    fn kick_tangent(&self, tau: f64, q: Rows<'_>, dq: Rows<'_>, dp: &mut RowsMut<'_>) {
        let (dof, nodes) = (q.count(), self.mesh.nodes());
        scratch::with_buffer(2 * (dof + nodes), |room| {
            let (positions, rest) = room.split_at_mut(dof);
            let (tangent, rest) = rest.split_at_mut(dof);
            let (potential, change) = rest.split_at_mut(nodes);
            for sample in 0..q.len() {
                for i in 0..dof {
                    positions[i] = q.row(i)[sample];
                    tangent[i] = dq.row(i)[sample];
                }
                self.deposit(positions, potential);
                self.solver.solve(potential);
                let pairs = || self.split(positions).iter().zip(self.split(tangent));
                change.fill(0.0);
                for ((&x, &dx), &weight) in pairs().zip(self.weights()) {
                    self.mesh.deposit_change(weight, x, dx, change);
                }
                self.solver.solve(change);
                for (particle, (&x, &dx)) in pairs().enumerate() {
                    let turned = self.mesh.curvature(potential, x, dx);
                    let gradient = self.mesh.gradient(change, x);
                    for axis in 0..D {
                        let slope = turned[axis] + gradient[axis];
                        dp.row_mut(D * particle + axis)[sample] -= tau * slope;
                    }
                }
            }
        });
    }
}

impl<const D: usize> Mesh<D> {
    /// Adds `charge` × ∇N_i(x)·dx to every node i.
    fn deposit_change(&self, charge: f64, x: [f64; D], dx: [f64; D], nodes: &mut [f64]) {
        let scale = charge * self.cells_per_length();
        let last = self.stencil(D - 1, x[D - 1]);
        if D == 1 {
            for (place, slope) in last.slopes() {
                nodes[place] += scale * dx[0] * slope;
            }
        } else {
            let first = self.stencil(0, x[0]);
            for ((row, value), (_, slope)) in first.values().zip(first.slopes()) {
                let (along, across) = (scale * dx[0] * slope, scale * dx[D - 1] * value);
                for ((place, value), (_, slope)) in last.values().zip(last.slopes()) {
                    nodes[row + place] += along * value + across * slope;
                }
            }
        }
    }

    /// The second derivatives of Σ_i `nodes[i]` N_i at x, applied to dx.
    fn curvature(&self, nodes: &[f64], x: [f64; D], dx: [f64; D]) -> [f64; D] {
        let scale = self.cells_per_length().powi(2);
        let last = self.stencil(D - 1, x[D - 1]);
        let mut turned = [0.0; D];
        if D == 1 {
            let terms = last
                .curvatures()
                .map(|(place, weight)| nodes[place] * weight);
            turned[0] = terms.sum::<f64>() * dx[0];
        } else {
            let first = self.stencil(0, x[0]);
            let of_first = (first.values().zip(first.slopes())).zip(first.curvatures());
            for (((row, value), (_, slope)), (_, curvature)) in of_first {
                let of_last = (last.values().zip(last.slopes())).zip(last.curvatures());
                for (((place, other), (_, other_slope)), (_, other_curvature)) in of_last {
                    let node = nodes[row + place];
                    let mixed = slope * other_slope;
                    turned[0] += node * (curvature * other * dx[0] + mixed * dx[D - 1]);
                    turned[D - 1] += node * (mixed * dx[0] + value * other_curvature * dx[D - 1]);
                }
            }
        }
        turned.map(|component| component * scale)
    }
}

//! Between particles and nodes: charge is deposited, gradients are gathered, by the same shapes.

use std::iter::repeat_n;

use super::element::node_integrals;
use super::mesh::Mesh;

impl<const D: usize> Mesh<D> {
    /// A charge of −`charge` spread evenly over the box, as deposited on the nodes.
    pub(super) fn background(&self, charge: f64) -> Vec<f64> {
        let of_cell = self.background_of_cell(charge).into_iter();
        of_cell
            .flat_map(|value| repeat_n(value, self.values_per_component()))
            .collect()
    }

    /// The same for the nodes of one cell, which all cells share.
    pub(super) fn background_of_cell(&self, charge: f64) -> Vec<f64> {
        let per_cell = charge / self.values_per_component() as f64;
        let axis = node_integrals(self.shape());
        (0..D).fold(vec![-per_cell], |products, _| {
            let products = products.iter();
            products
                .flat_map(|product| axis.iter().map(move |integral| product * integral))
                .collect()
        })
    }

    /// Adds `charge` × N_i(x) to every node i.
    #[inline]
    pub(super) fn deposit(&self, charge: f64, x: [f64; D], nodes: &mut [f64]) {
        let last = self.stencil(D - 1, x[D - 1]).values();
        if D == 1 {
            for (place, value) in last {
                nodes[place] += charge * value;
            }
        } else {
            for (row, across) in self.stencil(0, x[0]).values() {
                let charge = charge * across;
                for (place, value) in last.clone() {
                    nodes[row + place] += charge * value;
                }
            }
        }
    }

    /// Σ_i `nodes[i]` N_i(x).
    #[inline]
    pub(super) fn interpolate(&self, nodes: &[f64], x: [f64; D]) -> f64 {
        let last = self.stencil(D - 1, x[D - 1]).values();
        if D == 1 {
            sum(nodes, 0, last)
        } else {
            let first = self.stencil(0, x[0]).values();
            first
                .map(|(row, value)| value * sum(nodes, row, last.clone()))
                .sum()
        }
    }

    /// The gradient of that function at x.
    #[inline]
    pub(super) fn gradient(&self, nodes: &[f64], x: [f64; D]) -> [f64; D] {
        let scale = self.cells_per_length();
        let last = self.stencil(D - 1, x[D - 1]);
        let slopes = last.slopes();
        let mut gradient = [0.0; D];
        if D == 1 {
            gradient[0] = scale * sum(nodes, 0, slopes);
        } else {
            let values = last.values();
            let first = self.stencil(0, x[0]);
            for ((row, value), (_, slope)) in first.values().zip(first.slopes()) {
                gradient[0] += slope * sum(nodes, row, values.clone());
                gradient[D - 1] += value * sum(nodes, row, slopes.clone());
            }
            gradient = gradient.map(|component| component * scale);
        }
        gradient
    }
}

/// Σ weight × node, in the row of nodes that starts at `row`.
#[inline]
fn sum(nodes: &[f64], row: usize, weights: impl Iterator<Item = (usize, f64)>) -> f64 {
    weights
        .map(|(place, weight)| nodes[row + place] * weight)
        .sum()
}

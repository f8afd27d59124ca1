//! Between particles and nodes: charge is deposited, gradients are gathered, by the same shapes.

use super::mesh::Mesh;

impl<const D: usize> Mesh<D> {
    /// Adds `charge` × N_i(x) to every node i.
    #[inline]
    pub(super) fn deposit(&self, charge: f64, x: [f64; D], nodes: &mut [f64]) {
        let degree = self.shape().degree();
        let last = self.stencil(D - 1, x[D - 1]);
        if D == 1 {
            for (place, value, _) in last.touched(degree) {
                nodes[place] += charge * value;
            }
        } else {
            let first = self.stencil(0, x[0]);
            for (row, across, _) in first.touched(degree) {
                let charge = charge * across;
                for (place, value, _) in last.touched(degree) {
                    nodes[row + place] += charge * value;
                }
            }
        }
    }

    /// Σ_i `nodes[i]` N_i(x).
    #[inline]
    pub(super) fn interpolate(&self, nodes: &[f64], x: [f64; D]) -> f64 {
        let degree = self.shape().degree();
        let last = self.stencil(D - 1, x[D - 1]);
        let along = |row: usize| -> f64 {
            let touched = last.touched(degree);
            touched
                .map(|(place, value, _)| nodes[row + place] * value)
                .sum()
        };
        if D == 1 {
            along(0)
        } else {
            let first = self.stencil(0, x[0]);
            let touched = first.touched(degree);
            touched.map(|(row, value, _)| value * along(row)).sum()
        }
    }

    /// The gradient of that function at x.
    #[inline]
    pub(super) fn gradient(&self, nodes: &[f64], x: [f64; D]) -> [f64; D] {
        let degree = self.shape().degree();
        let scale = self.cells_per_length();
        let last = self.stencil(D - 1, x[D - 1]);
        // Value and slope along the last axis, in the row of nodes that starts at `row`.
        let along = |row: usize| -> (f64, f64) {
            let mut sums = (0.0, 0.0);
            for (place, value, slope) in last.touched(degree) {
                sums.0 += nodes[row + place] * value;
                sums.1 += nodes[row + place] * slope;
            }
            sums
        };
        let mut gradient = [0.0; D];
        if D == 1 {
            gradient[0] = scale * along(0).1;
        } else {
            let first = self.stencil(0, x[0]);
            for (row, value, slope) in first.touched(degree) {
                let (across, forward) = along(row);
                gradient[0] += slope * across;
                gradient[D - 1] += value * forward;
            }
            gradient = gradient.map(|component| component * scale);
        }
        gradient
    }
}

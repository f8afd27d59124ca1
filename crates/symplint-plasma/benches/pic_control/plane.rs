//! The same in a plane.

use std::f64::consts::TAU;
use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlanner};

use super::{slopes, values};

/// Equal particles in a square, B-splines of degree 1 to 3, no filter; buffers made once.
pub struct PlainPlane {
    degree: usize,
    cells: usize,
    length: f64,
    weight: f64,
    charge: Vec<f64>,
    modes: Vec<Complex64>,
    column: Vec<Complex64>,
    inverse_stiffness: Vec<f64>,
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    across: [Arc<dyn Fft<f64>>; 2],
}

impl PlainPlane {
    pub fn new(degree: usize, cells: usize, length: f64, weight: f64) -> Self {
        let (mut planner, mut real) = (FftPlanner::new(), RealFftPlanner::new());
        let half = cells / 2 + 1;
        // Stiffness and mass of one axis in units of the cell width, which cancels.
        let axis = |k: usize| {
            let cos = |n: usize| (TAU * (n * k) as f64 / cells as f64).cos();
            let masses = [
                1.0,
                (4.0 + 2.0 * cos(1)) / 6.0,
                (66.0 + 52.0 * cos(1) + 2.0 * cos(2)) / 120.0,
                (2416.0 + 2382.0 * cos(1) + 240.0 * cos(2) + 2.0 * cos(3)) / 5040.0,
            ];
            ((2.0 - 2.0 * cos(1)) * masses[degree - 1], masses[degree])
        };
        let modes = (0..cells).flat_map(|kx| (0..half).map(move |ky| (kx, ky)));
        let inverse_stiffness = modes.map(|(kx, ky)| {
            let (x, y) = (axis(kx), axis(ky));
            let stiffness = (x.0 * y.1 + x.1 * y.0) * (cells * cells) as f64;
            if kx + ky == 0 { 0.0 } else { 1.0 / stiffness }
        });
        PlainPlane {
            degree,
            cells,
            length,
            weight,
            charge: vec![0.0; cells * cells],
            modes: vec![Complex64::ZERO; cells * half],
            column: vec![Complex64::ZERO; cells],
            inverse_stiffness: inverse_stiffness.collect(),
            forward: real.plan_fft_forward(cells),
            inverse: real.plan_fft_inverse(cells),
            across: [
                planner.plan_fft_forward(cells),
                planner.plan_fft_inverse(cells),
            ],
        }
    }

    /// v += τ E(x), both axes of a particle side by side.
    pub fn kick(&mut self, tau: f64, x: &[f64], v: &mut [f64]) {
        let cells = self.cells;
        self.charge.fill(0.0);
        for x in x.as_chunks::<2>().0 {
            let [(cell_x, fraction_x), (cell_y, fraction_y)] = x.map(|x| self.locate(x));
            let (of_x, of_y) = (
                values(self.degree, fraction_x),
                values(self.degree, fraction_y),
            );
            for (i, of_x) in of_x.iter().enumerate().take(self.degree + 1) {
                for (j, of_y) in of_y.iter().enumerate().take(self.degree + 1) {
                    let node = (cell_x + i) % cells * cells + (cell_y + j) % cells;
                    self.charge[node] += self.weight * of_x * of_y;
                }
            }
        }
        self.solve();
        let cells_per_length = cells as f64 / self.length;
        for (x, v) in x.as_chunks::<2>().0.iter().zip(v.as_chunks_mut::<2>().0) {
            let [(cell_x, fraction_x), (cell_y, fraction_y)] = x.map(|x| self.locate(x));
            let (of_x, of_y) = (
                values(self.degree, fraction_x),
                values(self.degree, fraction_y),
            );
            let (slopes_x, slopes_y) = (
                slopes(self.degree, fraction_x),
                slopes(self.degree, fraction_y),
            );
            let mut gradient = [0.0; 2];
            for i in 0..=self.degree {
                for j in 0..=self.degree {
                    let node = (cell_x + i) % cells * cells + (cell_y + j) % cells;
                    gradient[0] += self.charge[node] * slopes_x[i] * of_y[j];
                    gradient[1] += self.charge[node] * of_x[i] * slopes_y[j];
                }
            }
            v[0] -= tau * gradient[0] * cells_per_length;
            v[1] -= tau * gradient[1] * cells_per_length;
        }
    }

    fn locate(&self, x: f64) -> (usize, f64) {
        let position = x.rem_euclid(self.length) / self.length * self.cells as f64;
        let cell = position.floor();
        (cell as usize % self.cells, position - cell)
    }

    fn solve(&mut self) {
        let half = self.cells / 2 + 1;
        let rows = self.charge.chunks_exact_mut(self.cells);
        for (row, modes) in rows.zip(self.modes.chunks_exact_mut(half)) {
            self.forward.process(row, modes).unwrap();
        }
        for (way, plan) in self.across.iter().enumerate() {
            for k in 0..half {
                for (i, value) in self.column.iter_mut().enumerate() {
                    *value = self.modes[i * half + k];
                }
                plan.process(&mut self.column);
                for (i, value) in self.column.iter().enumerate() {
                    self.modes[i * half + k] = *value;
                }
            }
            if way == 0 {
                for (mode, factor) in self.modes.iter_mut().zip(&self.inverse_stiffness) {
                    *mode *= factor;
                }
            }
        }
        let rows = self.charge.chunks_exact_mut(self.cells);
        for (row, modes) in rows.zip(self.modes.chunks_exact_mut(half)) {
            modes[0].im = 0.0;
            modes[half - 1].im = 0.0;
            self.inverse.process(modes, row).unwrap();
        }
    }
}

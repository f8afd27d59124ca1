//! The force of a plasma on a line as a textbook writes it: particle by particle, index by index.

mod plane;

use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex64;

pub use plane::PlainPlane;

/// Equal particles, B-splines of degree 1 to 3, no filter; buffers made once.
pub struct PlainPic {
    degree: usize,
    cells: usize,
    length: f64,
    weight: f64,
    charge: Vec<f64>,
    modes: Vec<Complex64>,
    inverse_stiffness: Vec<f64>,
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    scratch: Vec<Complex64>,
}

impl PlainPic {
    pub fn new(degree: usize, cells: usize, length: f64, weight: f64) -> Self {
        let mut planner = RealFftPlanner::new();
        let forward = planner.plan_fft_forward(cells);
        let inverse = planner.plan_fft_inverse(cells);
        let width = length / cells as f64;
        let inverse_stiffness = (0..=cells / 2).map(|k| {
            let c = (std::f64::consts::TAU * k as f64 / cells as f64).cos();
            let shape = match degree {
                1 => 1.0,
                2 => (2.0 + c) / 3.0,
                3 => (66.0 + 52.0 * c + 2.0 * (2.0 * c * c - 1.0)) / 120.0,
                _ => unreachable!("the control has degrees 1 to 3"),
            };
            let stiffness = (2.0 - 2.0 * c) * shape / width * cells as f64;
            if k == 0 { 0.0 } else { 1.0 / stiffness }
        });
        PlainPic {
            degree,
            cells,
            length,
            weight,
            charge: vec![0.0; cells],
            modes: forward.make_output_vec(),
            inverse_stiffness: inverse_stiffness.collect(),
            scratch: vec![
                Complex64::ZERO;
                forward.get_scratch_len().max(inverse.get_scratch_len())
            ],
            forward,
            inverse,
        }
    }

    /// v += τ E(x). The background is left out: the zero mode drops it.
    pub fn kick(&mut self, tau: f64, x: &[f64], v: &mut [f64]) {
        self.charge.fill(0.0);
        for &x in x {
            let (cell, fraction) = self.locate(x);
            for (j, value) in values(self.degree, fraction).into_iter().enumerate() {
                if j <= self.degree {
                    self.charge[(cell + j) % self.cells] += self.weight * value;
                }
            }
        }
        self.solve();
        let cells_per_length = self.cells as f64 / self.length;
        for (&x, v) in x.iter().zip(v) {
            let (cell, fraction) = self.locate(x);
            let mut slope = 0.0;
            for (j, value) in slopes(self.degree, fraction).into_iter().enumerate() {
                if j <= self.degree {
                    slope += self.charge[(cell + j) % self.cells] * value;
                }
            }
            *v -= tau * slope * cells_per_length;
        }
    }

    /// The first of the nodes that x touches, and where in its cell x is.
    fn locate(&self, x: f64) -> (usize, f64) {
        let position = x.rem_euclid(self.length) / self.length * self.cells as f64;
        let cell = position.floor();
        (cell as usize % self.cells, position - cell)
    }

    fn solve(&mut self) {
        self.forward
            .process_with_scratch(&mut self.charge, &mut self.modes, &mut self.scratch)
            .unwrap();
        for (mode, factor) in self.modes.iter_mut().zip(&self.inverse_stiffness) {
            *mode *= factor;
        }
        self.modes[0].im = 0.0;
        self.modes[self.cells / 2].im = 0.0;
        self.inverse
            .process_with_scratch(&mut self.modes, &mut self.charge, &mut self.scratch)
            .unwrap();
    }
}

fn values(degree: usize, x: f64) -> [f64; 4] {
    let y = 1.0 - x;
    match degree {
        1 => [y, x, 0.0, 0.0],
        2 => [0.5 * y * y, 0.5 + x * y, 0.5 * x * x, 0.0],
        _ => [
            y * y * y / 6.0,
            2.0 / 3.0 - x * x * (1.0 - 0.5 * x),
            2.0 / 3.0 - y * y * (1.0 - 0.5 * y),
            x * x * x / 6.0,
        ],
    }
}

fn slopes(degree: usize, x: f64) -> [f64; 4] {
    let y = 1.0 - x;
    match degree {
        1 => [-1.0, 1.0, 0.0, 0.0],
        2 => [-y, y - x, x, 0.0],
        _ => [
            -0.5 * y * y,
            x * (1.5 * x - 2.0),
            y * (2.0 - 1.5 * y),
            0.5 * x * x,
        ],
    }
}

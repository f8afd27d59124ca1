//! The loop integral as the paper writes it: p : (D q) Δs, with D q by transforming there and back.

use std::f64::consts::TAU;
use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex64;
use symplint::Ensemble;

/// Transforms and buffers, made once.
pub struct PlainIntegral {
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    row: Vec<f64>,
    modes: Vec<Complex64>,
}

impl PlainIntegral {
    pub fn new(samples: usize) -> Self {
        let mut planner = RealFftPlanner::new();
        let forward = planner.plan_fft_forward(samples);
        PlainIntegral {
            inverse: planner.plan_fft_inverse(samples),
            row: forward.make_input_vec(),
            modes: forward.make_output_vec(),
            forward,
        }
    }

    /// Without an estimate of any error.
    pub fn of(&mut self, ensemble: &Ensemble) -> f64 {
        let n = ensemble.samples();
        let mut sum = 0.0;
        for i in 0..ensemble.dof() {
            self.row.copy_from_slice(ensemble.q().row(i));
            self.forward
                .process(&mut self.row, &mut self.modes)
                .unwrap();
            for (k, mode) in self.modes.iter_mut().enumerate() {
                let nyquist = 2 * k == n;
                let k = if nyquist { 0.0 } else { k as f64 };
                *mode *= Complex64::new(0.0, TAU * k);
            }
            self.inverse
                .process(&mut self.modes, &mut self.row)
                .unwrap();
            let p = ensemble.p().row(i);
            sum += self.row.iter().zip(p).map(|(dq, p)| dq * p).sum::<f64>();
        }
        sum / (n * n) as f64
    }
}

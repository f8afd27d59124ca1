//! The Fourier-pseudospectral rule without an inverse transform.
//!
//! With real transforms P, Q of one row each (N samples, unnormalised) the paper's
//! p : (D q) Δs is
//!
//! I = (4π/N²) Σ_{k=1}^{⌈N/2⌉−1} k (Im P_k Re Q_k − Re P_k Im Q_k),
//!
//! with the Nyquist mode of an even N left out. Two real transforms stay accurate where one complex
//! transform of q + i p cancels: when q and p differ in scale.

use std::f64::consts::PI;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use rayon::prelude::*;
use realfft::num_complex::Complex;
use realfft::{RealFftPlanner, RealToComplex};

use super::regularity::sobolev_exponent;
use super::{RowIntegral, UNIT_ROUNDOFF, least, unwrap_row};
use crate::coordinates::Coordinates;
use crate::ensemble::Ensemble;

/// Plans are dear and the same few lengths come again and again.
static PLANNER: LazyLock<Mutex<RealFftPlanner<f64>>> =
    LazyLock::new(|| Mutex::new(RealFftPlanner::new()));

fn plan(samples: usize) -> Arc<dyn RealToComplex<f64>> {
    PLANNER
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .plan_fft_forward(samples)
}

/// Transform buffers of one thread.
struct Workspace {
    transform: Arc<dyn RealToComplex<f64>>,
    scratch: Vec<Complex<f64>>,
    row: Vec<f64>,
    q: Vec<Complex<f64>>,
    p: Vec<Complex<f64>>,
}

impl Workspace {
    fn new(transform: Arc<dyn RealToComplex<f64>>) -> Self {
        Workspace {
            scratch: transform.make_scratch_vec(),
            row: transform.make_input_vec(),
            q: transform.make_output_vec(),
            p: transform.make_output_vec(),
            transform,
        }
    }

    fn integrate(&mut self, q: &[f64], p: &[f64], period: f64) -> RowIntegral {
        let n = q.len() as f64;
        // Taking off the first sample changes no loop integral, and far from the origin it
        // keeps the transform's round-off from growing with the distance.
        shift_into(&mut self.row, q);
        let gain = unwrap_row(&mut self.row, period) as f64 * period;
        if gain != 0.0 {
            for (k, value) in self.row.iter_mut().enumerate() {
                *value -= gain * (k as f64 / n);
            }
        }
        self.transform
            .process_with_scratch(&mut self.row, &mut self.q, &mut self.scratch)
            .expect("buffers come from the plan");
        shift_into(&mut self.row, p);
        self.transform
            .process_with_scratch(&mut self.row, &mut self.p, &mut self.scratch)
            .expect("buffers come from the plan");

        let spectra = Spectra {
            q: &self.q,
            p: &self.p,
            samples: q.len(),
        };
        let mut integral = spectra.integral(largest(q), largest(p));
        if gain != 0.0 {
            let mean = p[0] + self.p[0].re / n;
            integral.value += gain * mean;
            integral.scale += (gain * mean).abs();
            integral.roundoff += 2.0 * UNIT_ROUNDOFF * gain.abs() * largest(p);
            if let Some((coarse, error)) = spectra.coarse_mean_p().zip(integral.quadrature_error) {
                // The highest modes fold back into the mean as into every other mode.
                let folded = spectra.top(&self.p) / n;
                let change = (self.p[0].re / n - coarse).abs().max(folded);
                integral.quadrature_error = Some(error + gain.abs() * change);
            }
        }
        integral
    }
}

/// Writes `values` less the first of them.
fn shift_into(row: &mut [f64], values: &[f64]) {
    let first = values[0];
    for (shifted, &value) in row.iter_mut().zip(values) {
        *shifted = value - first;
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

/// Unnormalised transforms of one degree of freedom, modes 0 … N/2.
struct Spectra<'a> {
    q: &'a [Complex<f64>],
    p: &'a [Complex<f64>],
    samples: usize,
}

impl Spectra<'_> {
    /// `max_q` and `max_p` are the largest coordinates as stored: their rounding is noise in I.
    fn integral(&self, max_q: f64, max_p: f64) -> RowIntegral {
        let n = self.samples as f64;
        let modes = self.samples.div_ceil(2);
        let factor = 4.0 * PI / (n * n);
        let (mut value, mut scale) = (0.0, 0.0);
        let (mut q_slope, mut p_slope) = (0.0, 0.0);
        let (mut q_slope_squared, mut p_slope_squared) = (0.0, 0.0);
        // From the highest mode down: small terms first.
        for k in (1..modes).rev() {
            let (p, q, k) = (self.p[k], self.q[k], k as f64);
            let (p_squared, q_squared) = (p.norm_sqr(), q.norm_sqr());
            value += k * (p.im * q.re - p.re * q.im);
            scale += k * (p_squared * q_squared).sqrt();
            q_slope += k * q_squared.sqrt();
            p_slope += k * p_squared.sqrt();
            q_slope_squared += k * k * q_squared;
            p_slope_squared += k * k * p_squared;
        }
        // Rounding of the stored samples: white noise of half an ulp of the largest.
        let noise = PI * UNIT_ROUNDOFF * (8.0 / n).sqrt() / n;
        let stored = noise * (max_q * p_slope_squared.sqrt() + max_p * q_slope_squared.sqrt());
        let transformed = UNIT_ROUNDOFF * n.log2() * factor * scale;
        RowIntegral {
            value: factor * value,
            quadrature_error: self.coarse_integral().map(|coarse| {
                let (q_top, p_top) = (self.top(self.q), self.top(self.p));
                let folded = factor * (p_top * q_slope + q_top * p_slope);
                (factor * value - coarse).abs().max(self.tail()).max(folded)
            }),
            roundoff: stored + transformed,
            scale: factor * scale,
            omitted: Vec::new(),
            regularity: {
                // A mode of the rounding of the stored samples, with a margin.
                let rounding = 4.0 * UNIT_ROUNDOFF * n.sqrt();
                least(
                    sobolev_exponent(&self.q[1..modes], rounding * max_q),
                    sobolev_exponent(&self.p[1..modes], rounding * max_p),
                )
            },
        }
    }

    /// The same integral from every second sample (from the lower half of the modes where N is
    /// odd); `None` where that leaves fewer than three.
    fn coarse_integral(&self) -> Option<f64> {
        let half = self.samples / 2;
        if half < 3 {
            return None;
        }
        let modes = half.div_ceil(2);
        let n = half as f64;
        let mut value = 0.0;
        for k in (1..modes).rev() {
            let (p, q) = (self.coarse(self.p, k), self.coarse(self.q, k));
            value += k as f64 * (p.im * q.re - p.re * q.im);
        }
        Some(4.0 * PI / (n * n) * value)
    }

    /// Mean of p, less its first sample, from every second sample.
    fn coarse_mean_p(&self) -> Option<f64> {
        let half = self.samples / 2;
        (half >= 3).then(|| self.coarse(self.p, 0).re / half as f64)
    }

    /// Mode k of the transform of every second sample: modes k and k + N/2 fold together.
    fn coarse(&self, spectrum: &[Complex<f64>], k: usize) -> Complex<f64> {
        if self.samples.is_multiple_of(2) {
            (spectrum[k] + spectrum[self.samples / 2 - k].conj()) / 2.0
        } else {
            spectrum[k] * (self.samples / 2) as f64 / self.samples as f64
        }
    }

    /// Root mean square of the highest quarter of the modes: a jump or kink that the samples do
    /// not resolve, or the noise of the states. Modes beyond N/2 fold back with about this size.
    fn top(&self, spectrum: &[Complex<f64>]) -> f64 {
        let modes = self.samples.div_ceil(2);
        let top = &spectrum[(3 * modes / 4).max(1).min(modes - 1)..modes];
        let sum: f64 = top.iter().map(|mode| mode.norm_sqr()).sum();
        (sum / top.len() as f64).sqrt()
    }

    /// Absolute sum over the upper half of the modes: what still arrives at the end of the band.
    fn tail(&self) -> f64 {
        let n = self.samples as f64;
        let modes = self.samples.div_ceil(2);
        let sum: f64 = (modes / 2..modes)
            .map(|k| k as f64 * (self.p[k].norm_sqr() * self.q[k].norm_sqr()).sqrt())
            .sum();
        4.0 * PI / (n * n) * sum
    }
}

pub(super) fn rows(ensemble: &Ensemble, coordinates: &Coordinates) -> Vec<RowIntegral> {
    let transform = plan(ensemble.samples());
    let (q, p) = (ensemble.q(), ensemble.p());
    (0..ensemble.dof())
        .into_par_iter()
        .map_init(
            || Workspace::new(Arc::clone(&transform)),
            |workspace, i| workspace.integrate(q.row(i), p.row(i), coordinates.period(i)),
        )
        .collect()
}

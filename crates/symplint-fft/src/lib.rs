//! Fourier transforms in double precision.
//!
//! `rustfft` and `realfft` are generic: each crate that plans a transform compiles all their algorithms anew, which took a quarter of
//! the build of `symplint`, and as much again of each crate that depends on it. This crate compiles them once. Each function makes a
//! new planner: one that has planned other lengths builds on those, with other last bits.
//!
//! ```
//! use symplint_fft::{Complex64, forward};
//!
//! let mut values = [1.0, 0.0, 0.0, 0.0].map(|re| Complex64::new(re, 0.0));
//! forward(4).process(&mut values);
//! assert_eq!(values, [Complex64::new(1.0, 0.0); 4]);
//! ```

use std::sync::Arc;

use realfft::RealFftPlanner;
pub use realfft::{ComplexToReal, RealToComplex};
pub use rustfft::Fft;
use rustfft::FftPlanner;
pub use rustfft::num_complex::{self, Complex64};

/// X_k = Σ_j x_j e^{−2πi jk/n} of `len` = n complex numbers.
pub fn forward(len: usize) -> Arc<dyn Fft<f64>> {
    FftPlanner::new().plan_fft_forward(len)
}

/// The same with e^{+2πi jk/n}, not divided by n.
pub fn inverse(len: usize) -> Arc<dyn Fft<f64>> {
    FftPlanner::new().plan_fft_inverse(len)
}

/// The coefficients X_0 … X_⌊n/2⌋ of `len` = n real numbers.
pub fn real_forward(len: usize) -> Arc<dyn RealToComplex<f64>> {
    RealFftPlanner::new().plan_fft_forward(len)
}

/// `len` real numbers from such coefficients, not divided by their number.
pub fn real_inverse(len: usize) -> Arc<dyn ComplexToReal<f64>> {
    RealFftPlanner::new().plan_fft_inverse(len)
}

//! The field solve on an even number of cells with one node each, by transforms of half the length.
//!
//! With z_j = x_2j + i x_2j+1 and Z its transform, the solve x ↦ G x, whose eigenvalue in mode k
//! of n = 2 h is g_k = g_n−k, is
//!
//! Z_k ↦ (s − d sin θ) Z_k + i d cos θ conj Z_h−k, with θ = 2π k / n, s ± d = g_k, g_h−k:
//!
//! the modes of x itself are never needed.

use std::f64::consts::TAU;
use std::sync::Arc;

use bytemuck::cast_slice_mut;
use multiversion::multiversion;
use num_complex::Complex64;
use symplint_fft::Fft;

use super::scratch::with_complex_buffer;

/// Such a solve.
#[derive(Clone)]
pub(super) struct PackedSolver {
    /// For each mode of z, what multiplies it and its mirror image.
    factors: Vec<[f64; 2]>,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    scratch: usize,
}

impl PackedSolver {
    /// By the eigenvalues of the half spectrum over the number of cells, which is even.
    pub(super) fn new(eigenvalues: &[f64]) -> Self {
        let half = eigenvalues.len() - 1;
        let factors = (0..half).map(|k| {
            let (here, there) = (eigenvalues[k], eigenvalues[half - k]);
            let (sin, cos) = (TAU * k as f64 / (2 * half) as f64).sin_cos();
            // Twice the halves: over half the cells goes the transform.
            let (sum, difference) = (here + there, here - there);
            [sum - difference * sin, difference * cos]
        });
        let forward = symplint_fft::forward(half);
        let inverse = symplint_fft::inverse(half);
        let scratch = (forward.get_inplace_scratch_len()).max(inverse.get_outofplace_scratch_len());
        PackedSolver {
            factors: factors.collect(),
            forward,
            inverse,
            scratch,
        }
    }

    /// Turns the charges of the nodes into their potentials, in place.
    pub(super) fn solve(&self, nodes: &mut [f64]) {
        let packed: &mut [Complex64] = cast_slice_mut(nodes);
        with_complex_buffer(packed.len() + self.scratch, |buffer| {
            let (solved, scratch) = buffer.split_at_mut(packed.len());
            self.forward.process_with_scratch(packed, scratch);
            multiply(&self.factors, packed, solved);
            (self.inverse).process_outofplace_with_scratch(solved, packed, scratch);
        });
    }
}

/// Each mode and its mirror image times their factors.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn multiply(factors: &[[f64; 2]], modes: &[Complex64], solved: &mut [Complex64]) {
    solved[0] = product(&factors[0], &modes[0], &modes[0]);
    let (factors, modes) = (factors[1..].iter(), &modes[1..]);
    let pairs = modes.iter().zip(modes.iter().rev());
    for ((solved, factors), (mode, mirror)) in solved[1..].iter_mut().zip(factors).zip(pairs) {
        *solved = product(factors, mode, mirror);
    }
}

#[inline(always)]
fn product([by, mirrored_by]: &[f64; 2], mode: &Complex64, mirror: &Complex64) -> Complex64 {
    Complex64::new(
        by * mode.re + mirrored_by * mirror.im,
        by * mode.im + mirrored_by * mirror.re,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Σ_k (2 − δ) g_k cos(2π k (i − j) / n) x_j, the solve as a sum.
    #[test]
    fn it_is_the_circulant_matrix() {
        for half in (1..20).chain([50, 77]) {
            let n = 2 * half;
            let eigenvalues: Vec<f64> = (0..=half).map(|k| 1.0 / (1 + 3 * k) as f64).collect();
            let x: Vec<f64> = (0..n).map(|j| ((j * j) as f64).sin()).collect();
            let mut solved = x.clone();
            PackedSolver::new(&eigenvalues).solve(&mut solved);
            for (i, solved) in solved.iter().enumerate() {
                let entry = |j: usize| -> f64 {
                    let modes = (0..n).map(|k| {
                        let phase = (k * (n + i - j) % n) as f64 / n as f64;
                        eigenvalues[k.min(n - k)] * (TAU * phase).cos()
                    });
                    modes.sum()
                };
                let expected: f64 = (0..n).map(|j| entry(j) * x[j]).sum();
                assert!(
                    (solved - expected).abs() < 1e-13 * n as f64,
                    "{n}: {solved}"
                );
            }
        }
    }
}

//! Mass matrices of the two spline spaces, which are circulant, and their inverses.

use std::f64::consts::TAU;
use std::sync::Arc;

use num_complex::Complex64;
use symplint::state::scratch::with_buffer;
use symplint_fft::Fft;

use super::electromagnetic::Fields;
use super::overlap::overlaps;

/// M0 of V0 (degree p) and M1 of V1 (degree p − 1, functions divided by the cell width) on a periodic grid, as [`Fields`]
/// says.
///
/// Rows of a circulant matrix are one row shifted, and Fourier modes are its eigenvectors.
#[derive(Clone)]
pub(super) struct MassMatrices {
    width: f64,
    /// M0 / width, from the diagonal outwards.
    zero: Vec<f64>,
    /// M1 × width, from the diagonal outwards.
    one: Vec<f64>,
    /// Half the sum and half the difference of the inverse eigenvalues of `one` and `zero`, over the number of cells.
    inverses: Vec<[f64; 2]>,
    forward: Arc<dyn Fft<f64>>,
    backward: Arc<dyn Fft<f64>>,
    scratch: usize,
}

impl MassMatrices {
    pub(super) fn new(fields: Fields, degree: usize, cells: usize, width: f64) -> Self {
        let from_diagonal = |degree: usize| match fields {
            Fields::FiniteElement => overlaps(degree, degree)[degree..].to_vec(),
            Fields::Yee => vec![1.0],
        };
        let (zero, one) = (from_diagonal(degree), from_diagonal(degree - 1));
        let eigenvalue = |entries: &[f64], k: usize| -> f64 {
            let off_diagonal = (1..entries.len()).map(|j| {
                let turns = (k * j % cells) as f64 / cells as f64;
                2.0 * entries[j] * (TAU * turns).cos()
            });
            entries[0] + off_diagonal.sum::<f64>()
        };
        let inverses = (0..cells).map(|k| {
            let [one, zero] = [&one, &zero].map(|entries| 0.5 / eigenvalue(entries, k));
            [one + zero, one - zero].map(|factor| factor / cells as f64)
        });
        let forward = symplint_fft::forward(cells);
        let backward = symplint_fft::inverse(cells);
        MassMatrices {
            width,
            inverses: inverses.collect(),
            scratch: (forward.get_inplace_scratch_len()).max(backward.get_inplace_scratch_len()),
            forward,
            backward,
            zero,
            one,
        }
    }

    /// Row 0 of M0, from the diagonal outwards, over the cell width.
    pub(super) fn zero(&self) -> &[f64] {
        &self.zero
    }

    /// Row 0 of M1, from the diagonal outwards, times the cell width.
    pub(super) fn one(&self) -> &[f64] {
        &self.one
    }

    /// M1⁻¹ `one` and M0⁻¹ `zero`, in place. Both in one complex transform: the eigenvalues of both matrices are real.
    pub(super) fn solve(&self, one: &mut [f64], zero: &mut [f64]) {
        let cells = self.inverses.len();
        with_buffer(2 * (2 * cells + self.scratch), |buffer| {
            let buffer: &mut [Complex64] = bytemuck::cast_slice_mut(buffer);
            let (modes, rest) = buffer.split_at_mut(cells);
            let (solved, scratch) = rest.split_at_mut(cells);
            // Without the cell width, both parts have the same size where both fields have.
            let (to_one, to_zero) = (self.width, 1.0 / self.width);
            for ((mode, one), zero) in modes.iter_mut().zip(&*one).zip(&*zero) {
                *mode = Complex64::new(to_one * one, to_zero * zero);
            }
            self.forward.process_with_scratch(modes, scratch);
            for (k, (solved, [half_sum, half_difference])) in
                solved.iter_mut().zip(&self.inverses).enumerate()
            {
                let mirror = modes[if k == 0 { 0 } else { cells - k }].conj();
                *solved = half_sum * modes[k] + half_difference * mirror;
            }
            self.backward.process_with_scratch(solved, scratch);
            for ((one, zero), solved) in one.iter_mut().zip(zero).zip(solved) {
                (*one, *zero) = (solved.re, solved.im);
            }
        });
    }

    /// (M0 + `factor` Cᵀ M1 C)⁻¹ `right`, in place.
    pub(super) fn solve_wave(&self, factor: f64, right: &mut [f64]) {
        let cells = self.inverses.len();
        with_buffer(2 * (cells + self.scratch), |buffer| {
            let buffer: &mut [Complex64] = bytemuck::cast_slice_mut(buffer);
            let (modes, scratch) = buffer.split_at_mut(cells);
            for (mode, right) in modes.iter_mut().zip(&*right) {
                *mode = Complex64::from(*right);
            }
            self.forward.process_with_scratch(modes, scratch);
            for (k, (mode, [half_sum, half_difference])) in
                modes.iter_mut().zip(&self.inverses).enumerate()
            {
                // Inverse eigenvalues of M1 × width and of M0 / width, over the number of cells.
                let (one, zero) = (half_sum + half_difference, half_sum - half_difference);
                let sine = (0.5 * TAU * k as f64 / cells as f64).sin();
                let curl = factor * 4.0 * sine * sine / (self.width * one);
                *mode /= self.width / zero + curl;
            }
            self.backward.process_with_scratch(modes, scratch);
            for (right, mode) in right.iter_mut().zip(modes) {
                *right = mode.re;
            }
        });
    }
}

/// Σ_k `entries[|k|]` `values[i + k]` on a circle: a symmetric circulant matrix times a vector, at row i.
pub(super) fn product_at(entries: &[f64], values: &[f64], i: usize) -> f64 {
    let cells = values.len();
    let beside = (1..entries.len()).map(|k| {
        let shift = k % cells;
        entries[k] * (values[(i + shift) % cells] + values[(i + cells - shift) % cells])
    });
    entries[0] * values[i] + beside.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solved_waves_have_their_right_hand_sides() {
        let (cells, width, factor) = (11, 0.3, 0.7);
        for degree in 1..=5 {
            let masses = MassMatrices::new(Fields::FiniteElement, degree, cells, width);
            let right: Vec<f64> = (0..cells).map(|j| (0.9 * (j * j) as f64).sin()).collect();
            let mut field = right.clone();
            masses.solve_wave(factor, &mut field);
            let differences: Vec<f64> = (0..cells)
                .map(|j| field[j] - field[(j + cells - 1) % cells])
                .collect();
            let curl = |j| product_at(masses.one(), &differences, j) / width;
            for (j, right) in right.iter().enumerate() {
                let found = product_at(masses.zero(), &field, j) * width
                    + factor * (curl(j) - curl((j + 1) % cells));
                assert!(
                    (found - right).abs() < 1e-14,
                    "degree {degree}: {found} for {right}"
                );
            }
        }
    }

    /// Matrices as they are, entry by entry, and a solve by its definition.
    #[test]
    fn solved_systems_have_their_right_hand_sides() {
        for degree in 1..=5 {
            for cells in (1..=12).chain([31, 64]) {
                let width = 0.07;
                let masses = MassMatrices::new(Fields::FiniteElement, degree, cells, width);
                // Fields of one size.
                let right = |seed: f64, size: f64| -> Vec<f64> {
                    (0..cells)
                        .map(|j| size * (seed * (j * j + 1) as f64).sin())
                        .collect()
                };
                let (one, zero) = (right(0.7, 1.0 / width), right(1.3, width));
                let (mut e1, mut e2) = (one.clone(), zero.clone());
                masses.solve(&mut e1, &mut e2);
                for i in 0..cells {
                    let [got_one, got_zero] = [
                        product_at(masses.one(), &e1, i) / width,
                        product_at(masses.zero(), &e2, i) * width,
                    ];
                    assert!(
                        (got_one - one[i]).abs() < 1e-13 / width
                            && (got_zero - zero[i]).abs() < 1e-13 * width,
                        "degree {degree}, {cells} cells: {got_one} for {}, {got_zero} for {}",
                        one[i],
                        zero[i]
                    );
                }
            }
        }
    }
}

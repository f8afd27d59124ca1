//! The force between few particles, pair by pair, without a mesh or a transform.
//!
//! The force between two particles depends on the distance of their cells and on the fractions of
//! those at which they sit: on the second by one polynomial, for each of the first's moments.

use symplint::state::{Rows, RowsMut};

use super::field::FieldSolver;
use super::place::Locator;
use super::polynomials::{CellPolynomials, add_particle, gradient_at};

/// The gradients on all cells that the moments of one cell and their share of background make.
#[derive(Clone, Debug)]
pub(super) struct PairTable {
    cells: usize,
    /// For each distance in cells and each moment, the coefficients of the gradient's powers, the last
    /// of them 0.
    gradients: Vec<f64>,
}

impl PairTable {
    /// Particles at most: their places are kept on the stack.
    const MAX_PARTICLES: usize = 64;

    /// Whether this is the fastest way to the force.
    pub(super) fn is_faster(particles: usize, polynomials: &CellPolynomials, cells: usize) -> bool {
        /// Pairs times functions, for each cell, up to which they measure faster than a transform over
        /// the cells, at degrees 1 to 3.
        const PRODUCTS_PER_CELL: usize = 5;
        /// Values of a table that stays in a cache.
        const MAX_VALUES: usize = 1 << 16;
        let functions = polynomials.functions();
        let products = particles * particles * functions;
        particles <= Self::MAX_PARTICLES
            && products <= PRODUCTS_PER_CELL * cells
            && functions * polynomials.table_len() <= MAX_VALUES
    }

    /// On `cells` cells, with the backgrounds of a charge of 1 and of none.
    pub(super) fn new<const N: usize>(
        cells: usize,
        [background, none]: &[Vec<f64>; 2],
        polynomials: &CellPolynomials,
        solver: &FieldSolver,
    ) -> Self {
        let mut gradients = vec![0.0; cells * N * N];
        let mut work = vec![0.0; polynomials.work_len(none.len())];
        for moment in 0..N {
            let mut table = vec![0.0; polynomials.table_len()];
            table[moment] = 1.0;
            // Only the zeroth power has a charge: the functions sum to 1.
            let mut nodes = if moment == 0 { background } else { none }.clone();
            polynomials.deposit::<N>(&table, &mut nodes, &mut work);
            solver.solve(&mut nodes);
            polynomials.gradients::<N>(&nodes, &mut table, &mut work);
            for (distance, matrix) in gradients.chunks_exact_mut(N * N).enumerate() {
                for n in 0..N - 1 {
                    matrix[moment * N + n] = table[n * cells + distance];
                }
            }
        }
        PairTable { cells, gradients }
    }

    /// p −= τ × the gradient at the particles, for every sample.
    pub(super) fn kick<const N: usize>(
        &self,
        locator: &Locator,
        weights: &[f64],
        tau: f64,
        q: Rows<'_>,
        p: &mut RowsMut<'_>,
    ) {
        let particles = weights.len();
        let (mut x, mut fractions) = ([0.0; Self::MAX_PARTICLES], [0.0; Self::MAX_PARTICLES]);
        let (mut cells, mut moments) = ([0; Self::MAX_PARTICLES], [[0.0; N]; Self::MAX_PARTICLES]);
        let (x, fractions) = (&mut x[..particles], &mut fractions[..particles]);
        let (cells, moments) = (&mut cells[..particles], &mut moments[..particles]);
        let matrices: &[[[f64; N]; N]] = self.gradients.as_chunks().0.as_chunks().0;
        for sample in 0..q.len() {
            for (a, x) in x.iter_mut().enumerate() {
                *x = q.row(a)[sample];
            }
            locator.locate(x, cells, fractions);
            moments.fill([0.0; N]);
            for ((moments, &weight), &fraction) in moments.iter_mut().zip(weights).zip(&*fractions)
            {
                add_particle(moments, weight, fraction);
            }
            for (a, (&cell, &fraction)) in cells.iter().zip(&*fractions).enumerate() {
                let mut gradient = [0.0; N];
                for (moments, &source) in moments.iter().zip(&*cells) {
                    let turn = if cell < source { self.cells } else { 0 };
                    let distance = cell as usize + turn - source as usize;
                    add_products(moments, &matrices[distance], &mut gradient);
                }
                p.row_mut(a)[sample] -= tau * gradient_at::<N>(&gradient, 1, 0, fraction);
            }
        }
    }
}

/// Adds Σ_i `factors[i]` × `rows[i]` to `sums`.
#[inline]
fn add_products<const N: usize>(factors: &[f64; N], rows: &[[f64; N]; N], sums: &mut [f64; N]) {
    for (factor, row) in factors.iter().zip(rows) {
        for (sum, value) in sums.iter_mut().zip(row) {
            *sum += factor * value;
        }
    }
}

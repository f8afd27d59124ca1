//! The force between few particles, pair by pair, without a mesh or a transform.
//!
//! The force between two particles depends on the distance of their cells and on the fractions of
//! those at which they sit: on the second by one polynomial, for each of the first's moments.

use multiversion::multiversion;
use symplint::state::{Rows, RowsMut};

use super::field::FieldSolver;
use super::line::GROUP;
use super::place::{Locator, Places};
use super::polynomials::{CellPolynomials, add_particle};

/// Samples that are kicked together if they have one or two particles.
pub(super) const LARGE_GROUP: usize = 32;

/// Particles of all samples that are kicked together, at most: their places are kept on the stack.
const PLACES: usize = 64;

/// The gradients on all cells that the moments of one cell and their share of background make.
#[derive(Clone, Debug)]
pub(super) struct PairTable {
    /// For each distance in cells and each moment, the coefficients of the gradient's powers, the last
    /// of them 0.
    gradients: Vec<f64>,
}

impl PairTable {
    /// Whether this is the fastest way to the force.
    pub(super) fn is_faster(particles: usize, polynomials: &CellPolynomials, cells: usize) -> bool {
        /// Pairs times functions, for each cell, up to which they measure faster than a transform over
        /// the cells, at degrees 1 to 3.
        const PRODUCTS_PER_CELL: usize = 5;
        /// Values of a table that stays in a cache.
        const MAX_VALUES: usize = 1 << 16;
        let functions = polynomials.functions();
        let products = particles * particles * functions;
        particles <= PLACES
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
        PairTable { gradients }
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
        let (most, mut first) = (PLACES / weights.len().max(1), 0);
        if most >= LARGE_GROUP {
            self.kick_groups::<N, LARGE_GROUP>(locator, weights, tau, &mut first, q, p);
        }
        if most >= GROUP {
            self.kick_groups::<N, GROUP>(locator, weights, tau, &mut first, q, p);
        }
        self.kick_groups::<N, 1>(locator, weights, tau, &mut first, q, p);
    }

    /// Kicks samples from `first` on, `W` at a time, and moves `first` behind the last of them.
    fn kick_groups<const N: usize, const W: usize>(
        &self,
        locator: &Locator,
        weights: &[f64],
        tau: f64,
        first: &mut usize,
        q: Rows<'_>,
        p: &mut RowsMut<'_>,
    ) {
        while *first + W <= q.len() {
            self.kick_group::<N, W>(locator, weights, tau, *first, q, p);
            *first += W;
        }
    }

    /// Kicks `W` neighbouring samples, from sample `first` on.
    fn kick_group<const N: usize, const W: usize>(
        &self,
        locator: &Locator,
        weights: &[f64],
        tau: f64,
        first: usize,
        q: Rows<'_>,
        p: &mut RowsMut<'_>,
    ) {
        let (mut cells, mut fractions) = ([0; PLACES], [0.0; PLACES]);
        let particles = 0..weights.len();
        let places = locator.places(q, first, particles, &mut cells, &mut fractions);
        let mut gradients = [0.0; PLACES];
        let (gradients, _) = gradients.as_chunks_mut::<W>();
        let matrices = self.gradients.as_chunks().0.as_chunks().0;
        sum_pairs::<N, W>(matrices, places, weights, gradients);
        for (a, gradients) in gradients[..weights.len()].iter().enumerate() {
            let row = &mut p.row_mut(a)[first..][..W];
            for (v, gradient) in row.iter_mut().zip(gradients) {
                *v -= tau * gradient;
            }
        }
    }
}

/// The gradients at particles, by the matrices of a [`PairTable`].
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn sum_pairs<const N: usize, const W: usize>(
    matrices: &[[[f64; N]; N]],
    places: Places<'_, W>,
    weights: &[f64],
    gradients: &mut [[f64; W]],
) {
    let mut moments = [[0.0; N]; PLACES];
    let (moments, _) = moments.as_chunks_mut::<W>();
    for ((moments, (_, fractions)), &weight) in moments.iter_mut().zip(places.iter()).zip(weights) {
        for (moments, &fraction) in moments.iter_mut().zip(fractions) {
            add_particle(moments, weight, fraction);
        }
    }
    for ((cells, fractions), gradients) in places.iter().zip(gradients) {
        for sample in 0..W {
            let mut gradient = [0.0; N];
            for (moments, (sources, _)) in moments.iter().zip(places.iter()) {
                let (cell, source) = (cells[sample] as usize, sources[sample] as usize);
                let turn = if cell < source { matrices.len() } else { 0 };
                add_products(
                    &moments[sample],
                    &matrices[cell + turn - source],
                    &mut gradient,
                );
            }
            // With the last power, which is 0: all of them fill a vector.
            let powers = gradient.iter().rev();
            gradients[sample] = powers.fold(0.0, |sum, power| sum * fractions[sample] + power);
        }
    }
}

/// Adds Σ_i `factors[i]` × `rows[i]` to `sums`.
#[inline(always)]
fn add_products<const N: usize>(factors: &[f64; N], rows: &[[f64; N]; N], sums: &mut [f64; N]) {
    for (factor, row) in factors.iter().zip(rows) {
        for (sum, value) in sums.iter_mut().zip(row) {
            *sum += factor * value;
        }
    }
}

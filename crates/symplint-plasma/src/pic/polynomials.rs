//! Between the nodes of a line and polynomials on its cells.
//!
//! On one cell, every basis function is a polynomial of the fraction f of the cell. So a particle
//! of charge w need only add w, w f, … w f^p to the moments of its cell: what the nodes get of them
//! is a fixed combination, taken once for each cell and not for each particle. Likewise the
//! gradient of a potential on a cell is one polynomial for all particles in it.
//!
//! `N` is p + 1 everywhere: the functions on a cell, and the powers that span them. In a table of
//! moments those of a cell lie side by side, for every particle adds to all of them. A table of
//! gradients has one row of cells for each power but the last, which a gradient has no use for:
//! rows are what vectors are made of.

use super::mesh::Mesh;

/// How the functions on a cell are polynomials, and to which nodes they belong.
#[derive(Clone, Debug)]
pub(super) struct CellPolynomials {
    cells: usize,
    /// For each function, where the row of its nodes starts for cell 0, in a table of nodes with
    /// every row written twice: so the row continues for all cells without being wrapped.
    starts: Vec<usize>,
    /// For each function, the coefficients of its powers.
    values: Vec<f64>,
    /// For each power of the gradient, what the functions contribute.
    slopes: Vec<f64>,
}

impl CellPolynomials {
    pub(super) fn new<const D: usize>(mesh: &Mesh<D>) -> Self {
        let (cells, degree) = (mesh.cells(), mesh.shape().degree());
        let powers = mesh.shape().powers();
        let functions = 0..=degree;
        let slope = |n: usize, j: usize| (n + 1) as f64 * powers[n + 1][j];
        CellPolynomials {
            cells,
            starts: (mesh.places(D - 1, 0)[functions.clone()].iter())
                .map(|place| place / cells * 2 * cells + place % cells)
                .collect(),
            values: (functions.clone())
                .flat_map(|j| powers[..=degree].iter().map(move |row| row[j]))
                .collect(),
            slopes: (0..degree)
                .flat_map(|n| functions.clone().map(move |j| slope(n, j)))
                .map(|slope| slope * mesh.cells_per_length())
                .collect(),
        }
    }

    /// Functions on a cell.
    pub(super) fn functions(&self) -> usize {
        self.starts.len()
    }

    /// Values of a table, of moments or of gradients.
    pub(super) fn table_len(&self) -> usize {
        self.functions() * self.cells
    }

    /// Values of working memory for `nodes` nodes.
    pub(super) fn work_len(&self, nodes: usize) -> usize {
        self.table_len() + 2 * nodes
    }

    /// Adds to the nodes the charge of which `table` has the moments.
    pub(super) fn deposit<const N: usize>(
        &self,
        table: &[f64],
        nodes: &mut [f64],
        work: &mut [f64],
    ) {
        let cells = self.cells;
        let (rows, twice) = work.split_at_mut(self.table_len());
        for (n, row) in rows.chunks_exact_mut(cells).enumerate() {
            for (value, moments) in row.iter_mut().zip(table.as_chunks::<N>().0) {
                *value = moments[n];
            }
        }
        let powers: [&[f64]; N] = std::array::from_fn(|n| &rows[n * cells..][..cells]);
        twice.fill(0.0);
        for (&start, coefficients) in self.starts.iter().zip(self.values.as_chunks().0) {
            add_products(coefficients, powers, &mut twice[start..][..cells]);
        }
        let rows = nodes.chunks_exact_mut(cells);
        for (row, twice) in rows.zip(twice.chunks_exact(2 * cells)) {
            let (once, again) = twice.split_at(cells);
            for ((node, once), again) in row.iter_mut().zip(once).zip(again) {
                *node += once + again;
            }
        }
    }

    /// Writes the gradient of the nodes' function on every cell into `table`.
    pub(super) fn gradients<const N: usize>(
        &self,
        nodes: &[f64],
        table: &mut [f64],
        work: &mut [f64],
    ) {
        let cells = self.cells;
        let (_, twice) = work.split_at_mut(self.table_len());
        let rows = nodes.chunks_exact(cells);
        for (row, twice) in rows.zip(twice.chunks_exact_mut(2 * cells)) {
            let (once, again) = twice.split_at_mut(cells);
            once.copy_from_slice(row);
            again.copy_from_slice(row);
        }
        let functions: [&[f64]; N] = std::array::from_fn(|j| &twice[self.starts[j]..][..cells]);
        let rows = table.chunks_exact_mut(cells);
        for (row, contributions) in rows.zip(self.slopes.as_chunks().0) {
            row.fill(0.0);
            add_products(contributions, functions, row);
        }
    }
}

/// Adds Σ_i `factors[i]` × `rows[i]` to `sums`, which is as long as the rows.
#[inline]
fn add_products<const N: usize>(factors: &[f64; N], rows: [&[f64]; N], sums: &mut [f64]) {
    let rows = rows.map(|row| &row[..sums.len()]);
    for (i, sum) in sums.iter_mut().enumerate() {
        let mut products = 0.0;
        for n in 0..N {
            products += factors[n] * rows[n][i];
        }
        *sum += products;
    }
}

/// Adds a particle to the moments of its cell.
#[inline(always)]
pub(super) fn add_particle<const N: usize>(moments: &mut [f64; N], weight: f64, fraction: f64) {
    let mut power = weight;
    for moment in moments {
        *moment += power;
        power *= fraction;
    }
}

/// The gradient at a fraction of a cell, from a table for `cells` cells.
#[inline(always)]
pub(super) fn gradient_at<const N: usize>(
    table: &[f64],
    cells: usize,
    cell: usize,
    fraction: f64,
) -> f64 {
    let powers = (0..N - 1).rev();
    powers.fold(0.0, |sum, n| sum * fraction + table[n * cells + cell])
}

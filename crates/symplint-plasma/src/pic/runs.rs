//! The nodes of an axis in one row, so that those which a particle touches lie side by side.
//!
//! For Lagrange elements the nodes of a cell come one after the other, for splines the first that
//! reaches into a cell takes the place of its cell. Either way the functions on cell c are a run of
//! p + 1 places from c × (nodes of a cell) on. What runs beyond the last cell is at its end as a ghost of the first
//! nodes: nothing is wrapped for a particle.
//!
//! Splines are so numbered p places further than in a mesh. A field solve does not
//! mind, as it commutes with shifts by cells.
//!
//! `N` is p + 1 everywhere. Functions are taken as polynomials of the distance from the middle of the
//! cell: from an end of it, terms larger than their sum would cost Lagrange elements a digit.

use super::mesh::Mesh;

/// The numbering of one axis, and its functions.
#[derive(Clone, Debug)]
pub(super) struct Runs {
    cells: usize,
    /// Nodes of a cell.
    step: usize,
    functions: usize,
    /// For each power of the distance, its coefficient in each function.
    values: Vec<f64>,
    /// For each power of the gradient, what a node of each function contributes.
    slopes: Vec<f64>,
}

/// The functions of a cell, for a degree that the compiler knows.
#[derive(Clone, Copy)]
pub(super) struct RunFunctions<'a, const N: usize> {
    step: usize,
    values: &'a [[f64; N]; N],
    /// One power fewer.
    slopes: &'a [[f64; N]],
}

impl Runs {
    pub(super) fn new<const D: usize>(mesh: &Mesh<D>) -> Self {
        let functions = mesh.shape().degree() + 1;
        let powers = about_the_middle(mesh.shape().powers());
        let slope = |n: usize, j: usize| n as f64 * powers[n][j] * mesh.cells_per_length();
        Runs {
            cells: mesh.cells(),
            step: mesh.shape().nodes_per_cell(),
            functions,
            values: (powers[..functions].iter())
                .flat_map(|row| row[..functions].iter().copied())
                .collect(),
            slopes: (1..functions)
                .flat_map(|n| (0..functions).map(move |j| slope(n, j)))
                .collect(),
        }
    }

    /// Cells.
    pub(super) fn cells(&self) -> usize {
        self.cells
    }

    /// Nodes of a cell.
    pub(super) fn step(&self) -> usize {
        self.step
    }

    /// Functions on a cell.
    pub(super) fn functions(&self) -> usize {
        self.functions
    }

    /// Nodes, each once.
    pub(super) fn nodes(&self) -> usize {
        self.step * self.cells
    }

    /// Nodes and ghosts.
    pub(super) fn len(&self) -> usize {
        self.nodes() + self.functions - self.step
    }

    /// A value for each node of a cell as a row, if it is the same in all cells; ghosts have no value.
    pub(super) fn in_all_cells(&self, of_cell: &[f64]) -> Vec<f64> {
        let mut row = of_cell.repeat(self.cells);
        row.resize(self.len(), 0.0);
        row
    }

    /// The functions.
    ///
    /// # Panics
    /// If there are not `N` on a cell.
    #[inline]
    pub(super) fn of<const N: usize>(&self) -> RunFunctions<'_, N> {
        assert!(N == self.functions);
        let values = self.values.as_chunks().0.first_chunk();
        RunFunctions {
            step: self.step,
            values: values.expect("as many powers as functions"),
            slopes: self.slopes.as_chunks().0,
        }
    }

    /// Adds ghosts to the nodes whose they are, in a row of `width` values for each place.
    #[inline]
    pub(super) fn fold(&self, row: &mut [f64], width: usize) {
        let (nodes, len) = (width * self.nodes(), width * self.len());
        // From the end: on few cells, ghosts are of ghosts.
        for ghost in (nodes..len).rev() {
            row[ghost - nodes] += row[ghost];
        }
    }

    /// Copies nodes to their ghosts, in such a row.
    #[inline]
    pub(super) fn unfold(&self, row: &mut [f64], width: usize) {
        let (nodes, len) = (width * self.nodes(), width * self.len());
        for ghost in nodes..len {
            row[ghost] = row[ghost - nodes];
        }
    }
}

impl<const N: usize> RunFunctions<'_, N> {
    /// The first place that is touched from a cell.
    #[inline(always)]
    pub(super) fn start(self, cell: u32) -> usize {
        cell as usize * self.step
    }

    /// The functions at a fraction of the cell.
    #[inline(always)]
    pub(super) fn values(self, fraction: f64) -> [f64; N] {
        horner(self.values, fraction - 0.5)
    }

    /// Their gradients there.
    #[inline(always)]
    pub(super) fn slopes(self, fraction: f64) -> [f64; N] {
        horner(&self.slopes[..N - 1], fraction - 0.5)
    }
}

/// Polynomials of the fraction of a cell, one coefficient after the other, like polynomials of its distance from ½.
fn about_the_middle<const R: usize, const C: usize>(mut powers: [[f64; C]; R]) -> [[f64; C]; R] {
    // Horner's division by x − ½, again and again.
    for lowest in 0..R {
        for n in (lowest..R - 1).rev() {
            let above = powers[n + 1];
            for (power, above) in powers[n].iter_mut().zip(above) {
                *power += 0.5 * above;
            }
        }
    }
    powers
}

/// Polynomials at x, all at once, by their coefficients from the zeroth power on.
#[inline(always)]
fn horner<const N: usize>(coefficients: &[[f64; N]], x: f64) -> [f64; N] {
    let mut highest_first = coefficients.iter().rev();
    let mut sums = *highest_first.next().expect("every shape has a power");
    for coefficients in highest_first {
        for (sum, coefficient) in sums.iter_mut().zip(coefficients) {
            *sum = *sum * x + coefficient;
        }
    }
    sums
}

//! The two ways between the particles and the nodes of a line.

use super::polynomials::{CellPolynomials, add_particle, gradient_at};
use super::runs::{RunFunctions, Runs};

/// Carries charge from particles to nodes and the gradient of the potential back, by one table for each
/// sample.
pub(super) trait Carrier: Copy + Sync {
    /// Values of a table.
    fn table_len(self) -> usize;

    /// Values of working memory for a solve.
    fn work_len(self) -> usize;

    /// Empties the table: of the portions of the particles, the first is on the background.
    fn clear(self, table: &mut [f64], is_first: bool);

    /// Adds a particle to the table.
    fn add(self, table: &mut [f64], cell: u32, weight: f64, fraction: f64);

    /// Turns the table with all particles into that for gradients. `solve` is the way from charge
    /// to potential; `work` has room.
    fn solve(self, table: &mut [f64], work: &mut [f64], solve: impl FnOnce(&mut [f64]));

    /// The gradient at a particle.
    fn gradient(self, table: &[f64], cell: u32, fraction: f64) -> f64;
}

/// By moments of cells: the least work for a particle, and some for every cell.
#[derive(Clone, Copy)]
pub(super) struct ByMoments<'a, const N: usize> {
    pub(super) cells: usize,
    /// −ρ0 of the nodes.
    pub(super) background: &'a [f64],
    pub(super) polynomials: &'a CellPolynomials,
}

impl<const N: usize> Carrier for ByMoments<'_, N> {
    fn table_len(self) -> usize {
        self.polynomials.table_len()
    }

    fn work_len(self) -> usize {
        self.background.len() + self.polynomials.work_len(self.background.len())
    }

    fn clear(self, table: &mut [f64], _is_first: bool) {
        table.fill(0.0);
    }

    #[inline(always)]
    fn add(self, table: &mut [f64], cell: u32, weight: f64, fraction: f64) {
        let (moments, _) = table.as_chunks_mut::<N>();
        add_particle(&mut moments[cell as usize], weight, fraction);
    }

    fn solve(self, table: &mut [f64], work: &mut [f64], solve: impl FnOnce(&mut [f64])) {
        let (nodes, work) = work.split_at_mut(self.background.len());
        nodes.copy_from_slice(self.background);
        self.polynomials.deposit::<N>(table, nodes, work);
        solve(nodes);
        self.polynomials.gradients::<N>(nodes, table, work);
    }

    #[inline(always)]
    fn gradient(self, table: &[f64], cell: u32, fraction: f64) -> f64 {
        gradient_at::<N>(table, self.cells, cell as usize, fraction)
    }
}

/// By the functions themselves: nothing but the solve for a cell.
#[derive(Clone, Copy)]
pub(super) struct ByRuns<'a, const N: usize> {
    pub(super) runs: &'a Runs,
    /// −ρ0 of the nodes as they run, and no charge of ghosts.
    pub(super) background: &'a [f64],
    pub(super) functions: RunFunctions<'a, N>,
}

impl<const N: usize> Carrier for ByRuns<'_, N> {
    fn table_len(self) -> usize {
        self.runs.len()
    }

    fn work_len(self) -> usize {
        self.runs.nodes()
    }

    fn clear(self, table: &mut [f64], is_first: bool) {
        if is_first {
            table.copy_from_slice(self.background);
        } else {
            table.fill(0.0);
        }
    }

    #[inline(always)]
    fn add(self, table: &mut [f64], cell: u32, weight: f64, fraction: f64) {
        let values = self.functions.values(fraction);
        let run = &mut table[self.functions.start(cell)..][..N];
        for (node, value) in run.iter_mut().zip(values) {
            *node += weight * value;
        }
    }

    fn solve(self, table: &mut [f64], work: &mut [f64], solve: impl FnOnce(&mut [f64])) {
        let (cells, step) = (self.runs.cells(), self.runs.step());
        self.runs.fold(table, 1);
        let row = &mut table[..cells * step];
        if step == 1 {
            solve(row);
        } else {
            // A mesh has one component after the other.
            let nodes = &mut work[..cells * step];
            for (component, nodes) in nodes.chunks_exact_mut(cells).enumerate() {
                for (node, cell) in nodes.iter_mut().zip(row.chunks_exact(step)) {
                    *node = cell[component];
                }
            }
            solve(nodes);
            for (component, nodes) in nodes.chunks_exact(cells).enumerate() {
                for (node, cell) in nodes.iter().zip(row.chunks_exact_mut(step)) {
                    cell[component] = *node;
                }
            }
        }
        self.runs.unfold(table, 1);
    }

    #[inline(always)]
    fn gradient(self, table: &[f64], cell: u32, fraction: f64) -> f64 {
        let slopes = self.functions.slopes(fraction);
        let run = &table[self.functions.start(cell)..][..N];
        let mut sum = 0.0;
        for j in 0..N {
            sum += run[j] * slopes[j];
        }
        sum
    }
}

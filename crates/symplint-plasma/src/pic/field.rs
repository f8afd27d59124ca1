//! From charge to potential: one Fourier transform over the cells each way, and one small
//! matrix for each mode.

use std::sync::Arc;

use symplint_fft::{Complex64, ComplexToReal, Fft, RealToComplex};

use super::element::{AxisMode, ComplexMatrix};
use super::mesh::Mesh;
use super::packed::PackedSolver;
use super::scratch::with_complex_buffer;

/// G = B^{s/2} L⁺ B^{s/2} on tables of nodal values: L the stiffness matrix (∇N_i, ∇N_j), L⁺ its
/// inverse on the mean-zero subspace, B the binary filter.
///
/// Where L and B commute, as for B-splines, this is the paper's L⁻¹ B^s. It is symmetric in any
/// case, so that the field energy ½ ρᵀ G ρ has the potential G ρ.
#[derive(Clone)]
pub(super) struct FieldSolver {
    cells: usize,
    components: usize,
    /// For each mode of the half spectrum, the matrix of G between the components, row by row,
    /// over the number of cells: the transforms are not normalised.
    green: Vec<Complex64>,
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    /// Both ways along the first of two axes; none in one dimension.
    across: Option<[Arc<dyn Fft<f64>>; 2]>,
    transform_scratch: usize,
    packed: Option<PackedSolver>,
}

/// Nodes of a cell at most: degree 3 in two dimensions.
const MAX_COMPONENTS: usize = 9;

impl FieldSolver {
    /// The solver on a mesh, with `passes` passes of the binary filter.
    pub(super) fn new<const D: usize>(mesh: &Mesh<D>, passes: u32) -> Self {
        Self::of_green(green(mesh, passes), mesh.cells(), mesh.components(), D)
    }

    /// The solver by the matrices of G, on one or two axes of `cells` cells.
    fn of_green(green: Vec<Complex64>, cells: usize, components: usize, axes: usize) -> Self {
        let forward = symplint_fft::real_forward(cells);
        let inverse = symplint_fft::real_inverse(cells);
        let across =
            (axes == 2).then(|| [symplint_fft::forward(cells), symplint_fft::inverse(cells)]);
        let plans = across.iter().flatten();
        let transform_scratch = plans
            .map(|plan| plan.get_inplace_scratch_len())
            .chain([forward.get_scratch_len(), inverse.get_scratch_len()])
            .max()
            .unwrap_or(0);
        let packs = axes == 1 && components == 1 && cells.is_multiple_of(2);
        let eigenvalues = || green.iter().map(|green| green.re).collect::<Vec<f64>>();
        FieldSolver {
            cells,
            components,
            packed: packs.then(|| PackedSolver::new(&eigenvalues())),
            green,
            forward,
            inverse,
            across,
            transform_scratch,
        }
    }

    /// Modes that the transform of one real row holds.
    fn half(&self) -> usize {
        self.cells / 2 + 1
    }

    /// Each row of a table with its modes.
    fn rows_and_modes<'a>(
        &self,
        nodes: &'a mut [f64],
        spectrum: &'a mut [Complex64],
    ) -> impl Iterator<Item = (&'a mut [f64], &'a mut [Complex64])> {
        let rows = nodes.chunks_exact_mut(self.cells);
        rows.zip(spectrum.chunks_exact_mut(self.half()))
    }

    /// Turns the charges of the nodes into their potentials, in place.
    pub(super) fn solve(&self, nodes: &mut [f64]) {
        if let Some(packed) = &self.packed {
            return packed.solve(nodes);
        }
        let rows = nodes.len() / self.cells;
        let spectrum_len = rows * self.half();
        let columns_len = if self.across.is_some() {
            spectrum_len
        } else {
            0
        };
        let len = spectrum_len + columns_len + self.transform_scratch;
        with_complex_buffer(len, |buffer| {
            let (spectrum, rest) = buffer.split_at_mut(spectrum_len);
            let (columns, scratch) = rest.split_at_mut(columns_len);
            for (row, modes) in self.rows_and_modes(nodes, spectrum) {
                self.forward
                    .process_with_scratch(row, modes, scratch)
                    .expect("rows and modes have the lengths of the plan");
            }
            if let Some([forward, inverse]) = &self.across {
                // All columns of a component at once, side by side.
                let component = self.cells * self.half();
                let parts = || {
                    (0..columns_len)
                        .step_by(component)
                        .map(|i| i..i + component)
                };
                for part in parts() {
                    transpose(&spectrum[part.clone()], self.half(), &mut columns[part]);
                }
                forward.process_with_scratch(columns, scratch);
                self.apply_green(columns);
                inverse.process_with_scratch(columns, scratch);
                for part in parts() {
                    transpose(&columns[part.clone()], self.cells, &mut spectrum[part]);
                }
            } else {
                self.apply_green(spectrum);
            }
            for (row, modes) in self.rows_and_modes(nodes, spectrum) {
                // Real but for rounding errors, which the inverse transform does not accept.
                modes[0].im = 0.0;
                if self.cells.is_multiple_of(2) {
                    modes[self.half() - 1].im = 0.0;
                }
                self.inverse
                    .process_with_scratch(modes, row, scratch)
                    .expect("rows and modes have the lengths of the plan");
            }
        });
    }

    fn apply_green(&self, spectrum: &mut [Complex64]) {
        let m = self.components;
        if m == 1 {
            for (mode, green) in spectrum.iter_mut().zip(&self.green) {
                *mode *= green.re;
            }
            return;
        }
        let modes = spectrum.len() / m;
        let mut charge = [Complex64::ZERO; MAX_COMPONENTS];
        for (k, matrix) in self.green.chunks_exact(m * m).enumerate() {
            for (component, charge) in charge[..m].iter_mut().enumerate() {
                *charge = spectrum[component * modes + k];
            }
            for (component, row) in matrix.chunks_exact(m).enumerate() {
                spectrum[component * modes + k] =
                    row.iter().zip(&charge).map(|(g, charge)| g * charge).sum();
            }
        }
    }
}

/// Writes the columns of a table whose rows have `width` values one after the other.
fn transpose(table: &[Complex64], width: usize, columns: &mut [Complex64]) {
    /// Values in a cache line, which is read once.
    const LINE: usize = 4;
    let height = table.len() / width;
    for (block, columns) in columns.chunks_mut(LINE * height).enumerate() {
        for (i, row) in table.chunks_exact(width).enumerate() {
            let column_values = columns[i..].iter_mut().step_by(height);
            for (value, row_value) in column_values.zip(&row[block * LINE..]) {
                *value = *row_value;
            }
        }
    }
}

/// The matrices of G for all modes of the half spectrum, the first axis running fastest: so the
/// solver has them, by columns.
fn green<const D: usize>(mesh: &Mesh<D>, passes: u32) -> Vec<Complex64> {
    let cells = mesh.cells();
    let axis = |k| AxisMode::new(mesh.shape(), cells, passes, k);
    // Two slopes and `D` integrals: L goes as the cell width to the power D − 2.
    let scale = mesh.cell_width().powi(2 - D as i32);
    let norm = Complex64::from(scale / mesh.values_per_component() as f64);
    let mut green = Vec::new();
    let mut push = |matrix: ComplexMatrix| {
        // nalgebra stores columns.
        green.extend((matrix * norm).transpose().iter());
    };
    if D == 1 {
        for k in 0..=cells / 2 {
            let mode = axis(k);
            push(mode_green(mode.stiffness, mode.basis, &mode.filter, k == 0));
        }
    } else {
        let modes: Vec<AxisMode> = (0..cells).map(axis).collect();
        for (ky, y) in modes[..=cells / 2].iter().enumerate() {
            for (kx, x) in modes.iter().enumerate() {
                let stiffness = x.stiffness.kronecker(&y.mass) + x.mass.kronecker(&y.stiffness);
                let basis = x.basis.kronecker(&y.basis);
                let filter = x.filter.kronecker(&y.filter);
                push(mode_green(stiffness, basis, &filter, kx == 0 && ky == 0));
            }
        }
    }
    green
}

/// F T L'⁻¹ T* F for one mode: L' the stiffness in the basis T, F half the filter.
///
/// In the constant mode the first function of T is the constant, for which L' is zero. There the
/// inverse is that on the others, and the mean over the nodes is taken off before and after.
fn mode_green(
    stiffness: ComplexMatrix,
    basis: ComplexMatrix,
    filter: &ComplexMatrix,
    constant: bool,
) -> ComplexMatrix {
    let m = stiffness.nrows();
    let (stiffness, basis) = if constant {
        (
            stiffness.remove_row(0).remove_column(0),
            basis.remove_column(0),
        )
    } else {
        (stiffness, basis)
    };
    if stiffness.is_empty() {
        return ComplexMatrix::zeros(m, m);
    }
    let inverse = stiffness
        .cholesky()
        .expect("the stiffness matrix is positive definite off the constants")
        .inverse();
    let mut functions = filter * basis;
    if constant {
        let mean = functions.row_mean();
        for mut row in functions.row_iter_mut() {
            row -= &mean;
        }
    }
    &functions * inverse * functions.adjoint()
}

//! The nodes of a periodic box: how they are numbered, and which of them a position touches.

use symplint_models::ModelError;
use symplint_models::PeriodicGrid;
use symplint_models::bspline::{CellWeights, MAX_DEGREE};

use super::shape::{Shape, ShapeFamily};

/// A cube of equal cells, periodic along each of its `D` axes, with its nodes.
///
/// A node is a cell and a component, its place in the cell: B-splines have one
/// component, Lagrange elements of degree p have p^D. Tables of nodal values hold one component
/// after the other, each with one value for each cell, the last axis running fastest, so that
/// Fourier transforms over the cells act on contiguous memory. The place of a node in
/// the table is a sum over the axes.
#[derive(Clone, Debug)]
pub(super) struct Mesh<const D: usize> {
    grid: PeriodicGrid,
    shape: Shape,
    axes: [AxisNumbering; D],
    /// The first cell whose spline reaches into cell 0.
    first_spline: usize,
}

/// How far apart neighbours along one axis lie in a table.
#[derive(Clone, Copy, Debug)]
struct AxisNumbering {
    cell: usize,
    component: usize,
}

/// The nodes of one axis that a position touches: their places and what their functions are there.
///
/// A shape wider than the box touches a node more than once, and its images add up.
pub(super) struct AxisStencil {
    shape: Shape,
    places: [usize; MAX_DEGREE + 1],
    /// Where in the cell, from 0 to 1.
    fraction: f64,
}

impl<const D: usize> Mesh<D> {
    pub(super) fn new(shape: Shape, cells: usize, length: f64) -> Result<Self, ModelError> {
        let grid = PeriodicGrid::new(cells, length)?;
        // What grows fastest is the solver's table: nodes times nodes of a cell.
        let per_cell = shape.nodes_per_cell().pow(2);
        let limit = (1..D).fold(PeriodicGrid::MAX_CELLS, |limit, _| limit.isqrt()) / per_cell;
        if cells > limit {
            return Err(ModelError::TooManyCells { cells, limit });
        }
        let components = shape.nodes_per_cell();
        let axes = std::array::from_fn(|axis| {
            let inner = D - 1 - axis;
            AxisNumbering {
                cell: cells.pow(inner as u32),
                component: cells.pow(D as u32) * components.pow(inner as u32),
            }
        });
        let reach = match shape.family() {
            ShapeFamily::BSpline => shape.degree(),
            ShapeFamily::Lagrange => 0,
        };
        Ok(Mesh {
            grid,
            shape,
            axes,
            first_spline: (cells - reach % cells) % cells,
        })
    }

    pub(super) fn shape(&self) -> Shape {
        self.shape
    }

    /// Cells along one axis.
    pub(super) fn cells(&self) -> usize {
        self.grid.cells()
    }

    /// Length of one axis.
    pub(super) fn length(&self) -> f64 {
        self.grid.length()
    }

    /// Width of a cell.
    pub(super) fn cell_width(&self) -> f64 {
        self.grid.length() / self.grid.cells() as f64
    }

    /// Inverse width of a cell.
    pub(super) fn cells_per_length(&self) -> f64 {
        self.grid.cells_per_length()
    }

    /// Cells of the whole box: values of one component.
    pub(super) fn values_per_component(&self) -> usize {
        self.cells().pow(D as u32)
    }

    /// Nodes of one cell.
    pub(super) fn components(&self) -> usize {
        self.shape.nodes_per_cell().pow(D as u32)
    }

    /// Length of a table of nodal values.
    pub(super) fn nodes(&self) -> usize {
        self.components() * self.values_per_component()
    }

    /// The cells of one axis.
    pub(super) fn grid(&self) -> &PeriodicGrid {
        &self.grid
    }

    /// The nodes that the position `x` along `axis` touches.
    #[inline]
    pub(super) fn stencil(&self, axis: usize, x: f64) -> AxisStencil {
        let (cell, fraction) = self.grid.locate(x);
        AxisStencil {
            shape: self.shape,
            places: self.places(axis, cell),
            fraction,
        }
    }

    /// Places of the functions that do not vanish on a cell, in the order of the shape.
    #[inline]
    pub(super) fn places(&self, axis: usize, cell: usize) -> [usize; MAX_DEGREE + 1] {
        let AxisNumbering {
            cell: stride,
            component,
        } = self.axes[axis];
        let (cells, degree) = (self.cells(), self.shape.degree());
        let wrapped = |i: usize| if i >= cells { i - cells } else { i };
        let mut places = [0; MAX_DEGREE + 1];
        match self.shape.family() {
            ShapeFamily::BSpline => {
                let mut spline = wrapped(cell + self.first_spline);
                for place in &mut places[..=degree] {
                    *place = spline * stride;
                    spline = wrapped(spline + 1);
                }
            }
            ShapeFamily::Lagrange => {
                for (j, place) in places[..degree].iter_mut().enumerate() {
                    *place = j * component + cell * stride;
                }
                places[degree] = wrapped(cell + 1) * stride;
            }
        }
        places
    }
}

impl AxisStencil {
    /// Places of the functions that do not vanish, with their values.
    #[inline]
    pub(super) fn values(&self) -> impl Iterator<Item = (usize, f64)> + Clone + use<> {
        self.beside(self.shape.values(self.fraction))
    }

    /// Places of the functions that do not vanish, with their slopes.
    #[inline]
    pub(super) fn slopes(&self) -> impl Iterator<Item = (usize, f64)> + Clone + use<> {
        self.beside(self.shape.slopes(self.fraction))
    }

    /// Places of the functions that do not vanish, with their second derivatives.
    pub(super) fn curvatures(&self) -> impl Iterator<Item = (usize, f64)> + Clone + use<> {
        self.beside(self.shape.curvatures(self.fraction))
    }

    #[inline]
    fn beside(&self, weights: CellWeights) -> impl Iterator<Item = (usize, f64)> + Clone + use<> {
        let places = self.places;
        (0..=self.shape.degree()).map(move |j| (places[j], weights[j]))
    }
}

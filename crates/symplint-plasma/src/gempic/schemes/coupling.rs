//! Splines at a particle: what gathers fields and deposits charge.
//!
//! `N` is p + 1, the number of functions of V0 on a cell, so that sums over them are unrolled.

use std::fmt;

use symplint_models::PeriodicGrid;
use symplint_models::bspline;

/// The splines of V0 and V1 on a grid.
#[derive(Clone, Debug)]
pub(super) struct Coupling<const N: usize> {
    grid: PeriodicGrid,
}

/// A place on the grid.
pub(super) struct Place<'a, const N: usize> {
    grid: &'a PeriodicGrid,
    cell: usize,
    fraction: f64,
}

/// The splines that do not vanish at one place, in sequence round the circle, and their values.
pub(super) struct Splines<const N: usize> {
    cells: usize,
    first: usize,
    /// N, or N − 1 for V1.
    count: usize,
    values: [f64; N],
}

/// Why the cells on a way cannot be gone through one by one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PathFailure {
    /// There are too many of them.
    TooLong { way: f64, cells: f64 },
    /// A place on it is rounded to more than a cell.
    Unresolved { place: f64, rounding_in_cells: f64 },
}

impl fmt::Display for PathFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PathFailure::TooLong { way, cells } => write!(
                f,
                "moves by {way:.1e} in one step, {cells:.1e} cells; take a smaller step size"
            ),
            PathFailure::Unresolved {
                place,
                rounding_in_cells,
            } => write!(
                f,
                "comes to x = {place:.1e}, where rounding is {rounding_in_cells:.1e} cells; give initial positions \
                 inside the box"
            ),
        }
    }
}

impl<const N: usize> Coupling<N> {
    pub(super) fn new(grid: PeriodicGrid) -> Self {
        Coupling { grid }
    }

    pub(super) fn cells(&self) -> usize {
        self.grid.cells()
    }

    /// Cells per unit of length.
    pub(super) fn per_length(&self) -> f64 {
        self.grid.cells_per_length()
    }

    #[inline]
    pub(super) fn at(&self, x: f64) -> Place<'_, N> {
        let (cell, fraction) = self.grid.locate(x);
        Place {
            grid: &self.grid,
            cell,
            fraction,
        }
    }

    /// Whether the cells on the way from x to x + `way` can be gone through one by one.
    pub(super) fn check_way(&self, x: f64, way: f64) -> Result<(), PathFailure> {
        /// A step that resolves anything passes a few.
        const MAX_CELLS: f64 = 1e5;
        let cells = (way * self.per_length()).abs();
        if cells > MAX_CELLS || way.is_nan() {
            return Err(PathFailure::TooLong { way, cells });
        }
        let end = x + way;
        let place = if end.abs() > x.abs() { end } else { x };
        let rounding_in_cells = f64::EPSILON * place.abs() * self.per_length();
        // From here on numbers of cells are not told from their neighbours.
        if rounding_in_cells >= 1.0 || place.is_nan() {
            return Err(PathFailure::Unresolved {
                place,
                rounding_in_cells,
            });
        }
        Ok(())
    }

    /// The parts of the way from x to x + `way` on which splines are polynomials, in the order of the way: where they begin
    /// and end, from 0 to 1. The way has passed [`check_way`](Self::check_way): for others this might not end.
    pub(super) fn pieces(&self, x: f64, way: f64, mut each: impl FnMut(f64, f64)) {
        let per_length = self.per_length();
        let (from, length) = (x * per_length, way * per_length);
        let (mut node, next) = match way > 0.0 {
            true => (from.floor() + 1.0, 1.0),
            false => (from.ceil() - 1.0, -1.0),
        };
        let mut here = 0.0;
        loop {
            // Not by differences of places, which are rounded more than a short way is long.
            let there = (node - from) / length;
            if there >= 1.0 || there.is_nan() {
                break;
            }
            each(here, there);
            here = there;
            node += next;
        }
        each(here, 1.0);
    }
}

impl<const N: usize> Place<'_, N> {
    /// Λ⁰_j, the splines of V0.
    #[inline]
    pub(super) fn zero(&self) -> Splines<N> {
        self.splines(N, 1.0)
    }

    /// Λ¹_j, the splines of V1.
    #[inline]
    pub(super) fn one(&self) -> Splines<N> {
        self.splines(N - 1, self.grid.cells_per_length())
    }

    #[inline]
    fn splines(&self, count: usize, scale: f64) -> Splines<N> {
        let (cells, degree) = (self.grid.cells(), count - 1);
        let values = bspline::weights(degree, self.fraction);
        Splines {
            cells,
            // The spline that starts in this cell is the last of those that do not vanish.
            first: match self.cell.checked_sub(degree) {
                Some(first) => first,
                None => (self.cell + cells * degree - degree) % cells,
            },
            count,
            values: std::array::from_fn(|j| scale * values[j]),
        }
    }
}

impl<const N: usize> Splines<N> {
    /// The function with these coefficients.
    #[inline]
    pub(super) fn sum(&self, coefficients: &[f64]) -> f64 {
        let mut sum = 0.0;
        self.each(|j, value| sum += value * coefficients[j]);
        sum
    }

    /// Adds `charge` times its spline to every sum.
    #[inline]
    pub(super) fn deposit(&self, charge: f64, sums: &mut [f64]) {
        self.each(|j, value| sums[j] += charge * value);
    }

    /// Calls `each` with the number of every spline and its value.
    #[inline]
    fn each(&self, mut each: impl FnMut(usize, f64)) {
        let mut j = self.first;
        for value in &self.values[..self.count] {
            each(j, *value);
            j = if j + 1 == self.cells { 0 } else { j + 1 };
        }
    }
}

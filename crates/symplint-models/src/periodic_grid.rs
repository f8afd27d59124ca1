//! A uniform grid on a circle: which cell a position lies in.

use crate::error::ModelError;

/// Equal cells on a period: cell i reaches from node i, at i × length / cells, to node i + 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodicGrid {
    cells: usize,
    length: f64,
    cells_per_length: f64,
    periods_per_cell: f64,
}

impl PeriodicGrid {
    /// The most cells accepted: a table of them still fits in memory easily.
    pub const MAX_CELLS: usize = 1 << 24;

    /// A grid of `cells` cells on the period `length`.
    ///
    /// # Errors
    /// If there is no cell or more than [`MAX_CELLS`](Self::MAX_CELLS), or the length is not a
    /// finite positive number.
    pub fn new(cells: usize, length: f64) -> Result<Self, ModelError> {
        if cells == 0 {
            return Err(ModelError::Empty {
                system: "a grid",
                parts: "cells",
            });
        }
        if cells > Self::MAX_CELLS {
            return Err(ModelError::TooManyCells {
                cells,
                limit: Self::MAX_CELLS,
            });
        }
        let cells_per_length = cells as f64 / length;
        if !(length.is_finite() && length > 0.0 && cells_per_length.is_normal()) {
            return Err(ModelError::OutOfRange {
                what: "the length of a grid",
                value: length,
                remedy: "give a finite positive length of a moderate size",
            });
        }
        Ok(PeriodicGrid {
            cells,
            length,
            cells_per_length,
            periods_per_cell: 1.0 / cells as f64,
        })
    }

    /// Number of cells in a period.
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// The period.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Inverse width of a cell.
    pub fn cells_per_length(&self) -> f64 {
        self.cells_per_length
    }

    /// Position of node i.
    pub fn node(&self, i: usize) -> f64 {
        i as f64 * self.length / self.cells as f64
    }

    /// The cell that holds `q`, from 0 to cells − 1, and where in the cell, from 0 to 1.
    ///
    /// Any finite position will do, however many periods away; the cell's number is wrapped in
    /// integers, so it is never off by one. The fraction reaches 1 only where a position lies
    /// below a node by less than a rounding error. A position that is not finite gets a valid
    /// cell and the fraction NaN.
    #[inline]
    pub fn locate(&self, q: f64) -> (usize, f64) {
        /// Below this, integer parts of positions are exact, and `locate_near` holds.
        const EXACT: f64 = (1_u64 << 51) as f64;
        let position = q * self.cells_per_length;
        if position.abs() < EXACT {
            self.locate_near(position)
        } else {
            self.locate_far(q)
        }
    }

    #[inline]
    fn locate_near(&self, position: f64) -> (usize, f64) {
        let cells = self.cells as i64;
        let cell = floor(position);
        let fraction = position - cell as f64;
        // A division would be slow. The quotient's rounding error is below 1 / cells, so it can
        // cross an integer only where it should be one: then it may fall short of it, and the
        // remainder is `cells` instead of 0. Corrected without a branch, which would be mispredicted.
        let period = floor(cell as f64 * self.periods_per_cell);
        let remainder = cell - period * cells;
        let wrapped = remainder - (cells & ((cells - 1 - remainder) >> 63));
        (wrapped as usize, fraction)
    }

    /// Positions so far out that neighbouring floating-point numbers are half a cell or more apart.
    #[cold]
    fn locate_far(&self, q: f64) -> (usize, f64) {
        let position = (q % self.length) * self.cells_per_length;
        if position.is_finite() {
            self.locate_near(position)
        } else {
            (0, f64::NAN)
        }
    }
}

/// The largest integer that is not above `x`, which must be in the range of `i64`.
///
/// On processors without a rounding instruction `f64::floor` is a call; this is not.
#[inline]
fn floor(x: f64) -> i64 {
    let truncated = x as i64;
    truncated - i64::from(truncated as f64 > x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Floor and remainder in exact integers.
    fn slow_cell(grid: &PeriodicGrid, q: f64) -> (usize, f64) {
        let position = q * grid.cells_per_length;
        let cell = position.floor();
        let wrapped = (cell as i128).rem_euclid(grid.cells as i128);
        (wrapped as usize, position - cell)
    }

    proptest! {
        #[test]
        fn the_cell_is_the_integer_remainder(
            cells in 1_usize..10_000,
            mantissa in -1.0_f64..1.0,
            exponent in -60_i32..40,
        ) {
            let grid = PeriodicGrid::new(cells, std::f64::consts::TAU).unwrap();
            let q = mantissa * 2.0_f64.powi(exponent);
            prop_assert_eq!(grid.locate(q), slow_cell(&grid, q));
        }

        #[test]
        fn any_number_gets_a_valid_cell(cells in 1_usize..10_000, bits: u64) {
            let grid = PeriodicGrid::new(cells, 50.0).unwrap();
            let q = f64::from_bits(bits);
            let (cell, fraction) = grid.locate(q);
            prop_assert!(cell < cells);
            prop_assert!((0.0..=1.0).contains(&fraction) || !q.is_finite());
        }
    }

    #[test]
    fn whole_periods_do_not_matter() {
        // All numbers here are exact, so the answer must be, too.
        let grid = PeriodicGrid::new(64, 32.0).unwrap();
        for turns in [0.0, 1.0, -1.0, -3.0, 1e6, -1e6, 2.0_f64.powi(40)] {
            for i in 0..64_usize {
                let node = grid.node(i) + turns * 32.0;
                assert_eq!(grid.locate(node), (i, 0.0));
                assert_eq!(grid.locate(node + 0.125), (i, 0.25));
            }
        }
        assert_eq!(grid.locate(2.0_f64.powi(1000)), (0, 0.0));
        assert_eq!(grid.locate(f64::MAX), (0, 0.0));
        assert_eq!(grid.locate(-0.0), (0, 0.0));
        assert_eq!(grid.locate(-1e-300), (63, 1.0));
    }

    #[test]
    fn no_quotient_is_rounded_into_the_wrong_period() {
        for cells in (1..2000).chain([PeriodicGrid::MAX_CELLS - 1, PeriodicGrid::MAX_CELLS]) {
            // Cells of width 1, so that positions are the numbers of cells themselves.
            let grid = PeriodicGrid::new(cells, cells as f64).unwrap();
            let most = (1_i64 << 51) / cells as i64;
            for turns in [0, 1, 2, 3, 7, 1000, 123_456_789, most / 3, most - 1] {
                for turns in [turns.min(most - 1), -turns.min(most - 1)] {
                    for offset in [-1, 0, 1] {
                        let cell = turns * cells as i64 + offset;
                        let expected = (cell.rem_euclid(cells as i64) as usize, 0.0);
                        assert_eq!(grid.locate(cell as f64), expected, "{cell} of {cells}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_grid_needs_cells_and_a_length() {
        assert!(PeriodicGrid::new(0, 1.0).is_err());
        assert!(PeriodicGrid::new(usize::MAX, 1.0).is_err());
        for length in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-320] {
            assert!(PeriodicGrid::new(4, length).is_err(), "{length}");
        }
    }
}

//! A uniform grid on a circle: which cell a position lies in.

use crate::error::ModelError;

/// Equal cells on a period: cell i reaches from node i, at i × length / cells, to node i + 1.
///
/// Nodes are the floating-point numbers that [`node`](Self::node) gives, and a node belongs to the
/// cell above it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodicGrid {
    cells: usize,
    length: f64,
    /// The first 26 bits of the length, and the rest: products with numbers of periods are exact.
    length_high: f64,
    length_low: f64,
    /// Below 1 / length, so that no position within half a period is rounded to the next.
    periods_per_length: f64,
    cells_per_length: f64,
    /// Positions below this are reduced by products.
    near: f64,
    /// Within this of the middle of a cell, fractions lie in one cell for certain.
    certain: f64,
}

impl PeriodicGrid {
    /// The most cells accepted: a table of them still fits in memory easily.
    pub const MAX_CELLS: usize = 1 << 24;

    /// A grid of `cells` cells on the period `length`.
    ///
    /// # Errors
    /// If the number of cells is 0 or more than [`MAX_CELLS`](Self::MAX_CELLS), or the length is not a
    /// finite positive number, or so large or small that the grid's arithmetic would overflow.
    pub fn new(cells: usize, length: f64) -> Result<Self, ModelError> {
        /// Products of this number of periods with half of the length's bits are exact, and quotients by
        /// the length off by less than an eighth of the narrowest cell.
        const NEAR_PERIODS: f64 = (1_u64 << 24) as f64;
        const LOW_BITS: u64 = (1 << 27) - 1;
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
        let periods_per_length = (1.0 / length).next_down();
        let usable = length > 0.0
            && (length * cells as f64).is_finite()
            && cells_per_length.is_normal()
            && periods_per_length.is_normal();
        if !usable {
            return Err(ModelError::OutOfRange {
                what: "the length of a grid",
                value: length,
                remedy: "give a finite positive length of a moderate size",
            });
        }
        let length_high = f64::from_bits(length.to_bits() & !LOW_BITS);
        Ok(PeriodicGrid {
            cells,
            length,
            length_high,
            length_low: length - length_high,
            periods_per_length,
            cells_per_length,
            near: (NEAR_PERIODS * length).min(0.5 * f64::MAX),
            // Nodes and quotients are off by less than half of this.
            certain: 0.5 - 4.0 * cells as f64 * f64::EPSILON,
        })
    }

    /// Number of cells in a period.
    #[inline]
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// The period.
    #[inline]
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Inverse width of a cell.
    #[inline]
    pub fn cells_per_length(&self) -> f64 {
        self.cells_per_length
    }

    /// Position of node i.
    #[inline]
    pub fn node(&self, i: usize) -> f64 {
        self.node_at(i as f64)
    }

    #[inline]
    fn node_at(&self, i: f64) -> f64 {
        i * self.length / self.cells as f64
    }

    /// The cell that holds `q`, from 0 to cells − 1, and where in the cell, from 0 to 1.
    ///
    /// Any finite position will do, however many periods away: whole periods are taken off exactly,
    /// and what is left is compared with the nodes, so that node(i) is in cell i at fraction 0 and
    /// the number below it in cell i − 1. The fraction reaches 1 only where a position lies
    /// below a node by less than a rounding error. A position that is not finite gets a valid
    /// cell and the fraction NaN.
    #[inline]
    pub fn locate(&self, q: f64) -> (usize, f64) {
        let quick = self.locate_quickly(q);
        let (cell, fraction) = if quick.is_certain {
            (quick.cell, quick.fraction)
        } else {
            self.locate_surely(q)
        };
        (cell as usize, fraction)
    }

    /// [`locate`](Self::locate) for all but far positions and the closest neighbours of a node, and
    /// whether the position is not one of these. Without branches, conversions or calls, so that compilers make
    /// vectors of it.
    #[inline]
    pub fn locate_quickly(&self, q: f64) -> Place {
        let position = self.offset(q) * self.cells_per_length;
        // Rounds down, unless the position is next to a node.
        let (cell, number) = round(position - 0.5);
        let fraction = position - cell;
        Place {
            cell: self.wrapped(number),
            fraction,
            is_certain: (q.abs() < self.near) & ((fraction - 0.5).abs() < self.certain),
        }
    }

    /// [`locate`](Self::locate) where [`locate_quickly`](Self::locate_quickly) is uncertain.
    #[cold]
    fn locate_surely(&self, q: f64) -> (u32, f64) {
        if !q.is_finite() {
            return (0, f64::NAN);
        }
        // The remainder is exact.
        let q = if q.abs() < self.near {
            q
        } else {
            q % self.length
        };
        let quick = self.locate_quickly(q);
        if quick.is_certain {
            return (quick.cell, quick.fraction);
        }
        let offset = self.offset(q);
        let (nearest, number) = round(offset * self.cells_per_length);
        // Left of 0 the node is in the period before. There its difference with the length is exact,
        // for it is in the upper half of its period.
        let node = if nearest < 0.0 {
            self.node_at(nearest + self.cells as f64) - self.length
        } else {
            self.node_at(nearest)
        };
        let beyond = (offset - node) * self.cells_per_length;
        if offset < node {
            (self.wrapped(number - 1), 1.0 + beyond)
        } else {
            (self.wrapped(number), beyond)
        }
    }

    /// A near `q` less whole periods, without rounding: within half a period, but for an eighth
    /// of a cell where q is many periods away.
    #[inline]
    fn offset(&self, q: f64) -> f64 {
        // Both products are exact, and the differences are numbers of few enough digits.
        let (periods, _) = round(q * self.periods_per_length);
        (q - periods * self.length_high) - periods * self.length_low
    }

    /// The number of a cell at most one period below cell 0.
    #[inline]
    fn wrapped(&self, cell: i32) -> u32 {
        (cell + (self.cells as i32 & (cell >> 31))) as u32
    }
}

/// What [`PeriodicGrid::locate_quickly`] finds.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// The cell.
    pub cell: u32,
    /// Where in the cell, from 0 to 1.
    pub fraction: f64,
    /// If not, it is not the place of the position: [`PeriodicGrid::locate`] finds that.
    pub is_certain: bool,
}

/// The nearest integer, for |x| < 2^31.
#[inline]
fn round(x: f64) -> (f64, i32) {
    /// Numbers of this size are a distance of 1 apart, on both sides, and their last bits count.
    const SHIFT: f64 = 1.5 * (1_u64 << 52) as f64;
    let sum = x + SHIFT;
    (sum - SHIFT, sum.to_bits() as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// x = mantissa × 2^exponent.
    fn decomposed(x: f64) -> (i128, i32) {
        let bits = x.abs().to_bits();
        let exponent = (bits >> 52) as i32;
        let hidden = i128::from(exponent > 0) << 52;
        let mantissa = i128::from(bits & ((1 << 52) - 1)) + hidden;
        let signed = if x < 0.0 { -mantissa } else { mantissa };
        (signed, exponent.max(1) - 1075)
    }

    /// The remainder and its comparison with the nodes in exact integers, and the fraction's error
    /// allowed. For |q| > 2^-70 length.
    fn exact_place(cells: usize, length: f64, q: f64) -> (usize, f64, f64) {
        let ((q, q_exponent), exponent) = (decomposed(q), decomposed(length).1);
        let unit = q_exponent.min(exponent - 30);
        let in_units = |x: f64| match decomposed(x) {
            (0, _) => 0,
            (mantissa, exponent) => mantissa << (exponent - unit),
        };
        let period = in_units(length);
        let mut offset = q.rem_euclid(period);
        for _ in unit..q_exponent {
            offset = 2 * offset % period;
        }
        let node = |i: usize| in_units(i as f64 * length / cells as f64);
        let mut cell = (offset as f64 / period as f64 * cells as f64) as usize;
        while cell == cells || offset < node(cell) {
            cell -= 1;
        }
        while cell + 1 < cells && offset >= node(cell + 1) {
            cell += 1;
        }
        let beyond = offset - node(cell);
        let fraction = beyond as f64 / period as f64 * cells as f64;
        let error = if beyond == 0 { 0.0 } else { f64::EPSILON };
        (cell, fraction, error * (1.0 + 2.0 * cells as f64))
    }

    fn check(cells: usize, length: f64, q: f64) {
        let grid = PeriodicGrid::new(cells, length).unwrap();
        let (cell, fraction) = grid.locate(q);
        let (expected, expected_fraction, error) = exact_place(cells, length, q);
        let what = format!("{q:e} on {cells} cells of a period of {length:e}");
        assert_eq!(cell, expected, "{what}");
        assert!((0.0..=1.0).contains(&fraction), "{what}: {fraction}");
        assert!(
            (fraction - expected_fraction).abs() <= error,
            "{what}: {fraction} for {expected_fraction}"
        );
    }

    fn numbers_of_cells() -> impl Strategy<Value = usize> {
        const MAX: usize = PeriodicGrid::MAX_CELLS;
        prop_oneof![1..20_usize, 1..10_000_usize, MAX - 9..=MAX, 1..=MAX]
    }

    fn lengths() -> impl Strategy<Value = f64> {
        let any = (1.0_f64..2.0, -40_i32..40).prop_map(|(m, e)| m * 2.0_f64.powi(e));
        let next_to_powers = (-3_i32..=3, -40_i32..40).prop_map(|(ulps, e)| {
            f64::from_bits((2.0_f64.powi(e).to_bits() as i64 + i64::from(ulps)) as u64)
        });
        let short = (1_u32..100_000).prop_map(|n| f64::from(n) / 1000.0);
        prop_oneof![any, next_to_powers, short]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn the_cell_is_that_of_the_exact_remainder(
            cells in numbers_of_cells(),
            length in lengths(),
            mantissa in 1.0_f64..2.0,
            exponent in prop_oneof![-68_i32..70, -3_i32..3, 20_i32..30, 70_i32..900],
            sign in prop_oneof![Just(1.0), Just(-1.0)],
        ) {
            check(cells, length, sign * mantissa * length * 2.0_f64.powi(exponent));
        }

        #[test]
        fn neighbours_of_nodes_are_in_their_cells(
            cells in numbers_of_cells(),
            length in lengths(),
            part in 0.0_f64..1.0,
            periods in prop_oneof![
                Just(0.0),
                (-9_i32..9).prop_map(f64::from),
                (0_i32..40).prop_map(|k| 2.0_f64.powi(k)),
                (0_i32..40).prop_map(|k| -(2.0_f64.powi(k))),
                -1e10_f64..1e10,
            ],
            ulps in -2_i64..=2,
        ) {
            let grid = PeriodicGrid::new(cells, length).unwrap();
            let node = grid.node((part * cells as f64) as usize) + periods.round() * length;
            if node != 0.0 {
                check(cells, length, f64::from_bits((node.to_bits() as i64 + ulps) as u64));
            }
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

    /// Whether a + b is a floating-point number.
    fn is_exact(a: f64, b: f64) -> bool {
        let sum = a + b;
        let of_b = sum - a;
        (a - (sum - of_b)) + (b - of_b) == 0.0
    }

    #[test]
    fn a_node_is_where_its_cell_begins() {
        let mut exact_sums = 0;
        for length in [
            49.0,
            12.566,
            628.0 / 100.0,
            1.0,
            50.0,
            0.1,
            std::f64::consts::TAU,
        ] {
            for cells in (1..=130).chain([499, 500, 1000, 4095]) {
                let grid = PeriodicGrid::new(cells, length).unwrap();
                for end in [0.0, -0.0, length, -length, 2.0 * length, -1024.0 * length] {
                    assert_eq!(grid.locate(end), (0, 0.0), "{end} of {cells} × {length}");
                }
                assert_eq!(grid.locate(length.next_down()).0, cells - 1);
                assert_eq!(grid.locate((-length).next_down()).0, cells - 1);
                for i in 0..cells {
                    let node = grid.node(i);
                    for turns in [0.0, 1.0, -1.0, 2.0, -4.0, 4096.0, 2.0_f64.powi(30)] {
                        if is_exact(node, turns * length) {
                            let q = node + turns * length;
                            let below = (i + cells - 1) % cells;
                            let what = format!("node {i} of {cells} × {length}, {turns} turns");
                            assert_eq!(grid.locate(q), (i, 0.0), "{what}");
                            assert_eq!(grid.locate(q.next_down()).0, below, "{what}");
                            assert_eq!(grid.locate(q.next_up()).0, i, "{what}");
                            exact_sums += 1;
                        }
                    }
                }
            }
        }
        assert!(exact_sums > 100_000, "{exact_sums}");
    }

    #[test]
    fn extreme_lengths_are_reduced_or_refused() {
        for exponent in (-1074..=1023).step_by(3) {
            for cells in [1, 7, 1000, PeriodicGrid::MAX_CELLS] {
                let length = 1.3 * 2.0_f64.powi(exponent);
                let Ok(grid) = PeriodicGrid::new(cells, length) else {
                    assert!(!(-990..=990).contains(&exponent), "{cells} × {length:e}");
                    continue;
                };
                for i in [0, cells / 3, cells / 2, cells - 1] {
                    assert_eq!(grid.locate(grid.node(i)), (i, 0.0), "{cells} × {length:e}");
                }
                for q in [f64::MAX, -f64::MAX, 0.4 * f64::MAX, length, 1e-300, -5e-324] {
                    let (cell, fraction) = grid.locate(q);
                    assert!(cell < cells && (0.0..=1.0).contains(&fraction), "{q:e}");
                }
            }
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

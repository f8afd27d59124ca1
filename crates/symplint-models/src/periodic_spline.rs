//! A periodic function given by its values at the nodes, interpolated by B-splines.

use symplint_fft::Complex64;

use crate::bspline::{self, MAX_DEGREE};
use crate::error::ModelError;
use crate::periodic_grid::PeriodicGrid;

/// A periodic spline of degree 1 to 5 that takes given values at the nodes of a grid.
///
/// A degree-p spline has p − 1 continuous derivatives. On each cell it is kept as a polynomial
/// in the fraction of the cell, so a point costs one look-up and one Horner scheme.
#[derive(Clone, Debug, PartialEq)]
pub struct PeriodicSpline {
    grid: PeriodicGrid,
    degree: usize,
    /// Per cell, the coefficients of 1, x, x², … of the spline.
    values: Vec<[f64; MAX_DEGREE + 1]>,
    /// Per cell, the same of its derivative by the position.
    slopes: Vec<[f64; MAX_DEGREE]>,
}

impl PeriodicSpline {
    /// The spline of the given degree that takes the value `values[i]` at node i of as many nodes
    /// on a period of `length`.
    ///
    /// # Errors
    /// If the degree is not 1 to 5, the grid is not one (see [`PeriodicGrid::new`]), there are no
    /// more cells than the degree, a value is not finite, or the degree and the number of cells
    /// are both even: then such a spline does not exist for most values.
    pub fn interpolating(degree: usize, length: f64, values: &[f64]) -> Result<Self, ModelError> {
        let grid = Self::check_grid(degree, length, values.len())?;
        for &value in values {
            ModelError::check_finite("a value to interpolate", value)?;
        }
        let coefficients = collocation_coefficients(degree, values);
        let polynomials = cell_polynomials(degree, &coefficients);
        let slopes = polynomials
            .iter()
            .map(|polynomial| {
                std::array::from_fn(|n| {
                    grid.cells_per_length() * (n + 1) as f64 * polynomial[n + 1]
                })
            })
            .collect();
        Ok(PeriodicSpline {
            grid,
            degree,
            values: polynomials,
            slopes,
        })
    }

    /// The grid on which a spline of `degree` can interpolate any values, if there is one.
    fn check_grid(degree: usize, length: f64, cells: usize) -> Result<PeriodicGrid, ModelError> {
        if !(1..=MAX_DEGREE).contains(&degree) {
            return Err(ModelError::Degree {
                degree,
                lowest: 1,
                highest: MAX_DEGREE,
            });
        }
        if cells <= degree {
            return Err(ModelError::TooFewCells {
                degree,
                cells,
                needed: degree + 1,
            });
        }
        if degree.is_multiple_of(2) && cells.is_multiple_of(2) {
            return Err(ModelError::SingularCollocation { degree, cells });
        }
        PeriodicGrid::new(cells, length)
    }

    /// The grid whose nodes are the knots.
    pub fn grid(&self) -> &PeriodicGrid {
        &self.grid
    }

    /// Degree of the pieces.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The spline at `q`.
    #[inline]
    pub fn value(&self, q: f64) -> f64 {
        let (cell, x) = self.grid.locate(q);
        horner(&self.values[cell], x)
    }

    /// The derivative at `q`; where it jumps (degree 1, at a node), the one from the right.
    #[inline]
    pub fn derivative(&self, q: f64) -> f64 {
        let (cell, x) = self.grid.locate(q);
        horner(&self.slopes[cell], x)
    }

    /// The second derivative at `q`, zero at degree 1; where it jumps (degree 1 and 2, at a node), the one
    /// from the right.
    pub fn second_derivative(&self, q: f64) -> f64 {
        let (cell, x) = self.grid.locate(q);
        let slopes = &self.slopes[cell];
        let by_fraction: [f64; MAX_DEGREE - 1] =
            std::array::from_fn(|n| (n + 1) as f64 * slopes[n + 1]);
        self.grid.cells_per_length() * horner(&by_fraction, x)
    }
}

#[inline]
fn horner<const N: usize>(coefficients: &[f64; N], x: f64) -> f64 {
    coefficients
        .iter()
        .rev()
        .fold(0.0, |sum, coefficient| sum * x + coefficient)
}

/// Coefficients c_m of the splines B_m, m the starting node, with Σ_m c_m B_m(q_i) = `values[i]`.
///
/// The matrix is circulant, so Fourier modes are its eigenvectors. Its symbol
/// Σ_j B_{−p+j}(0) e^{iκ(j−p)} vanishes nowhere for odd p and only at κ = π for even p.
fn collocation_coefficients(degree: usize, values: &[f64]) -> Vec<f64> {
    let cells = values.len();
    let weights = bspline::weights(degree, 0.0);
    let mut modes: Vec<Complex64> = values.iter().map(|&value| value.into()).collect();
    symplint_fft::forward(cells).process(&mut modes);
    for (k, mode) in modes.iter_mut().enumerate() {
        let kappa = std::f64::consts::TAU * k as f64 / cells as f64;
        let symbol: Complex64 = weights
            .iter()
            .enumerate()
            .map(|(j, weight)| Complex64::from_polar(*weight, kappa * (j as f64 - degree as f64)))
            .sum();
        *mode /= symbol * cells as f64;
    }
    symplint_fft::inverse(cells).process(&mut modes);
    modes.iter().map(|mode| mode.re).collect()
}

/// The spline with the given coefficients as one polynomial for each cell: its Taylor series at
/// the cell's left end.
fn cell_polynomials(degree: usize, coefficients: &[f64]) -> Vec<[f64; MAX_DEGREE + 1]> {
    let cells = coefficients.len();
    let powers = bspline::powers(degree);
    (0..cells)
        .map(|cell| {
            powers.map(|weights| {
                (0..=degree)
                    .map(|j| weights[j] * coefficients[(cell + cells - degree + j) % cells])
                    .sum()
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn rough_values(cells: usize) -> Vec<f64> {
        (0..cells)
            .map(|i| ((i * i * 7 + 3) % 11) as f64 - 5.0)
            .collect()
    }

    /// Rounding errors are relative to this: for even degrees the alternating mode is amplified.
    fn largest_coefficient(spline: &PeriodicSpline) -> f64 {
        spline
            .values
            .iter()
            .flatten()
            .fold(1.0, |largest, c| c.abs().max(largest))
    }

    #[test]
    fn the_values_at_the_nodes_are_reproduced() {
        for degree in 1..=MAX_DEGREE {
            for cells in [degree + 1, 7, 24, 25, 101] {
                let values = rough_values(cells);
                let Ok(spline) = PeriodicSpline::interpolating(degree, TAU, &values) else {
                    assert!(cells <= degree || (degree % 2 == 0 && cells % 2 == 0));
                    continue;
                };
                let scale = largest_coefficient(&spline);
                for (i, value) in values.iter().enumerate() {
                    for turns in [0.0, -2.0, 3.0] {
                        let got = spline.value(spline.grid().node(i) + turns * TAU);
                        assert!(
                            (got - value).abs() < 1e-15 * scale * cells as f64,
                            "degree {degree}, {cells} cells, node {i}: {got} for {value}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn pieces_join_with_all_but_the_highest_derivative() {
        for degree in 1..=MAX_DEGREE {
            let spline = PeriodicSpline::interpolating(degree, TAU, &rough_values(25)).unwrap();
            for cell in 0..25 {
                let (mut left, mut right) = (spline.values[cell], spline.values[(cell + 1) % 25]);
                for order in 0..=degree {
                    let (end, start) = (horner(&left, 1.0), horner(&right, 0.0));
                    let jump = (end - start).abs() / largest_coefficient(&spline);
                    if order < degree {
                        assert!(jump < 1e-13, "degree {degree}, order {order}: {jump}");
                    }
                    left = differentiated(left);
                    right = differentiated(right);
                }
            }
            // The highest derivative does jump somewhere, or the test above tests nothing.
            let highest = |cell: usize| spline.values[cell][degree];
            assert!((0..24).any(|cell| (highest(cell) - highest(cell + 1)).abs() > 1e-3));
        }
    }

    fn differentiated(polynomial: [f64; MAX_DEGREE + 1]) -> [f64; MAX_DEGREE + 1] {
        std::array::from_fn(|n| {
            polynomial
                .get(n + 1)
                .map_or(0.0, |next| (n + 1) as f64 * next)
        })
    }

    #[test]
    fn interpolation_converges_at_the_order_of_the_degree() {
        let error = |degree: usize, cells: usize| {
            let grid = PeriodicGrid::new(cells, TAU).unwrap();
            let values: Vec<f64> = (0..cells).map(|i| grid.node(i).sin()).collect();
            let spline = PeriodicSpline::interpolating(degree, TAU, &values).unwrap();
            (0..1000)
                .map(|k| f64::from(k) * TAU / 1000.0)
                .map(|q| (spline.value(q) - q.sin()).abs())
                .fold(0.0, f64::max)
        };
        for degree in 1..=MAX_DEGREE {
            // Odd numbers of cells, with a ratio of 3.
            let order = (error(degree, 15) / error(degree, 45)).log(3.0);
            assert!(
                (order - (degree + 1) as f64).abs() < 0.2,
                "degree {degree}: order {order}"
            );
        }
    }

    #[test]
    fn the_slope_at_a_node_is_that_from_the_right() {
        for length in [49.0, 12.566, 628.0 / 100.0, 1.0, TAU] {
            for cells in [2, 4, 7, 8, 100, 127, 500] {
                let values = rough_values(cells);
                let spline = PeriodicSpline::interpolating(1, length, &values).unwrap();
                let slope = |i: usize| {
                    let rise = values[(i + 1) % cells] - values[i % cells];
                    rise * cells as f64 / length
                };
                for i in 0..cells {
                    let node = spline.grid().node(i);
                    for (q, expected) in [
                        (node, slope(i)),
                        (node.next_up(), slope(i)),
                        (node.next_down(), slope(i + cells - 1)),
                    ] {
                        let off = (spline.derivative(q) - expected).abs();
                        assert!(off < 1e-9, "node {i} of {cells} × {length}: {off:e}");
                    }
                }
                for end in [length, -length, 1024.0 * length] {
                    assert_eq!(spline.derivative(end), spline.derivative(0.0));
                }
            }
        }
    }

    #[test]
    fn what_cannot_be_interpolated_is_refused_with_the_reason() {
        let attempt = |degree, cells| {
            PeriodicSpline::interpolating(degree, TAU, &vec![1.0; cells]).map(|_| ())
        };
        assert_eq!(
            attempt(2, 24),
            Err(ModelError::SingularCollocation {
                degree: 2,
                cells: 24
            })
        );
        assert_eq!(
            attempt(4, 3),
            Err(ModelError::TooFewCells {
                degree: 4,
                cells: 3,
                needed: 5
            })
        );
        assert!(matches!(
            attempt(0, 25),
            Err(ModelError::Degree { degree: 0, .. })
        ));
        assert!(matches!(
            attempt(6, 25),
            Err(ModelError::Degree { degree: 6, .. })
        ));
        assert_eq!(attempt(3, 24), Ok(()));
        assert!(PeriodicSpline::interpolating(1, TAU, &[0.0, f64::NAN, 1.0]).is_err());
    }
}

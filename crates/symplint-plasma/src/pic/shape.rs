//! Shapes of particles: the basis functions of a mesh, seen from one cell of one axis.

use symplint_models::ModelError;
use symplint_models::bspline::{self, CellWeights, MAX_DEGREE};

/// Which piecewise polynomials carry charge and potential.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShapeFamily {
    /// Cardinal B-splines, degree 1 to 5: degree p has p − 1 continuous derivatives. One for each
    /// cell, p + 1 cells wide (Barham & Burby, section 5.1).
    #[default]
    BSpline,
    /// Continuous Lagrange elements with equally spaced nodes, degree 1 to 3: the slope jumps at
    /// every cell boundary, whatever the degree. p nodes for each cell and axis.
    Lagrange,
}

impl ShapeFamily {
    /// The family's name in configurations and reports.
    pub fn name(self) -> &'static str {
        match self {
            ShapeFamily::BSpline => "b-spline",
            ShapeFamily::Lagrange => "lagrange",
        }
    }

    /// The highest degree provided; the lowest is 1.
    pub fn highest_degree(self) -> usize {
        match self {
            ShapeFamily::BSpline => MAX_DEGREE,
            ShapeFamily::Lagrange => 3,
        }
    }
}

/// A family and a degree that exists in it.
///
/// A cell sees degree + 1 functions, which sum to 1. Those of B-splines come in the order of
/// [`bspline::weights`], those of Lagrange elements in the order of their nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Shape {
    family: ShapeFamily,
    degree: usize,
}

impl Shape {
    pub(super) fn new(family: ShapeFamily, degree: usize) -> Result<Self, ModelError> {
        if !(1..=family.highest_degree()).contains(&degree) {
            return Err(ModelError::ShapeDegree {
                family: family.name(),
                degree,
                highest: family.highest_degree(),
            });
        }
        Ok(Shape { family, degree })
    }

    pub(super) fn family(self) -> ShapeFamily {
        self.family
    }

    pub(super) fn degree(self) -> usize {
        self.degree
    }

    /// Nodes, that is basis functions, for each cell of an axis.
    pub(super) fn nodes_per_cell(self) -> usize {
        match self.family {
            ShapeFamily::BSpline => 1,
            ShapeFamily::Lagrange => self.degree,
        }
    }

    /// Values at the fraction `x` of the cell.
    #[inline]
    pub(super) fn values(self, x: f64) -> CellWeights {
        match self.family {
            ShapeFamily::BSpline => bspline::weights(self.degree, x),
            ShapeFamily::Lagrange => lagrange_values(self.degree, x),
        }
    }

    /// The functions as polynomials of the fraction: row n has the coefficients of its nth power.
    pub(super) fn powers(self) -> [CellWeights; MAX_DEGREE + 1] {
        match self.family {
            ShapeFamily::BSpline => bspline::powers(self.degree),
            ShapeFamily::Lagrange => lagrange_powers(self.degree),
        }
    }

    /// Derivatives at the fraction `x` of the cell, by the fraction.
    #[inline]
    pub(super) fn slopes(self, x: f64) -> CellWeights {
        match self.family {
            ShapeFamily::BSpline => bspline::derivative_weights(self.degree, 1, x),
            ShapeFamily::Lagrange => lagrange_slopes(self.degree, x),
        }
    }

    /// Second derivatives at the fraction `x` of the cell, by the fraction.
    pub(super) fn curvatures(self, x: f64) -> CellWeights {
        match self.family {
            ShapeFamily::BSpline => bspline::derivative_weights(self.degree, 2, x),
            ShapeFamily::Lagrange => lagrange_curvatures(self.degree, x),
        }
    }
}

/// The products of [`lagrange_values`], multiplied out.
fn lagrange_powers(degree: usize) -> [CellWeights; MAX_DEGREE + 1] {
    let mut powers = [CellWeights::default(); MAX_DEGREE + 1];
    for j in 0..=degree {
        let mut product = CellWeights::default();
        product[0] = 1.0;
        for i in (0..=degree).filter(|&i| i != j) {
            let (scale, shift) = (degree as f64, i as f64);
            for n in (1..=degree).rev() {
                product[n] = scale * product[n - 1] - shift * product[n];
            }
            product[0] *= -shift;
            product = product.map(|coefficient| coefficient / (j as f64 - shift));
        }
        for (row, coefficient) in powers.iter_mut().zip(product) {
            row[j] = coefficient;
        }
    }
    powers
}

/// Lagrange polynomials of the nodes j / degree: Π_{i≠j} (degree · x − i) / (j − i).
#[inline]
fn lagrange_values(degree: usize, x: f64) -> CellWeights {
    let mut values = CellWeights::default();
    let x = degree as f64 * x;
    for (j, value) in values.iter_mut().enumerate().take(degree + 1) {
        *value = 1.0;
        for i in (0..=degree).filter(|&i| i != j) {
            *value *= (x - i as f64) / (j as f64 - i as f64);
        }
    }
    values
}

/// Their derivatives, by the product rule.
#[inline]
fn lagrange_slopes(degree: usize, x: f64) -> CellWeights {
    let mut slopes = CellWeights::default();
    let x = degree as f64 * x;
    for (j, slope) in slopes.iter_mut().enumerate().take(degree + 1) {
        for k in (0..=degree).filter(|&k| k != j) {
            let mut term = degree as f64 / (j as f64 - k as f64);
            for i in (0..=degree).filter(|&i| i != j && i != k) {
                term *= (x - i as f64) / (j as f64 - i as f64);
            }
            *slope += term;
        }
    }
    slopes
}

/// Their second derivatives, by the product rule.
fn lagrange_curvatures(degree: usize, x: f64) -> CellWeights {
    let mut curvatures = CellWeights::default();
    let scale = degree as f64;
    for (j, curvature) in curvatures.iter_mut().enumerate().take(degree + 1) {
        let factor = |i: usize| scale / (j as f64 - i as f64);
        for k in (0..=degree).filter(|&k| k != j) {
            for l in (0..=degree).filter(|&l| l != j && l != k) {
                let others = (0..=degree).filter(|&i| i != j && i != k && i != l);
                let rest: f64 = others.map(|i| factor(i) * (x - i as f64 / scale)).product();
                *curvature += factor(k) * factor(l) * rest;
            }
        }
    }
    curvatures
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all_shapes() -> impl Iterator<Item = Shape> {
        [ShapeFamily::BSpline, ShapeFamily::Lagrange]
            .into_iter()
            .flat_map(|family| {
                (1..=family.highest_degree()).map(move |degree| Shape { family, degree })
            })
    }

    #[test]
    fn shapes_sum_to_one_and_slopes_to_zero() {
        for shape in all_shapes() {
            for step in 0..=50 {
                let x = f64::from(step) / 50.0;
                let (values, slopes) = (shape.values(x), shape.slopes(x));
                assert!((values.iter().sum::<f64>() - 1.0).abs() < 1e-14);
                assert!(slopes.iter().sum::<f64>().abs() < 1e-13);
                assert!(values[shape.degree() + 1..].iter().all(|&v| v == 0.0));
            }
        }
    }

    #[test]
    fn powers_add_up_to_values() {
        for shape in all_shapes() {
            let powers = shape.powers();
            for step in 0..=50 {
                let x = f64::from(step) / 50.0;
                for (j, value) in shape.values(x).iter().enumerate() {
                    let sum = powers.iter().rev().fold(0.0, |sum, row| sum * x + row[j]);
                    assert!((sum - value).abs() < 1e-14, "{shape:?}, {j}: {sum}");
                }
            }
        }
    }

    #[test]
    fn slopes_are_derivatives_of_values() {
        const STEP: f64 = 1e-3;
        for shape in all_shapes() {
            for step in 1..10 {
                let x = f64::from(step) / 10.0;
                let at = |shift: f64| shape.values(x + shift * STEP);
                let slopes = shape.slopes(x);
                for (j, slope) in slopes.iter().enumerate() {
                    let difference = (at(-2.0)[j] - 8.0 * at(-1.0)[j] + 8.0 * at(1.0)[j]
                        - at(2.0)[j])
                        / (12.0 * STEP);
                    assert!((difference - slope).abs() < 1e-9, "{shape:?}, {j}");
                }
            }
        }
    }

    #[test]
    fn curvatures_are_derivatives_of_slopes() {
        // Differences of fourth order are exact for slopes of degree 4 but for round-off.
        const STEP: f64 = 1.0 / 1024.0;
        for shape in all_shapes() {
            for step in 1..10 {
                let x = f64::from(step) / 10.0;
                let at = |shift: f64| shape.slopes(x + shift * STEP);
                for (j, curvature) in shape.curvatures(x).iter().enumerate() {
                    let difference = (at(-2.0)[j] - 8.0 * at(-1.0)[j] + 8.0 * at(1.0)[j]
                        - at(2.0)[j])
                        / (12.0 * STEP);
                    assert!((difference - curvature).abs() < 1e-11, "{shape:?}, {j}");
                }
            }
        }
    }

    #[test]
    fn lagrange_shapes_are_one_at_their_own_node_only() {
        for degree in 1..=3 {
            for node in 0..=degree {
                let values = lagrange_values(degree, node as f64 / degree as f64);
                for (j, value) in values.iter().enumerate() {
                    let expected = f64::from(u8::from(j == node));
                    assert!((value - expected).abs() < 1e-15);
                }
            }
        }
    }
}

//! Stiffness, mass and filter of one axis, for one Fourier mode over the cells.
//!
//! On equal cells round a period these matrices are block-circulant: Fourier modes e^{iκc} over
//! the cells c leave one small Hermitian matrix for each κ, whose rows are the nodes of a cell.
//! A matrix entry between overlapping images is their sum, so the same formulas hold
//! for boxes narrower than a shape.

use nalgebra::{DMatrix, DVector};
use symplint_fft::Complex64;

use super::shape::{Shape, ShapeFamily};

pub(super) type ComplexMatrix = DMatrix<Complex64>;

/// The matrices of one axis for the wave number κ.
///
/// Stiffness and mass are in a basis in which the smoothest function comes first: the one that is
/// linear between cell boundaries, followed by those that vanish there. In one dimension the first
/// is orthogonal to the others in the stiffness product, which is 4 sin²(κ/2) for it
/// on cells of width 1, so long waves lose no digits to cancellation.
pub(super) struct AxisMode {
    /// Columns: the functions of that basis, by their values at the nodes of cell 0.
    pub(super) basis: ComplexMatrix,
    pub(super) stiffness: ComplexMatrix,
    pub(super) mass: ComplexMatrix,
    /// The binary filter to the power s/2, at the nodes.
    pub(super) filter: ComplexMatrix,
}

impl AxisMode {
    /// Mode `k` of `cells` cells of width 1, with `passes` passes of the filter.
    pub(super) fn new(shape: Shape, cells: usize, passes: u32, k: usize) -> Self {
        let half_kappa = std::f64::consts::PI * k as f64 / cells as f64;
        let kappa = 2.0 * half_kappa;
        let laplacian = 4.0 * half_kappa.sin().powi(2);
        let filter = filter(shape.nodes_per_cell(), kappa, passes);
        match shape.family() {
            ShapeFamily::BSpline => {
                let p = shape.degree();
                let one_by_one = |value: f64| ComplexMatrix::from_element(1, 1, value.into());
                AxisMode {
                    basis: one_by_one(1.0),
                    stiffness: one_by_one(laplacian * spline_symbol(2 * p - 1, kappa)),
                    mass: one_by_one(spline_symbol(2 * p + 1, kappa)),
                    filter,
                }
            }
            ShapeFamily::Lagrange => {
                let phase = Complex64::cis(kappa);
                let (mut stiffness, mass) = lagrange_products(shape, phase);
                stiffness[(0, 0)] = laplacian.into();
                AxisMode {
                    basis: lagrange_basis(shape, phase),
                    stiffness,
                    mass,
                    filter,
                }
            }
        }
    }
}

/// Σ_j β^n(j) e^{ijκ} for odd n, β^n the centred cardinal B-spline of degree n.
///
/// Its values at the integers are Eulerian numbers over n!.
fn spline_symbol(n: usize, kappa: f64) -> f64 {
    // A(n, m) = (n − m) A(n − 1, m − 1) + (m + 1) A(n − 1, m), exact here: n ≤ 11.
    let mut eulerian = vec![0.0; n];
    eulerian[0] = 1.0;
    for degree in 2..=n {
        for m in (1..degree).rev() {
            eulerian[m] = (degree - m) as f64 * eulerian[m - 1] + (m + 1) as f64 * eulerian[m];
        }
    }
    let factorial: f64 = eulerian.iter().sum();
    let centre = (n - 1) / 2;
    let sides: f64 = (1..=centre)
        .rev()
        .map(|j| 2.0 * eulerian[centre - j] * (j as f64 * kappa).cos())
        .sum();
    (sides + eulerian[centre]) / factorial
}

/// The binary filter (¼, ½, ¼) on the nodes of an axis to the power passes / 2.
///
/// Its eigenvectors are the waves over the nodes, and its eigenvalues cos²(θ/2) for the phase
/// θ from node to node: m of them, θ = (κ + 2πr)/m, look alike from cell to cell.
fn filter(nodes_per_cell: usize, kappa: f64, passes: u32) -> ComplexMatrix {
    let m = nodes_per_cell;
    if passes == 0 {
        return ComplexMatrix::identity(m, m);
    }
    let waves = (0..m).map(|r| (kappa + std::f64::consts::TAU * r as f64) / m as f64);
    waves.fold(ComplexMatrix::zeros(m, m), |sum, theta| {
        let power = (0.5 * theta).cos().abs().powf(f64::from(passes));
        sum + ComplexMatrix::from_fn(m, m, |a, b| {
            Complex64::from_polar(power / m as f64, theta * (a as f64 - b as f64))
        })
    })
}

/// Nodal values of the linear function between the cell's ends 1 and e^{iκ}, and of the functions
/// of the inner nodes.
fn lagrange_basis(shape: Shape, phase: Complex64) -> ComplexMatrix {
    let m = shape.degree();
    let mut basis = ComplexMatrix::identity(m, m);
    for node in 0..m {
        basis[(node, 0)] = 1.0 + (phase - 1.0) * (node as f64 / m as f64);
    }
    basis
}

/// Stiffness and mass of that basis on a cell of width 1, the stiffness of the first function
/// with all others left 0.
fn lagrange_products(shape: Shape, phase: Complex64) -> (ComplexMatrix, ComplexMatrix) {
    let m = shape.degree();
    let mut stiffness = ComplexMatrix::zeros(m, m);
    let mut mass = ComplexMatrix::zeros(m, m);
    for (x, weight) in GAUSS_4 {
        let (values, slopes) = (shape.values(x), shape.slopes(x));
        let mut value = DVector::from_fn(m, |j, _| Complex64::from(values[j]));
        let mut slope = DVector::from_fn(m, |j, _| Complex64::from(slopes[j]));
        value[0] = 1.0 + (phase - 1.0) * x;
        slope[0] = Complex64::ZERO;
        let weight = Complex64::from(weight);
        mass += value.conjugate() * value.transpose() * weight;
        stiffness += slope.conjugate() * slope.transpose() * weight;
    }
    (stiffness, mass)
}

/// ∫ of each node's function over one axis, in cell widths.
pub(super) fn node_integrals(shape: Shape) -> Vec<f64> {
    match shape.family() {
        ShapeFamily::BSpline => vec![1.0],
        ShapeFamily::Lagrange => {
            let mut integrals = vec![0.0; shape.degree()];
            for (x, weight) in GAUSS_4 {
                for (j, value) in shape.values(x)[..=shape.degree()].iter().enumerate() {
                    // The last node of a cell is the first of the next.
                    integrals[j % shape.degree()] += weight * value;
                }
            }
            integrals
        }
    }
}

/// Gauss–Legendre nodes and weights on [0, 1], exact for degree 7.
const GAUSS_4: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// The stiffness symbols as they are usually written out.
    #[test]
    fn spline_symbols_are_the_tabulated_ones() {
        for step in 0..20 {
            let kappa = 0.4 * f64::from(step);
            let cosine = |n: f64| (n * kappa).cos();
            let tabulated = [
                (1, 1.0),
                (3, 2.0 / 3.0 + cosine(1.0) / 3.0),
                (5, (66.0 + 52.0 * cosine(1.0) + 2.0 * cosine(2.0)) / 120.0),
            ];
            for (n, expected) in tabulated {
                assert!((spline_symbol(n, kappa) - expected).abs() < 1e-15, "{n}");
            }
        }
    }

    #[test]
    fn node_integrals_are_newton_cotes_weights() {
        let weights = |degree| node_integrals(Shape::new(ShapeFamily::Lagrange, degree).unwrap());
        for (degree, expected) in [
            (1, vec![1.0]),
            (2, vec![1.0 / 3.0, 2.0 / 3.0]),
            (3, vec![1.0 / 4.0, 3.0 / 8.0, 3.0 / 8.0]),
        ] {
            for (got, expected) in weights(degree).iter().zip(expected) {
                assert!((got - expected).abs() < 1e-15, "degree {degree}");
            }
        }
    }
}

//! Particle-in-cell fields and energies against dense matrices made from the basis functions
//! themselves: sums over periodic images, stiffness by quadrature, inverses by eigenvalues.

use nalgebra::{DMatrix, DVector};
use symplint::state::Rows;
use symplint_models::Separable;
use symplint_plasma::pic::{ParticleWeights, Pic, PicConfig, ShapeFamily};

/// A basis function of one axis in units of the cell, not periodic: its piecewise polynomial.
fn function(family: ShapeFamily, degree: usize, node: usize, x: f64) -> f64 {
    match family {
        ShapeFamily::BSpline => truncated_powers(degree, x - node as f64),
        ShapeFamily::Lagrange => {
            let (cell, place) = (node / degree, node % degree);
            let x = x - cell as f64;
            // The function of an inner node lives on its cell, that of a corner on both sides.
            let inside = |x: f64, place: usize| {
                if !(0.0..1.0).contains(&x) {
                    return 0.0;
                }
                let others = (0..=degree).filter(|&other| other != place);
                others
                    .map(|other| (degree as f64 * x - other as f64) / (place as f64 - other as f64))
                    .product()
            };
            if place == 0 {
                inside(x, 0) + inside(x + 1.0, degree)
            } else {
                inside(x, place)
            }
        }
    }
}

/// The B-spline on [0, p + 1]: Σ_k (−1)^k C(p+1, k) (x − k)₊^p / p!.
fn truncated_powers(degree: usize, x: f64) -> f64 {
    if x >= (degree + 1) as f64 {
        return 0.0;
    }
    let (mut sum, mut binomial, mut factorial) = (0.0, 1.0, 1.0);
    for k in 0..=degree + 1 {
        let base = (x - k as f64).max(0.0);
        sum += binomial * base.powi(degree as i32);
        binomial *= -((degree + 1 - k) as f64) / (k + 1) as f64;
        factorial *= k.clamp(1, degree) as f64;
    }
    sum / factorial
}

/// Gauss–Legendre nodes and weights on [0, 1], exact for degree 11.
fn gauss() -> impl Iterator<Item = (f64, f64)> {
    let half = [
        (0.238_619_186_083_196_9, 0.467_913_934_572_691_04),
        (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
        (0.932_469_514_203_152, 0.171_324_492_379_170_36),
    ];
    half.into_iter()
        .flat_map(|(x, weight)| [-x, x].map(|x| (0.5 + 0.5 * x, 0.5 * weight)))
}

/// One axis of a mesh: functions summed over images, dense matrices.
struct Axis {
    family: ShapeFamily,
    degree: usize,
    cells: usize,
    width: f64,
}

impl Axis {
    fn nodes(&self) -> usize {
        match self.family {
            ShapeFamily::BSpline => self.cells,
            ShapeFamily::Lagrange => self.cells * self.degree,
        }
    }

    fn value(&self, node: usize, x: f64) -> f64 {
        // The images that reach into the box: splines start at most `degree` cells below it.
        let images = (self.degree / self.cells + 2) as i32;
        let x = x.rem_euclid(self.cells as f64 * self.width) / self.width;
        (-images..=images)
            .map(|image| {
                let shift = f64::from(image) * self.cells as f64;
                function(self.family, self.degree, node, x + shift)
            })
            .sum()
    }

    /// By a difference that is exact for degree 5 up to rounding errors, inside the cell.
    fn slope(&self, node: usize, x: f64) -> f64 {
        let h = 0.01 * self.width;
        let f = |k: f64| self.value(node, x + k * h) - self.value(node, x - k * h);
        (45.0 * f(1.0) - 9.0 * f(2.0) + f(3.0)) / (60.0 * h)
    }

    /// ∫ f_i f_j over the box, for the functions `f` (i, x).
    fn products(&self, f: impl Fn(usize, f64) -> f64) -> DMatrix<f64> {
        let mut products = DMatrix::zeros(self.nodes(), self.nodes());
        for cell in 0..self.cells {
            for (x, weight) in gauss() {
                let x = (cell as f64 + x) * self.width;
                let values = DVector::from_fn(self.nodes(), |i, _| f(i, x));
                products += &values * values.transpose() * (weight * self.width);
            }
        }
        products
    }

    fn integrals(&self) -> DVector<f64> {
        DVector::from_fn(self.nodes(), |i, _| {
            let points = (0..self.cells).flat_map(|cell| gauss().map(move |(x, w)| (cell, x, w)));
            points
                .map(|(cell, x, w)| self.value(i, (cell as f64 + x) * self.width) * w * self.width)
                .sum()
        })
    }

    fn filter(&self) -> DMatrix<f64> {
        let n = self.nodes();
        let mut filter = DMatrix::identity(n, n) * 0.5;
        for i in 0..n {
            filter[(i, (i + 1) % n)] += 0.25;
            filter[(i, (i + n - 1) % n)] += 0.25;
        }
        filter
    }
}

/// f(A) of a symmetric matrix.
fn spectral(matrix: DMatrix<f64>, f: impl Fn(f64) -> f64) -> DMatrix<f64> {
    let eigen = matrix.symmetric_eigen();
    let values = DMatrix::from_diagonal(&eigen.eigenvalues.map(f));
    &eigen.eigenvectors * values * eigen.eigenvectors.transpose()
}

/// Numbers in (0, 1) without a pattern.
fn scattered(seed: usize) -> impl FnMut() -> f64 {
    let mut k = seed as f64;
    move || {
        k += 1.0;
        (k * 0.618_033_988_749_894_9 + (k * k).sin() * 0.1).rem_euclid(1.0)
    }
}

/// Checks energy and field of a few particles of unequal weights.
fn check<const D: usize>(family: ShapeFamily, degree: usize, cells: usize, filter_passes: u32) {
    let what = format!("{D}-D, {family:?} {degree}, {cells} cells, filter {filter_passes}");
    let length = 1.7 * cells as f64;
    let weights = vec![1.0, 0.3, 2.5, -0.4];
    let mut random = scattered(degree + 10 * cells);
    // Away from cell boundaries, for the differences; some far outside the box.
    let positions: Vec<f64> = (0..D * weights.len())
        .map(|i| {
            let cell = (random() * cells as f64).floor() + (i % 3) as f64 * cells as f64;
            1.7 * (cell - cells as f64 + 0.1 + 0.8 * random())
        })
        .collect();
    let pic = Pic::<D>::new(PicConfig {
        weights: ParticleWeights::Each(weights.clone()),
        cells,
        length,
        family,
        degree,
        filter_passes,
    })
    .unwrap();

    let axis = Axis {
        family,
        degree,
        cells,
        width: 1.7,
    };
    let mass = axis.products(|i, x| axis.value(i, x));
    let stiffness = axis.products(|i, x| axis.slope(i, x));
    // The alternating wave has the eigenvalue 0, whose square root must not be that of a rounding error.
    let half_power = |b: f64| {
        if b < 1e-12 {
            0.0
        } else {
            b.powf(f64::from(filter_passes) / 2.0)
        }
    };
    let half_filter = if filter_passes == 0 {
        DMatrix::identity(axis.nodes(), axis.nodes())
    } else {
        spectral(axis.filter(), half_power)
    };
    let (stiffness, half_filter, integrals) = if D == 1 {
        (stiffness, half_filter, axis.integrals())
    } else {
        (
            stiffness.kronecker(&mass) + mass.kronecker(&stiffness),
            half_filter.kronecker(&half_filter),
            axis.integrals().kronecker(&axis.integrals()),
        )
    };
    let inverse = spectral(stiffness, |l| if l < 1e-9 { 0.0 } else { 1.0 / l });
    // Eigenvectors known to round-off, times this, is what the oracle does not know.
    let softest = inverse.amax();
    let green = &half_filter * inverse * &half_filter;

    // All functions, or their derivatives along `along`, at a position.
    let functions = |x: &[f64], along: Option<usize>| -> DVector<f64> {
        let axes = x.iter().enumerate().map(|(c, &x)| {
            DVector::from_fn(axis.nodes(), |i, _| {
                if along == Some(c) {
                    axis.slope(i, x)
                } else {
                    axis.value(i, x)
                }
            })
        });
        axes.reduce(|product, values| product.kronecker(&values))
            .unwrap()
    };
    let particles = positions.chunks_exact(D);
    let charge: f64 = weights.iter().sum();
    let mut rho = &integrals * (-charge / integrals.sum());
    for (x, weight) in particles.clone().zip(&weights) {
        rho += functions(x, None) * *weight;
    }
    let phi = &green * &rho;
    let scale = phi.amax().max(0.1) + 1e-3 * softest;

    let dof = D * weights.len();
    let mut energy = [0.0];
    pic.potential_energy(Rows::new(&positions, dof, 1, 1), &mut energy);
    let expected = 0.5 * rho.dot(&phi);
    assert!(
        (energy[0] - expected).abs() < 1e-11 * scale,
        "{what}: {} for {expected}",
        energy[0]
    );

    let field = pic.field(&positions);
    for (a, x) in particles.enumerate() {
        for c in 0..D {
            let expected = -functions(x, Some(c)).dot(&phi);
            let got = field[D * a + c];
            assert!(
                (got - expected).abs() < 3e-11 * scale,
                "{what}: particle {a}, axis {c}: {got} for {expected}"
            );
        }
        let got = pic.potential_at(&positions, &[std::array::from_fn(|c| x[c])])[0];
        let expected = functions(x, None).dot(&phi);
        // Potentials may differ by a constant.
        let origin =
            functions(&[0.3; D], None).dot(&phi) - pic.potential_at(&positions, &[[0.3; D]])[0];
        assert!(
            (got + origin - expected).abs() < 1e-10 * scale,
            "{what}: potential at {a}"
        );
    }
    assert!(pic.total_charge(&positions).abs() < 1e-13, "{what}");
}

fn shapes() -> impl Iterator<Item = (ShapeFamily, usize)> {
    let splines = (1..=5).map(|degree| (ShapeFamily::BSpline, degree));
    splines.chain((1..=3).map(|degree| (ShapeFamily::Lagrange, degree)))
}

#[test]
fn one_dimension() {
    for (family, degree) in shapes() {
        for cells in 1..=9 {
            for filter_passes in [0, 1, 2, 3, 4] {
                check::<1>(family, degree, cells, filter_passes);
            }
        }
    }
}

#[test]
fn two_dimensions() {
    for (family, degree) in shapes() {
        for cells in 1..=4 {
            for filter_passes in [0, 2, 3] {
                check::<2>(family, degree, cells, filter_passes);
            }
        }
    }
}

//! The scheme of Kraus et al. as it is written down: in physical variables, with dense matrices made of the basis
//! functions themselves, and path integrals by quadrature.

use nalgebra::{DMatrix, DVector};
use symplint_plasma::gempic::{Gempic, GempicConfig, PhysicalState};
use symplint_plasma::pic::ParticleWeights;

/// Numbers in (−1, 1) without a pattern.
pub fn scattered(seed: usize) -> impl FnMut() -> f64 {
    let mut k = seed as f64;
    move || {
        k += 1.0;
        2.0 * (1e4 * (1.7 * k).sin()).rem_euclid(1.0) - 1.0
    }
}

/// The same numbers with one of them changed.
pub fn shifted(values: &[f64], i: usize, by: f64) -> Vec<f64> {
    let mut values = values.to_vec();
    values[i] += by;
    values
}

/// The B-spline on [0, p + 1]: Σ_k (−1)^k C(p+1, k) (x − k)₊^p / p!.
fn truncated_powers(degree: usize, x: f64) -> f64 {
    if !(0.0..(degree + 1) as f64).contains(&x) {
        return 0.0;
    }
    let (mut sum, mut binomial) = (0.0, 1.0);
    for k in 0..=degree + 1 {
        let base = x - k as f64;
        if base >= 0.0 {
            sum += binomial * base.powi(degree as i32);
        }
        binomial *= -((degree + 1 - k) as f64) / (k + 1) as f64;
    }
    sum / (1..=degree).product::<usize>() as f64
}

/// Gauss–Legendre nodes and weights on [0, 1], exact for degree 11.
pub fn gauss() -> impl Iterator<Item = (f64, f64)> {
    let half = [
        (0.238_619_186_083_196_9, 0.467_913_934_572_691_04),
        (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
        (0.932_469_514_203_152, 0.171_324_492_379_170_36),
    ];
    half.into_iter()
        .flat_map(|(x, weight)| [-x, x].map(|x| (0.5 + 0.5 * x, 0.5 * weight)))
}

/// A plasma by its definition.
pub struct Plasma {
    pub config: GempicConfig,
    pub weights: Vec<f64>,
    pub m0: DMatrix<f64>,
    pub m1: DMatrix<f64>,
    /// (C a)_j = a_j − a_j−1.
    pub c: DMatrix<f64>,
    pub inverse0: DMatrix<f64>,
    pub inverse1: DMatrix<f64>,
}

/// Physical variables with b as one of them.
#[derive(Clone, Debug)]
pub struct Fields {
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    pub v1: Vec<f64>,
    pub v2: Vec<f64>,
    pub a1: DVector<f64>,
    pub a2: DVector<f64>,
    pub e1: DVector<f64>,
    pub e2: DVector<f64>,
    pub b: DVector<f64>,
}

/// Particles of different weights on `cells` cells of a box of length 2π.
pub fn config(degree: usize, cells: usize, particles: usize) -> GempicConfig {
    let mut random = scattered(7);
    GempicConfig {
        degree,
        cells,
        weights: ParticleWeights::Each((0..particles).map(|_| 1.2 + 0.7 * random()).collect()),
        charge: -1.3,
        mass: 0.8,
        ..GempicConfig::default()
    }
}

/// A random state of moderate size.
pub fn random_state(gempic: &Gempic, seed: usize) -> PhysicalState {
    let (particles, cells) = (gempic.weights().len(), gempic.cells());
    let mut random = scattered(seed);
    let mut list = |len: usize, size: f64| (0..len).map(|_| size * random()).collect();
    PhysicalState {
        x: list(particles, 5.0),
        y: list(particles, 1.0),
        v1: list(particles, 1.0),
        v2: list(particles, 1.0),
        a1: list(cells, 0.5),
        a2: list(cells, 0.5),
        e1: list(cells, 0.5),
        e2: list(cells, 0.5),
    }
}

impl Plasma {
    pub fn new(config: GempicConfig) -> Self {
        let ParticleWeights::Each(weights) = config.weights.clone() else {
            panic!("give a weight for each particle");
        };
        let n = config.cells;
        let mut plasma = Plasma {
            weights,
            m0: DMatrix::zeros(n, n),
            m1: DMatrix::zeros(n, n),
            c: DMatrix::from_fn(n, n, |i, j| {
                f64::from(u8::from(i == j)) - f64::from(u8::from((i + n - 1) % n == j))
            }),
            inverse0: DMatrix::zeros(n, n),
            inverse1: DMatrix::zeros(n, n),
            config,
        };
        let width = plasma.width();
        for cell in 0..n {
            for (node, weight) in gauss() {
                let x = (cell as f64 + node) * width;
                let (zero, one) = (plasma.zero(x), plasma.one(x));
                plasma.m0 += &zero * zero.transpose() * (weight * width);
                plasma.m1 += &one * one.transpose() * (weight * width);
            }
        }
        plasma.inverse0 = plasma.m0.clone().try_inverse().unwrap();
        plasma.inverse1 = plasma.m1.clone().try_inverse().unwrap();
        plasma
    }

    pub fn width(&self) -> f64 {
        self.config.length / self.config.cells as f64
    }

    fn functions(&self, degree: usize, x: f64) -> DVector<f64> {
        let cells = self.config.cells;
        let x = x.rem_euclid(self.config.length) / self.width();
        let images = (degree / cells + 2) as i32;
        DVector::from_fn(cells, |j, _| {
            let image =
                |i: i32| truncated_powers(degree, x - j as f64 + f64::from(i) * cells as f64);
            (-images..=images).map(image).sum()
        })
    }

    /// Λ⁰_j(x).
    pub fn zero(&self, x: f64) -> DVector<f64> {
        self.functions(self.config.degree, x)
    }

    /// Λ¹_j(x).
    pub fn one(&self, x: f64) -> DVector<f64> {
        self.functions(self.config.degree - 1, x) / self.width()
    }

    /// dΛ¹_j/dx: differences of splines of one degree less, 0 for those of degree 0.
    pub fn slope_of_one(&self, x: f64) -> DVector<f64> {
        match self.config.degree {
            1 => DVector::zeros(self.config.cells),
            degree => self.c.transpose() * self.functions(degree - 2, x) / self.width().powi(2),
        }
    }

    /// ∫ Λ¹ dx from `from` to `to`, cell by cell.
    fn path(&self, from: f64, to: f64) -> DVector<f64> {
        let mut sum = DVector::zeros(self.config.cells);
        if from == to {
            return sum;
        }
        let (low, high) = (from.min(to), from.max(to));
        let width = self.width();
        let first = (low / width).floor() as i64;
        let last = (high / width).floor() as i64;
        for cell in first..=last {
            let start = (cell as f64 * width).max(low);
            let end = ((cell + 1) as f64 * width).min(high);
            for (node, weight) in gauss() {
                sum += self.one(start + node * (end - start)) * (weight * (end - start));
            }
        }
        sum * (to - from).signum()
    }

    pub fn fields(&self, state: &PhysicalState) -> Fields {
        let vector = |values: &[f64]| DVector::from_column_slice(values);
        let a2 = vector(&state.a2);
        Fields {
            x: state.x.clone(),
            y: state.y.clone(),
            v1: state.v1.clone(),
            v2: state.v2.clone(),
            a1: vector(&state.a1),
            e1: vector(&state.e1),
            e2: vector(&state.e2),
            b: &self.c * &a2,
            a2,
        }
    }

    /// The flow of part `part` for a time h, as in NUMERICS: H_E, H_B, H_p1, H_p2.
    pub fn flow(&self, part: usize, h: f64, state: &mut Fields) {
        let (q, ratio) = (self.config.charge, self.config.charge / self.config.mass);
        let (mut along, mut across) = (
            DVector::zeros(self.config.cells),
            DVector::zeros(self.config.cells),
        );
        match part {
            0 => {
                for a in 0..state.x.len() {
                    state.v1[a] += h * ratio * self.one(state.x[a]).dot(&state.e1);
                    state.v2[a] += h * ratio * self.zero(state.x[a]).dot(&state.e2);
                }
                state.b -= &self.c * &state.e2 * h;
                state.a1 -= &state.e1 * h;
                state.a2 -= &state.e2 * h;
            }
            1 => state.e2 += &self.inverse0 * (self.c.transpose() * (&self.m1 * &state.b)) * h,
            2 => {
                for a in 0..state.x.len() {
                    let x = state.x[a] + h * state.v1[a];
                    let path = self.path(state.x[a], x);
                    state.v2[a] -= ratio * path.dot(&state.b);
                    along += path * (self.weights[a] * q);
                    state.x[a] = x;
                }
                state.e1 -= &self.inverse1 * along;
            }
            _ => {
                for a in 0..state.x.len() {
                    let (x, v2) = (state.x[a], state.v2[a]);
                    state.v1[a] += h * ratio * v2 * self.one(x).dot(&state.b);
                    state.y[a] += h * v2;
                    across += self.zero(x) * (h * self.weights[a] * q * v2);
                }
                state.e2 -= &self.inverse0 * across;
            }
        }
    }

    /// H by its definition.
    pub fn energy(&self, state: &Fields) -> f64 {
        let particles: f64 = (0..state.x.len())
            .map(|a| {
                let square = state.v1[a].powi(2) + state.v2[a].powi(2);
                0.5 * self.weights[a] * self.config.mass * square
            })
            .sum();
        let quadratic = |v: &DVector<f64>, m: &DMatrix<f64>| 0.5 * v.dot(&(m * v));
        particles
            + quadratic(&state.e1, &self.m1)
            + quadratic(&state.e2, &self.m0)
            + quadratic(&state.b, &self.m1)
    }

    /// The largest difference of a state from one in which b is derived.
    pub fn distance(&self, state: &Fields, other: &PhysicalState) -> f64 {
        let other = self.fields(other);
        let lists = [
            (&state.x, &other.x),
            (&state.y, &other.y),
            (&state.v1, &other.v1),
            (&state.v2, &other.v2),
        ];
        let of_lists = lists
            .into_iter()
            .flat_map(|(a, b)| a.iter().zip(b).map(|(a, b)| (a - b).abs()));
        let vectors = [
            (&state.a1, &other.a1),
            (&state.a2, &other.a2),
            (&state.e1, &other.e1),
            (&state.e2, &other.e2),
            (&state.b, &other.b),
        ];
        let of_vectors = vectors.into_iter().map(|(a, b)| (a - b).amax());
        of_lists.chain(of_vectors).fold(0.0, f64::max)
    }
}

//! The Poisson bracket of Kraus et al. in physical variables, and that it is the canonical one.

use nalgebra::{DMatrix, DVector};
use symplint_plasma::gempic::Gempic;

use crate::gempic::reference::{Plasma, config, random_state, shifted};

/// The first index of each variable: x, v1, v2, e1, e2, b.
struct Places {
    particles: usize,
    cells: usize,
}

impl Places {
    fn len(&self) -> usize {
        3 * (self.particles + self.cells)
    }
    fn x(&self, a: usize) -> usize {
        a
    }
    fn v1(&self, a: usize) -> usize {
        self.particles + a
    }
    fn v2(&self, a: usize) -> usize {
        2 * self.particles + a
    }
    fn e1(&self, j: usize) -> usize {
        3 * self.particles + j
    }
    fn e2(&self, j: usize) -> usize {
        3 * self.particles + self.cells + j
    }
    fn b(&self, j: usize) -> usize {
        3 * self.particles + 2 * self.cells + j
    }
}

/// The matrix of all brackets at a state with positions `x` and field `b`. The functions of V0 and V1 are given, so that
/// derivatives of the matrix are the matrix of their derivatives.
fn brackets(
    plasma: &Plasma,
    x: &[f64],
    b: &DVector<f64>,
    [zero, one]: [&dyn Fn(f64) -> DVector<f64>; 2],
    with_constants: bool,
) -> DMatrix<f64> {
    let (q, m) = (plasma.config.charge, plasma.config.mass);
    let places = Places {
        particles: x.len(),
        cells: plasma.config.cells,
    };
    let mut matrix = DMatrix::zeros(places.len(), places.len());
    let mut set = |i: usize, j: usize, value: f64| {
        matrix[(i, j)] = value;
        matrix[(j, i)] = -value;
    };
    let curl = &plasma.inverse0 * plasma.c.transpose();
    for (a, (&x, &w)) in x.iter().zip(&plasma.weights).enumerate() {
        let (one, zero) = (one(x), zero(x));
        set(places.v1(a), places.v2(a), q * one.dot(b) / (w * m * m));
        let (along, across) = (&plasma.inverse1 * one, &plasma.inverse0 * zero);
        for j in 0..places.cells {
            set(places.v1(a), places.e1(j), q / m * along[j]);
            set(places.v2(a), places.e2(j), q / m * across[j]);
        }
        if with_constants {
            set(places.x(a), places.v1(a), 1.0 / (w * m));
        }
    }
    if with_constants {
        for i in 0..places.cells {
            for j in 0..places.cells {
                set(places.e2(i), places.b(j), curl[(i, j)]);
            }
        }
    }
    matrix
}

/// {{z_i, z_j}, z_k} and its cyclic permutations sum to 0, for all variables.
#[test]
fn the_bracket_satisfies_the_identity_of_jacobi() {
    for degree in 1..=5 {
        let plasma = Plasma::new(config(degree, 7, 3));
        let gempic = Gempic::new(config(degree, 7, 3)).unwrap();
        let state = random_state(&gempic, 6);
        let b = &plasma.c * DVector::from_column_slice(&state.a2);
        let zero = |x: f64| plasma.zero(x);
        let one = |x: f64| plasma.one(x);
        let matrix = brackets(&plasma, &state.x, &b, [&zero, &one], true);
        let places = Places {
            particles: 3,
            cells: 7,
        };
        let n = places.len();
        // Λ⁰' = Cᵀ Λ¹, and in the same way the functions of V1 are differences of splines of one degree less.
        let zero_slope = |x: f64| plasma.c.transpose() * plasma.one(x);
        let one_slope = |x: f64| plasma.slope_of_one(x);
        let nothing = |_: f64| DVector::zeros(7);
        // ∂J_ij/∂z_l as one matrix for each l on which J depends.
        let mut slopes = Vec::new();
        for a in 0..3 {
            let only = |f: &dyn Fn(f64) -> DVector<f64>, x: f64| {
                if x == state.x[a] { f(x) } else { nothing(x) }
            };
            let by_x: [&dyn Fn(f64) -> DVector<f64>; 2] =
                [&|x| only(&zero_slope, x), &|x| only(&one_slope, x)];
            slopes.push((places.x(a), brackets(&plasma, &state.x, &b, by_x, false)));
        }
        for j in 0..7 {
            let unit = DVector::from_fn(7, |i, _| f64::from(u8::from(i == j)));
            let by_b = brackets(&plasma, &state.x, &unit, [&nothing, &one], false);
            // Linear in b: what does not depend on it has to go.
            let rest = brackets(
                &plasma,
                &state.x,
                &DVector::zeros(7),
                [&nothing, &one],
                false,
            );
            slopes.push((places.b(j), by_b - rest));
        }
        let (mut largest, mut terms) = (0.0_f64, 0.0_f64);
        for i in 0..n {
            for j in 0..n {
                for k in 0..n {
                    let cyclic = [(i, j, k), (j, k, i), (k, i, j)];
                    let mut sum = 0.0;
                    for (i, j, k) in cyclic {
                        for (l, slope) in &slopes {
                            let term = slope[(i, j)] * matrix[(*l, k)];
                            sum += term;
                            terms = terms.max(term.abs());
                        }
                    }
                    largest = largest.max(sum.abs());
                }
            }
        }
        println!("degree {degree}: Jacobi's identity to {largest:.1e}, terms to {terms:.1e}");
        assert!(
            terms > 0.1 && largest < 1e-14 * terms,
            "degree {degree}: {largest:e}"
        );
    }
}

/// The derivative of physical by canonical variables carries the canonical bracket into that of Kraus et al.
#[test]
fn the_canonical_variables_have_this_bracket() {
    const STEP: f64 = 1e-3;
    for degree in 1..=5 {
        let plasma = Plasma::new(config(degree, 7, 3));
        let gempic = Gempic::new(config(degree, 7, 3)).unwrap();
        let state = random_state(&gempic, 6);
        let (q, p) = gempic.state(&state).unwrap();
        let dof = q.len();
        let physical = |q: &[f64], p: &[f64]| -> DVector<f64> {
            let state = gempic.physical(q, p);
            let b = &plasma.c * DVector::from_column_slice(&state.a2);
            let lists = [&state.x, &state.v1, &state.v2, &state.e1, &state.e2];
            let lists = lists.into_iter().flatten().copied();
            DVector::from_vec(lists.chain(b.iter().copied()).collect())
        };
        let column = |i: usize, of_position: bool| -> DVector<f64> {
            let at = |k: f64| match of_position {
                true => physical(&shifted(&q, i, k * STEP), &p),
                false => physical(&q, &shifted(&p, i, k * STEP)),
            };
            (at(-2.0) - at(-1.0) * 8.0 + at(1.0) * 8.0 - at(2.0)) / (12.0 * STEP)
        };
        let mut carried = DMatrix::zeros(3 * (3 + 7), 3 * (3 + 7));
        for i in 0..dof {
            // Momenta of particles are canonical over the weight.
            let weight = if i < 6 { plasma.weights[i % 3] } else { 1.0 };
            let (by_q, by_p) = (column(i, true), column(i, false) / weight);
            carried += &by_q * by_p.transpose() - &by_p * by_q.transpose();
        }
        let b = &plasma.c * DVector::from_column_slice(&state.a2);
        let functions: [&dyn Fn(f64) -> DVector<f64>; 2] =
            [&|x| plasma.zero(x), &|x| plasma.one(x)];
        let expected = brackets(&plasma, &state.x, &b, functions, true);
        let largest = (&carried - &expected).amax();
        assert!(
            largest < 1e-9 * expected.amax(),
            "degree {degree}: {largest:e}"
        );
    }
}

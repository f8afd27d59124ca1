//! The Runge–Kutta methods provided.
//!
//! Explicit ones are stepped by [`RungeKutta`](super::RungeKutta), implicit ones by
//! [`ImplicitRungeKutta`](super::ImplicitRungeKutta). HLW is E. Hairer, C. Lubich & G. Wanner, Geometric Numerical
//! Integration, 2nd edition.

pub use super::dormand_prince::{dop853, rk45};
use super::tableau::{Tableau, TableauPair};

/// A tableau whose shape is known to be good.
pub(super) fn tableau(name: &str, order: u32, a: &[&[f64]], b: &[f64], reference: &str) -> Tableau {
    Tableau::new(name, order, a, b, reference).expect("a square table of finite numbers")
}

/// A pair whose numbers of stages are known to agree.
fn pair(name: &str, position: Tableau, momentum: Tableau) -> TableauPair {
    TableauPair::new(name, position, momentum).expect("equal numbers of stages")
}

/// Explicit Euler: order 1.
pub fn euler() -> Tableau {
    tableau("euler", 1, &[&[0.0]], &[1.0], "HLW, section I.1.2")
}

/// The explicit midpoint rule (Runge 1895): order 2.
pub fn midpoint() -> Tableau {
    tableau(
        "midpoint",
        2,
        &[&[0.0, 0.0], &[0.5, 0.0]],
        &[0.0, 1.0],
        "HLW, section II.1.1",
    )
}

/// Heun's method, the explicit trapezoidal rule: order 2.
pub fn heun() -> Tableau {
    tableau(
        "heun",
        2,
        &[&[0.0, 0.0], &[1.0, 0.0]],
        &[0.5, 0.5],
        "HLW, section II.1.1",
    )
}

/// The classical method of Kutta (1901): order 4.
pub fn rk4() -> Tableau {
    tableau(
        "rk4",
        4,
        &[
            &[0.0, 0.0, 0.0, 0.0],
            &[0.5, 0.0, 0.0, 0.0],
            &[0.0, 0.5, 0.0, 0.0],
            &[0.0, 0.0, 1.0, 0.0],
        ],
        &[1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0],
        "HLW, section II.1.1",
    )
}

/// The implicit midpoint rule, the Gauss method of one stage: order 2, symplectic.
pub fn implicit_midpoint() -> Tableau {
    tableau(
        "implicit-midpoint",
        2,
        &[&[0.5]],
        &[1.0],
        "HLW, section II.1.3",
    )
}

/// The Gauss–Legendre method of two stages: order 4, symplectic.
pub fn gauss4() -> Tableau {
    let shift = 3.0_f64.sqrt() / 6.0;
    tableau(
        "gauss4",
        4,
        &[&[0.25, 0.25 - shift], &[0.25 + shift, 0.25]],
        &[0.5, 0.5],
        "HLW, section II.1.3",
    )
}

/// The Gauss–Legendre method of three stages: order 6, symplectic.
pub fn gauss6() -> Tableau {
    let root = 15.0_f64.sqrt();
    tableau(
        "gauss6",
        6,
        &[
            &[
                5.0 / 36.0,
                2.0 / 9.0 - root / 15.0,
                5.0 / 36.0 - root / 30.0,
            ],
            &[
                5.0 / 36.0 + root / 24.0,
                2.0 / 9.0,
                5.0 / 36.0 - root / 24.0,
            ],
            &[
                5.0 / 36.0 + root / 30.0,
                2.0 / 9.0 + root / 15.0,
                5.0 / 36.0,
            ],
        ],
        &[5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0],
        "HLW, section II.1.3",
    )
}

/// The implicit trapezoidal rule: order 2, not symplectic.
///
/// It is conjugate to the [implicit midpoint rule](implicit_midpoint): half a step of explicit Euler, a
/// step of the midpoint rule, and the half step of Euler undone (HLW, section VI.8). So it
/// conserves a two-form, but one that is h²-near to dp ∧ dq and not that.
pub fn trapezoidal() -> Tableau {
    tableau(
        "trapezoidal",
        2,
        &[&[0.0, 0.0], &[0.5, 0.5]],
        &[0.5, 0.5],
        "HLW, section II.1.1",
    )
}

/// The averaged vector field y_1 = y + h ∫ f(y + ξ (y_1 − y)) dξ with Gauss quadrature of four
/// nodes: order 2, not symplectic.
///
/// The integral makes it a discrete gradient: the energy is conserved. The quadrature, exact up to
/// degree 7, conserves polynomial energies up to degree 8 exactly and others to O(h⁹). As a
/// Runge–Kutta method it has a_ij = c_i b_j.
pub fn averaged_vector_field() -> Tableau {
    let (inner, outer) = {
        let root = 2.0 / 7.0 * (6.0_f64 / 5.0).sqrt();
        ((3.0 / 7.0 - root).sqrt(), (3.0 / 7.0 + root).sqrt())
    };
    let (heavy, light) = {
        let root = 30.0_f64.sqrt();
        ((18.0 + root) / 72.0, (18.0 - root) / 72.0)
    };
    let c = [-outer, -inner, inner, outer].map(|x| 0.5 + 0.5 * x);
    let b = [light, heavy, heavy, light];
    let a = c.map(|c| b.map(|b| c * b));
    tableau(
        "averaged-vector-field",
        2,
        &[&a[0], &a[1], &a[2], &a[3]],
        &b,
        "G. R. W. Quispel & D. I. McLaren, J. Phys. A 41 (2008) 045206",
    )
}

/// Symplectic Euler, kick first, with a wrong sign: positions drift with momenta that were kicked
/// the wrong way. Order 1, not symplectic.
///
/// With the right sign of its one coefficient â_21 = −1 it is momentum-first Lie–Trotter splitting.
/// (A force whose sign is wrong throughout is the force of −V, and that step is symplectic.)
pub fn wrong_sign_euler() -> TableauPair {
    const REFERENCE: &str = "a mistake, for testing";
    pair(
        "wrong-sign-euler",
        tableau(
            "position",
            1,
            &[&[0.0, 0.0], &[0.0, 0.0]],
            &[0.0, 1.0],
            REFERENCE,
        ),
        tableau(
            "momentum",
            1,
            &[&[0.0, 0.0], &[-1.0, 0.0]],
            &[1.0, 0.0],
            REFERENCE,
        ),
    )
}

/// Position-first Strang splitting as a partitioned method, for separable Hamiltonians.
///
/// Barham & Burby print b̂ = (0, 1). Both stages have the same force, so that gives the same
/// map, but only b̂ = (1, 0), as here, meets their condition for being symplectic.
pub fn strang_position_first() -> TableauPair {
    const REFERENCE: &str = "Barham & Burby, appendix D";
    pair(
        "strang-position-first",
        tableau(
            "position",
            2,
            &[&[0.5, 0.0], &[0.5, 0.0]],
            &[0.5, 0.5],
            REFERENCE,
        ),
        tableau(
            "momentum",
            2,
            &[&[0.0, 0.0], &[1.0, 0.0]],
            &[1.0, 0.0],
            REFERENCE,
        ),
    )
}

/// Momentum-first Strang splitting as a partitioned method, for separable Hamiltonians.
pub fn strang_momentum_first() -> TableauPair {
    const REFERENCE: &str = "Barham & Burby, appendix D";
    pair(
        "strang-momentum-first",
        tableau(
            "position",
            2,
            &[&[0.0, 0.0], &[1.0, 0.0]],
            &[1.0, 0.0],
            REFERENCE,
        ),
        tableau(
            "momentum",
            2,
            &[&[0.5, 0.0], &[0.5, 0.0]],
            &[0.5, 0.5],
            REFERENCE,
        ),
    )
}

/// The Lobatto IIIA–IIIB pair of two stages, which is Störmer–Verlet for all Hamiltonians:
/// order 2, symplectic.
///
/// Positions take the trapezoidal rule. On separable Hamiltonians it is explicit and equals
/// [`strang_momentum_first`].
pub fn lobatto3a_3b() -> TableauPair {
    const REFERENCE: &str = "HLW, section II.2.1";
    pair(
        "lobatto3a-3b",
        tableau(
            "position",
            2,
            &[&[0.0, 0.0], &[0.5, 0.5]],
            &[0.5, 0.5],
            REFERENCE,
        ),
        tableau(
            "momentum",
            2,
            &[&[0.5, 0.0], &[0.5, 0.0]],
            &[0.5, 0.5],
            REFERENCE,
        ),
    )
}

/// Every single tableau above, to run tests over.
#[cfg(test)]
pub(super) fn all() -> Vec<Tableau> {
    let pairs = [
        wrong_sign_euler(),
        strang_position_first(),
        strang_momentum_first(),
        lobatto3a_3b(),
    ];
    let halves = pairs
        .iter()
        .flat_map(|p| [p.position().clone(), p.momentum().clone()]);
    [
        euler(),
        midpoint(),
        heun(),
        rk4(),
        rk45(),
        dop853(),
        implicit_midpoint(),
        gauss4(),
        gauss6(),
        trapezoidal(),
        averaged_vector_field(),
    ]
    .into_iter()
    .chain(halves)
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Σ b, Σ b c, Σ b c², Σ b a c, … against the order conditions (HLW, section III.1.1).
    #[test]
    fn order_conditions_hold_up_to_the_stated_order() {
        for tableau in [
            euler(),
            midpoint(),
            heun(),
            rk4(),
            rk45(),
            dop853(),
            implicit_midpoint(),
            gauss4(),
            gauss6(),
            trapezoidal(),
            averaged_vector_field(),
        ] {
            let s = tableau.stages();
            let c: Vec<f64> = (0..s).map(|i| tableau.c(i)).collect();
            let b =
                |f: &dyn Fn(usize) -> f64| -> f64 { (0..s).map(|i| tableau.b()[i] * f(i)).sum() };
            let a = |i: usize, f: &dyn Fn(usize) -> f64| -> f64 {
                (0..s).map(|j| tableau.a(i, j) * f(j)).sum()
            };
            let conditions = [
                (1, b(&|_| 1.0), 1.0),
                (2, b(&|i| c[i]), 1.0 / 2.0),
                (3, b(&|i| c[i].powi(2)), 1.0 / 3.0),
                (3, b(&|i| a(i, &|j| c[j])), 1.0 / 6.0),
                (4, b(&|i| c[i].powi(3)), 1.0 / 4.0),
                (4, b(&|i| c[i] * a(i, &|j| c[j])), 1.0 / 8.0),
                (4, b(&|i| a(i, &|j| c[j].powi(2))), 1.0 / 12.0),
                (4, b(&|i| a(i, &|j| a(j, &|k| c[k]))), 1.0 / 24.0),
            ];
            for (order, sum, expected) in conditions {
                if order <= tableau.order() {
                    assert!(
                        (sum - expected).abs() < 1e-15 * tableau.largest(),
                        "{}, order {order}: {sum} for {expected}",
                        tableau.name()
                    );
                }
            }
            // Quadrature: the conditions of one tree of every order.
            for power in 1..=tableau.order() {
                let sum = b(&|i| c[i].powi(power as i32 - 1));
                let expected = 1.0 / f64::from(power);
                assert!(
                    (sum - expected).abs() < 1e-15 * tableau.largest(),
                    "{}, c^{}: {sum} for {expected}",
                    tableau.name(),
                    power - 1
                );
            }
            let next = tableau.order() + 1;
            assert!(
                next > 4
                    || conditions
                        .iter()
                        .any(|(o, sum, e)| *o == next && (sum - e).abs() > 1e-3),
                "{} is of higher order than stated",
                tableau.name()
            );
        }
    }
}

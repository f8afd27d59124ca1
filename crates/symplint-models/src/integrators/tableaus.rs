//! The Runge–Kutta methods provided.
//!
//! Explicit ones can be stepped by [`RungeKutta`](super::RungeKutta); implicit ones are here for
//! what their tableaus tell. HLW is E. Hairer, C. Lubich & G. Wanner, Geometric Numerical
//! Integration, 2nd edition.

use super::tableau::{Tableau, TableauPair};

/// A tableau whose shape is known to be good.
fn tableau(name: &str, order: u32, a: &[&[f64]], b: &[f64], reference: &str) -> Tableau {
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
        implicit_midpoint(),
        gauss4(),
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
            implicit_midpoint(),
            gauss4(),
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
                        (sum - expected).abs() < 1e-15,
                        "{}, order {order}: {sum} for {expected}",
                        tableau.name()
                    );
                }
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

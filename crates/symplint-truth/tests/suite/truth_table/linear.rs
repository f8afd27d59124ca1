//! Linear systems, whose steps are matrices.

use std::sync::Arc;

use symplint_models::Model;
use symplint_models::systems::{AbsoluteValue, Chain, Ends, FputBond, HarmonicOscillator, TwoCell};

use crate::truth_table::case::{
    Case, NOT_SYMPLECTIC, SYMPLECTIC, circle, of_order, of_order_at_least, phased, symplectic_to,
};

pub fn cases() -> Vec<Case> {
    let mut cases = oscillators();
    cases.extend(constant_forces());
    cases.extend(pieces());
    cases
}

fn oscillators() -> Vec<Case> {
    let two: Model = Arc::new(HarmonicOscillator::new(vec![1.0, 0.5]).unwrap()).into();
    let on = || circle(&[0.0; 2], &[0.0; 2], 1.0);
    let mut cases: Vec<Case> = [
        ("euler", of_order(2.0), "det = 1 + h²ω²"),
        ("rk2 midpoint", of_order(4.0), "det = 1 + h⁴ω⁴/4"),
        ("rk2 heun", of_order(4.0), "det = 1 + h⁴ω⁴/4"),
        ("rk4", of_order(6.0), "det = 1 − h⁶ω⁶/72 + …"),
        (
            "rk45",
            of_order(6.0),
            "|R(iy)|² differs from 1 at y⁶: its coefficient there is 1/600, not 1/720",
        ),
        (
            "dop853",
            of_order_at_least(9.0),
            "|R(iy)|² differs from 1 beyond y⁸",
        ),
        (
            "trapezoidal",
            SYMPLECTIC,
            "on a linear system it is the midpoint rule, the Cayley transform",
        ),
        (
            "averaged-vector-field",
            SYMPLECTIC,
            "the average of a linear field is its value at the midpoint",
        ),
        (
            "discrete-gradient",
            SYMPLECTIC,
            "for a quadratic H its correction vanishes, and it is the midpoint rule",
        ),
        ("implicit-midpoint", SYMPLECTIC, "the Cayley transform"),
        ("wrong-sign-euler", of_order(2.0), "det = 1 + 2h²ω²"),
        (
            "adaptive-strang",
            of_order(1.0),
            "h/√(1 + ω⁴q²) is a step that depends on q",
        ),
        ("yoshida8", symplectic_to(12.0), "a product of shears"),
    ]
    .into_iter()
    .map(|(step, truth, because)| {
        Case::built("two oscillators", &two, step, on(), truth, because).steps(0, -8)
    })
    .collect();
    let root: Model = Arc::new(HarmonicOscillator::new(vec![1.0, 2f64.sqrt()]).unwrap()).into();
    cases.push(
        Case::built(
            "two oscillators, unstable",
            &root,
            "strang",
            on(),
            symplectic_to(11.0),
            "ωh > 2 blows up: a product of shears all the same",
        )
        .steps(2, -6),
    );
    let chain: Model =
        Arc::new(Chain::new(FputBond::new(0.0, 0.0).unwrap(), 6, Ends::Fixed).unwrap()).into();
    for (step, truth, because) in [
        ("strang", SYMPLECTIC, "a product of shears"),
        (
            "rk2 midpoint",
            of_order(4.0),
            "|R(iy)|² = 1 + y⁴/4 in every mode",
        ),
        ("rk4", of_order(6.0), "|R(iy)|² = 1 − y⁶/72 in every mode"),
        ("trapezoidal", SYMPLECTIC, "the Cayley transform"),
    ] {
        let on = phased(&[0.0; 6], &[0.0; 6], 1.0);
        cases.push(Case::built("springs", &chain, step, on, truth, because).steps(-1, -7));
    }
    cases
}

fn constant_forces() -> Vec<Case> {
    let wedge: Model = Arc::new(AbsoluteValue::new(0.0).unwrap()).into();
    [
        ("euler", "a constant force: q += hp, p −= h is a shear"),
        ("rk2 midpoint", "exact in a constant force"),
        ("rk4", "exact in a constant force"),
        ("dop853", "exact in a constant force"),
        ("strang position-first", "the force is constant on the loop"),
        ("strang momentum-first", "the force is constant on the loop"),
        (
            "lie-trotter position-first",
            "the force is constant on the loop",
        ),
        (
            "lie-trotter momentum-first",
            "the force is constant on the loop",
        ),
        (
            "adaptive-strang",
            "|force| is constant, and so is the step size",
        ),
        ("trapezoidal", "exact in a constant force"),
    ]
    .into_iter()
    .map(|(step, because)| {
        let beside = circle(&[9.0], &[0.0], 1.0);
        Case::built("|q|, beside", &wedge, step, beside, SYMPLECTIC, because)
    })
    .collect()
}

fn pieces() -> Vec<Case> {
    let cells: Model = Arc::new(TwoCell::new(4.0).unwrap()).into();
    let inside = || circle(&[2.0], &[0.0], 1.0);
    vec![
        Case::built(
            "two cells, inside one",
            &cells,
            "strang",
            inside(),
            SYMPLECTIC,
            "the force is linear within a cell",
        ),
        Case::built(
            "two cells, inside one",
            &cells,
            "rk2 midpoint",
            inside(),
            of_order(4.0),
            "the force is linear within a cell: det = 1 + h⁴V''²/4",
        ),
        Case::built(
            "two cells, inside one",
            &cells,
            "rk4",
            inside(),
            NOT_SYMPLECTIC,
            "the force is linear within a cell: det = 1 − h⁶V''³/72, at most 1e-8",
        ),
        Case::built(
            "two cells, inside one",
            &cells,
            "trapezoidal",
            inside(),
            SYMPLECTIC,
            "the force is linear within a cell: the Cayley transform",
        ),
    ]
}

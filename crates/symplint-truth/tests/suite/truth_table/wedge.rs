//! H = p²/2 + |q|, sharp and rounded.

use std::sync::Arc;

use symplint_models::Model;
use symplint_models::integrators::catalogue::build;
use symplint_models::maps::DampedMap;
use symplint_models::systems::{AbsoluteValue, TwoCell};

use crate::truth_table::case::{
    BROKEN, BROKEN_AND_CHANGED, BROKEN_AND_CLOSED, Case, NOT_SYMPLECTIC, circle, fourier, of_order,
    symplectic_to,
};

const TORN: &str = "the force jumps at q = 0; a break is born in a kick, as a segment along p that \
                    carries no p dq, and what follows is symplectic";
const TORN_AND_MORE: &str = "the force jumps at q = 0, and the method is not symplectic either";

pub fn cases() -> Vec<Case> {
    let model: Model = Arc::new(AbsoluteValue::new(0.0).unwrap()).into();
    let mut cases = Vec::new();
    for on in [
        circle(&[0.0], &[0.0], 1.0),
        circle(&[0.3], &[0.5], 1.0),
        fourier(&[0.1], &[0.2], 1.0, 7),
    ] {
        for step in [
            "lie-trotter position-first",
            "lie-trotter momentum-first",
            "strang position-first",
            "strang momentum-first",
            "yoshida4 position-first",
            "mclachlan4 momentum-first",
        ] {
            let on = on.clone();
            cases.push(Case::built("|q|", &model, step, on, BROKEN_AND_CLOSED, TORN).steps(-1, -6));
        }
        for (step, truth) in [
            ("euler", BROKEN),
            ("rk2 midpoint", BROKEN),
            ("rk2 heun", BROKEN),
            ("rk4", BROKEN),
            ("adaptive-strang", BROKEN),
        ] {
            let on = on.clone();
            cases.push(Case::built("|q|", &model, step, on, truth, TORN_AND_MORE).steps(-1, -6));
        }
        let strang = build("strang", None, model.clone()).unwrap();
        let damped = DampedMap::new(strang, 0.1).unwrap();
        let (step, truth) = ("strang, damped", BROKEN_AND_CHANGED);
        cases.push(Case::new("|q|", step, damped, on, truth, TORN_AND_MORE).steps(-1, -6));
    }
    let cells: Model = Arc::new(TwoCell::new(4.0).unwrap()).into();
    let because = "a degree-1 force jumps at cell boundaries, and one lies on the loop";
    for (step, truth) in [
        ("strang position-first", BROKEN_AND_CLOSED),
        ("strang momentum-first", BROKEN_AND_CLOSED),
        ("rk2 midpoint", BROKEN),
    ] {
        let on = circle(&[0.0], &[0.0], 1.0);
        cases.push(Case::built("two cells", &cells, step, on, truth, because).steps(-1, -6));
    }
    let beyond = circle(&[12.0], &[0.3], 1.0);
    let because = "a degree-1 force jumps where the box ends, too";
    cases.push(
        Case::built(
            "two cells",
            &cells,
            "strang",
            beyond,
            BROKEN_AND_CLOSED,
            because,
        )
        .steps(-1, -6),
    );
    cases
}

/// √(q² + ε²): steep, not broken.
pub fn rounded() -> Vec<Case> {
    let because = "√(q² + ε²) is analytic for every ε > 0: steep, not broken";
    let model = |epsilon: f64| -> Model { Arc::new(AbsoluteValue::new(epsilon).unwrap()).into() };
    let on = || circle(&[0.0], &[0.0], 1.0);
    let mut cases: Vec<Case> = [
        (1.0, 13.0),
        (1e-1, 13.0),
        (1e-2, 9.0),
        (1e-3, 9.0),
        (1e-4, 9.0),
        (1e-6, 8.0),
    ]
    .into_iter()
    .map(|(epsilon, digits)| {
        let name = format!("√(q² + ε²), ε = {epsilon:e}");
        let truth = symplectic_to(digits);
        Case::built(name, &model(epsilon), "strang", on(), truth, because)
    })
    .collect();
    for (epsilon, truth, because) in [
        (
            1.0,
            of_order(3.0),
            "order 2, and its h³ term is no Hamiltonian's",
        ),
        (
            0.1,
            of_order(3.0),
            "order 2, and its h³ term is no Hamiltonian's",
        ),
        (
            1e-2,
            NOT_SYMPLECTIC,
            "not symplectic; steps longer than ε/p have terms of all orders",
        ),
        (
            1e-4,
            NOT_SYMPLECTIC,
            "not symplectic; steps longer than ε/p have terms of all orders",
        ),
    ] {
        let name = format!("√(q² + ε²), ε = {epsilon:e}");
        cases.push(Case::built(
            name,
            &model(epsilon),
            "rk2 midpoint",
            on(),
            truth,
            because,
        ));
    }
    cases
}

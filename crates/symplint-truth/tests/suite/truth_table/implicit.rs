//! Implicit methods whose stages are solved, or not.

use std::sync::Arc;

use symplint_models::integrators::catalogue::CATALOGUE;
use symplint_models::integrators::{
    ImplicitRungeKutta, RungeKutta, Solver, StageSolver, Stop, tableaus,
};
use symplint_models::maps::Compose;
use symplint_models::systems::{DoublePendulum, HenonHeiles, Pendulum};
use symplint_models::{Hamiltonian, Model};

use symplint::TimeAdvance;

use crate::truth_table::case::{
    BROKEN, Case, NOT_SYMPLECTIC, Named, SYMPLECTIC, Truth, circle, of_order, symplectic_to,
};

fn pendulum() -> Model {
    Arc::new(Pendulum::default()).into()
}

fn off_centre() -> Named {
    circle(&[2.0], &[0.5], 1.0)
}

fn to(tolerance: f64) -> Stop {
    Stop::Converged {
        tolerance,
        max_iterations: 200,
    }
}

fn case(
    system: &str,
    model: &Model,
    name: &str,
    (solver, stop): (Solver, Stop),
    on: Named,
    truth: Truth,
    because: &'static str,
) -> Case {
    let map = CATALOGUE
        .build(StageSolver { solver, stop }, name, None, model.clone())
        .unwrap();
    let how = match stop {
        Stop::Converged { tolerance, .. } => format!("{name} to {tolerance:e}, {solver:?}"),
        Stop::Iterations(count) => format!("{name}, {count} iterations, {solver:?}"),
    };
    Case::new(system, how, map, on, truth, because)
}

pub fn cases() -> Vec<Case> {
    let mut cases = iterations();
    cases.extend(tolerances());
    cases.extend(solved());
    cases.extend(halves());
    cases
}

fn iterations() -> Vec<Case> {
    let because = "k iterations leave the k-th power of h too much: each adds an order, and one is \
                   the explicit midpoint rule";
    let mut cases: Vec<Case> = (1..=4)
        .map(|count| {
            let how = (Solver::FixedPoint, Stop::Iterations(count));
            let truth = of_order(count as f64 + 2.0);
            case(
                "pendulum",
                &pendulum(),
                "implicit-midpoint",
                how,
                off_centre(),
                truth,
                because,
            )
        })
        .collect();
    let how = (Solver::FixedPoint, Stop::Iterations(3));
    let general: Arc<dyn Hamiltonian> = Arc::new(DoublePendulum::default());
    let on = circle(&[1.0, -0.4], &[0.5, 0.2], 0.5);
    cases.push(
        case(
            "double pendulum",
            &Model::General(general),
            "gauss4",
            how,
            on,
            NOT_SYMPLECTIC,
            "three iterations do not solve the stages",
        )
        .steps(-2, -8),
    );
    cases
}

/// Each state stops at its own iteration.
fn tolerances() -> Vec<Case> {
    let because = "each state stops at an iteration of its own: neighbours come out the tolerance \
                   apart where that number changes";
    let mut cases: Vec<Case> = [1e-2, 1e-4, 1e-6, 1e-8, 1e-10]
        .into_iter()
        .map(|tolerance| {
            let how = (Solver::FixedPoint, to(tolerance));
            case(
                "pendulum",
                &pendulum(),
                "implicit-midpoint",
                how,
                off_centre(),
                BROKEN,
                because,
            )
        })
        .collect();
    // The last of them.
    cases[4].undecided =
        Some("jumps of 1e-11 of the loop are no more than the rounding of a map can be");
    let heiles: Model = Arc::new(HenonHeiles).into();
    let on = circle(&[0.0, 0.1], &[0.2, 0.1], 0.3);
    let how = (Solver::FixedPoint, to(1e-6));
    cases.push(case(
        "Hénon–Heiles",
        &heiles,
        "gauss4",
        how,
        on,
        BROKEN,
        because,
    ));
    cases
}

fn solved() -> Vec<Case> {
    let because = "a Gauss method, solved to round-off";
    let general: Arc<dyn Hamiltonian> = Arc::new(DoublePendulum::default());
    let general = Model::General(general);
    let two = || circle(&[1.0, -0.4], &[0.5, 0.2], 0.5);
    let newton = (Solver::Newton, to(StageSolver::ROUNDOFF));
    vec![
        case(
            "pendulum",
            &pendulum(),
            "gauss6",
            newton,
            off_centre(),
            SYMPLECTIC,
            because,
        ),
        case(
            "pendulum",
            &pendulum(),
            "trapezoidal",
            newton,
            off_centre(),
            of_order(3.0),
            "conjugate to the midpoint rule by half an Euler step: h³, however well it is solved",
        ),
        case(
            "double pendulum",
            &general,
            "implicit-midpoint",
            newton,
            two(),
            SYMPLECTIC,
            because,
        )
        .steps(-1, -6),
        case(
            "double pendulum",
            &general,
            "gauss4",
            newton,
            two(),
            symplectic_to(12.0),
            "a Gauss method, solved to round-off, at larger steps than fixed points allow",
        )
        .steps(0, -6),
        case(
            "pendulum",
            &pendulum(),
            "gauss4",
            (Solver::Newton, Stop::Iterations(12)),
            off_centre(),
            SYMPLECTIC,
            "twelve iterations of Newton's method are solved to round-off",
        ),
    ]
}

/// Steps made of two halves, explicit and implicit Euler.
fn halves() -> Vec<Case> {
    let explicit = || -> Box<dyn TimeAdvance> {
        Box::new(RungeKutta::new(tableaus::euler(), HenonHeiles).unwrap())
    };
    let implicit = || -> Box<dyn TimeAdvance> {
        let solver = StageSolver::default();
        let tableau = tableaus::euler().adjoint();
        Box::new(ImplicitRungeKutta::new(tableau, HenonHeiles, solver).unwrap())
    };
    let on = || circle(&[0.0, 0.1], &[0.2, 0.1], 0.3);
    let half = |first: Box<dyn TimeAdvance>, second| {
        Compose::new(vec![(0.5, first), (0.5, second)]).unwrap()
    };
    vec![
        Case::new(
            "Hénon–Heiles",
            "implicit Euler",
            implicit(),
            on(),
            of_order(2.0),
            "det = 1 − h²V'' in one plane, the adjoint of explicit Euler",
        ),
        Case::new(
            "Hénon–Heiles",
            "implicit, then explicit Euler",
            half(implicit(), explicit()),
            on(),
            SYMPLECTIC,
            "the implicit midpoint rule",
        ),
        Case::new(
            "Hénon–Heiles",
            "explicit, then implicit Euler",
            half(explicit(), implicit()),
            on(),
            of_order(3.0),
            "the trapezoidal rule",
        ),
    ]
}

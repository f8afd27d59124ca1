//! Systems in several degrees of freedom, separable or not.

use std::sync::Arc;

use symplint_models::integrators::catalogue::CATALOGUE;
use symplint_models::systems::{
    Chain, ChargedParticle, DoublePendulum, Ends, FputBond, HenonHeiles, Kepler, PendulumArray,
    RotationalForce, TodaBond,
};
use symplint_models::{DriftKick, Hamiltonian, Model};

use crate::truth_table::case::{
    Case, Named, Order, SYMPLECTIC, Truth, circle, circle_on, known, not_symplectic, of_order,
    of_order_at_least, phased, symplectic_to,
};

const FLOWS: &str = "a composition of exact flows of T and V";
const GAUSS: &str = "a Gauss method, solved to round-off";

pub fn cases() -> Vec<Case> {
    let mut cases = planets();
    cases.extend(planes());
    cases.extend(chains());
    cases.extend(double_pendulum());
    cases.extend(charges());
    cases.extend(forces());
    cases
}

/// The known properties of an integrator on any smooth system.
fn usual(dof: usize, step: &str) -> (Truth, &'static str) {
    let known = known(dof).into_iter();
    let found = known.map(|(name, truth, why)| (name == step, truth, why));
    let (_, truth, why) = found.into_iter().find(|(same, ..)| *same).unwrap();
    (truth, why)
}

fn some(system: &str, model: &Model, on: &Named, steps: &[&str]) -> Vec<Case> {
    let case = |step: &&str| {
        let (truth, because) = usual(model.dof(), step);
        Case::built(system, model, step, on.clone(), truth, because)
    };
    steps.iter().map(case).collect()
}

fn planets() -> Vec<Case> {
    let kepler: Model = Arc::new(Kepler::new(1.0, 0.0).unwrap()).into();
    let on = circle(&[3.0, 0.0], &[0.0, 0.6], 1.0);
    let mut cases: Vec<Case> = some(
        "Kepler",
        &kepler,
        &on,
        &[
            "strang position-first",
            "yoshida6 momentum-first",
            "gauss6",
            "rk2 midpoint",
            "rk2 heun",
            "trapezoidal",
            "adaptive-strang position-first",
        ],
    );
    for (step, truth, because) in [
        (
            "rk4",
            of_order(6.0),
            "order 4; the h⁵ term vanishes here, as 40 digits show on two loops",
        ),
        (
            "rk45",
            of_order_at_least(5.7),
            "order 5, not symplectic: h⁶",
        ),
        ("dop853", of_order_at_least(9.0), "order 8, not symplectic"),
    ] {
        let case = Case::built("Kepler", &kepler, step, on.clone(), truth, because);
        cases.push(if step == "dop853" {
            case.steps(1, -5)
        } else {
            case
        });
    }
    cases.push(
        Case::built(
            "Kepler",
            &kepler,
            "dop853",
            on,
            of_order_at_least(9.0),
            "order 8, not symplectic",
        )
        .steps(-1, -8)
        .undecided("a defect of 5e-12 at one step only could be noise of the map"),
    );
    let soft: Model = Arc::new(Kepler::new(1.0, 0.1).unwrap()).into();
    let on = circle(&[0.5, 0.0], &[0.0, 0.2], 0.2);
    cases.extend(some(
        "Kepler, softened",
        &soft,
        &on,
        &["strang momentum-first", "euler"],
    ));
    cases
}

/// Hénon–Heiles and an array with loops in one plane of several.
fn planes() -> Vec<Case> {
    let heiles: Model = Arc::new(HenonHeiles).into();
    let steps = ["mclachlan4 position-first", "rk2 midpoint", "rk4", "gauss4"];
    let mut cases = Vec::new();
    for plane in [0, 1] {
        let on = circle_on(&[plane], &[0.0, 0.1], &[0.2, 0.1], 0.3);
        cases.extend(some("Hénon–Heiles", &heiles, &on, &steps));
    }
    let array = PendulumArray::new(16, 1.0, 0.5).unwrap();
    let (q, p) = array.uniform_state(1);
    let array: Model = Arc::new(array).into();
    let on = circle_on(&[3, 9], &q, &p, 1.0);
    cases.extend(some(
        "array of 16",
        &array,
        &on,
        &["strang position-first", "rk2 heun", "euler"],
    ));
    let pendula = PendulumArray::new(100, 1.0, 1.0).unwrap();
    let (q, p) = pendula.uniform_state(2);
    let pendula: Model = Arc::new(pendula).into();
    let on = phased(&q, &p, 1.0);
    let all = some(
        "array of 100",
        &pendula,
        &on,
        &["strang momentum-first", "rk2 midpoint"],
    );
    cases.extend(all.into_iter().map(|case| case.steps(-1, -6)));
    cases
}

fn chains() -> Vec<Case> {
    let fput: Model =
        Arc::new(Chain::new(FputBond::new(0.25, 0.0).unwrap(), 8, Ends::Fixed).unwrap()).into();
    let on = phased(&[0.1; 8], &[0.0; 8], 0.5);
    let mut cases = some(
        "FPUT α = 0.25",
        &fput,
        &on,
        &[
            "strang position-first",
            "rk2 midpoint",
            "rk4",
            "trapezoidal",
        ],
    );
    let beta: Model =
        Arc::new(Chain::new(FputBond::new(0.0, 1.0).unwrap(), 8, Ends::Periodic).unwrap()).into();
    let on = phased(&[0.1; 8], &[0.2; 8], 0.5);
    cases.extend(some(
        "FPUT β = 1, ring",
        &beta,
        &on,
        &["yoshida4 position-first", "rk2 heun"],
    ));
    let toda: Model = Arc::new(Chain::new(TodaBond, 8, Ends::Periodic).unwrap()).into();
    let on = phased(&[0.0; 8], &[0.1; 8], 0.5);
    cases.extend(some(
        "Toda",
        &toda,
        &on,
        &[
            "strang position-first",
            "gauss4",
            "averaged-vector-field",
            "rk4",
            "euler",
        ],
    ));
    (cases.into_iter().map(|case| case.steps(-1, -7))).collect()
}

fn double_pendulum() -> Vec<Case> {
    let system: Arc<dyn Hamiltonian> = Arc::new(DoublePendulum::default());
    let model = Model::General(system);
    let on = circle(&[1.0, -0.4], &[0.5, 0.2], 0.5);
    let mut cases: Vec<Case> = ["implicit-midpoint", "gauss4", "gauss6"]
        .into_iter()
        .map(|step| (step, SYMPLECTIC, GAUSS))
        .chain(not_symplectic(
            Truth::Defect(Order::IfAny([3.0, 3.0])),
            Truth::Defect(Order::IfAny([5.0, 6.0])),
        ))
        .map(|(step, truth, why)| {
            let case = Case::built("double pendulum", &model, step, on.clone(), truth, why);
            match step {
                "dop853" => case.steps(0, -5),
                _ => case.steps(-2, -9),
            }
        })
        .collect();
    let one = circle_on(&[1], &[1.0, -0.4], &[0.5, 0.2], 0.5);
    cases.push(
        Case::built("double pendulum", &model, "gauss4", one, SYMPLECTIC, GAUSS).steps(-2, -9),
    );
    cases
}

fn charges() -> Vec<Case> {
    let charge = |field: f64, gradient: f64, omega: f64| {
        Model::Charged(ChargedParticle::new(field, gradient, omega).unwrap())
    };
    let on = || circle(&[0.5, 0.0], &[0.3, 0.4], 0.5);
    let (uniform, graded, bound) = (
        charge(1.0, 0.0, 0.0),
        charge(1.0, 0.5, 0.0),
        charge(1.0, 0.0, 0.8),
    );
    let mut cases = Vec::new();
    for (name, model, step, truth, because) in [
        (
            "uniform B",
            &uniform,
            "boris",
            SYMPLECTIC,
            "it is the implicit midpoint rule there",
        ),
        (
            "uniform B",
            &uniform,
            "trapezoidal",
            SYMPLECTIC,
            "the system is linear: the Cayley transform",
        ),
        (
            "uniform B",
            &uniform,
            "rk2 midpoint",
            of_order(4.0),
            "the system is linear: |R(iy)|² = 1 + y⁴/4",
        ),
        (
            "uniform B",
            &uniform,
            "euler",
            of_order(2.0),
            "|R(iy)|² = 1 + y²",
        ),
        (
            "B = 1 + x/2",
            &graded,
            "boris",
            of_order(3.0),
            "it conserves the volume, not the two-form; symmetric, so h³",
        ),
        (
            "uniform B, spring",
            &bound,
            "boris",
            of_order(3.0),
            "conjugate to a symplectic map, not symplectic itself; symmetric, so h³",
        ),
        (
            "B = 1 + x/2",
            &graded,
            "implicit-midpoint",
            SYMPLECTIC,
            GAUSS,
        ),
        ("B = 1 + x/2", &graded, "gauss4", SYMPLECTIC, GAUSS),
        (
            "B = 1 + x/2",
            &graded,
            "rk4",
            Truth::Defect(Order::IfAny([5.0, 6.0])),
            "order 4, not symplectic",
        ),
        (
            "B = 1 + x/2",
            &graded,
            "rk2 heun",
            of_order(4.0),
            "−h²/4 (dk₁−dk₂)∧(dk₁−dk₂)",
        ),
        (
            "B = 1 + x/2",
            &graded,
            "averaged-vector-field",
            of_order(3.0),
            "conserves H, not the two-form",
        ),
    ] {
        cases.push(Case::built(name, model, step, on(), truth, because).steps(-1, -8));
    }
    cases
}

fn forces() -> Vec<Case> {
    let turning = |strength: f64| {
        let force: Arc<dyn DriftKick> = Arc::new(RotationalForce::new(strength).unwrap());
        Model::Forced(force)
    };
    let (some, none) = (turning(0.1), turning(0.0));
    let out = phased(&[0.0, 0.1], &[0.3, 0.0], 0.2);
    let equal = circle(&[0.0, 0.1], &[0.3, 0.0], 0.2);
    let curl = "a kick of curl 2κ adds 2κh dq₁∧dq₂ to the two-form; volume is conserved";
    let hidden =
        "as both circles cover the same q, dq₁∧dq₂ vanishes on them, but not on random loops";
    let mut cases = Vec::new();
    for info in CATALOGUE.iter().filter(|info| info.is_for(&some)) {
        let name = format!("turning force, {}", info.name);
        let truth = of_order(1.0);
        cases.push(Case::built(name, &some, info.name, out.clone(), truth, curl).steps(0, -6));
    }
    cases.push(
        Case::built(
            "turning force",
            &some,
            "strang",
            equal,
            of_order(1.0),
            hidden,
        )
        .steps(0, -6),
    );
    let weak = turning(1e-6);
    cases.push(
        Case::built(
            "weak turning force",
            &weak,
            "strang",
            out.clone(),
            of_order(1.0),
            curl,
        )
        .steps(0, -6),
    );
    cases.push(Case::built(
        "no turning force",
        &none,
        "strang",
        out.clone(),
        SYMPLECTIC,
        FLOWS,
    ));
    cases.push(
        Case::built(
            "no turning force",
            &none,
            "yoshida6",
            out,
            symplectic_to(12.0),
            FLOWS,
        )
        .steps(0, -6),
    );
    cases
}

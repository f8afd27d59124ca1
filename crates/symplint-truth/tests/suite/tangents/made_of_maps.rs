//! Maps made of maps, given maps, and maps that have no tangent map.

use std::sync::Arc;

use symplint::TimeAdvance;
use symplint::map::Repeat;
use symplint_models::discrete::{HenonMap, StandardMap};
use symplint_models::integrators::catalogue::{CATALOGUE, build};
use symplint_models::integrators::{
    Solver, Splitting, StageSolver, Stop, Variant, splitting_methods,
};
use symplint_models::maps::{Compose, DampedMap, SinglePrecision};
use symplint_models::systems::{HenonHeiles, Pendulum};

use crate::common::{State, distance, stepped};
use crate::rotor::Rotor;
use crate::tangents::{by_differences, direction, form, with_tangent};

fn strang() -> Splitting<HenonHeiles> {
    Splitting::new(
        splitting_methods::strang(Variant::PositionFirst),
        HenonHeiles,
    )
}

fn at() -> State {
    (vec![0.2, -0.3], vec![0.4, 0.1])
}

/// That the form is multiplied by `factor`, and tangents are those of differences.
#[track_caller]
fn check(map: &dyn TimeAdvance, h: f64, at: &State, factor: f64) {
    for seed in 0..4 {
        let (u, v) = (direction(map.dof(), seed), direction(map.dof(), seed + 10));
        let (state, of_u) = with_tangent(map, h, at, &u);
        let of_v = with_tangent(map, h, at, &v).1;
        assert_eq!(state, stepped(map, h, at));
        assert!(distance(&of_u, &by_differences(map, h, at, &u)) < 1e-9);
        let (before, after) = (form(map, &u, &v), form(map, &of_u, &of_v));
        assert!(
            (after - factor * before).abs() < 2e-14,
            "{after} for {factor} × {before}"
        );
    }
}

#[test]
fn damping_shrinks_the_form() {
    let damped = DampedMap::new(strang(), 0.7).unwrap();
    check(&damped, 0.5, &at(), (-0.7_f64 * 0.5).exp());
}

#[test]
fn compositions_follow_the_chain_rule() {
    let (step, h) = (strang(), 0.4);
    let parts: Vec<(f64, Box<dyn TimeAdvance>)> = vec![
        (0.6, Box::new(step.clone())),
        (0.4, Box::new(DampedMap::new(step.clone(), 1.0).unwrap())),
    ];
    let composed = Compose::new(parts).unwrap();
    check(&composed, h, &at(), (-0.4 * h).exp());
    check(&Repeat::new(step.clone(), 5).unwrap(), 0.2, &at(), 1.0);

    let u = direction(2, 0);
    let (middle, along) = with_tangent(&step, 0.6 * h, &at(), &u);
    let damped = DampedMap::new(step, 1.0).unwrap();
    let expected = with_tangent(&damped, 0.4 * h, &middle, &along);
    assert_eq!(with_tangent(&composed, h, &at(), &u), expected);
}

#[test]
fn given_maps() {
    let near = (vec![0.4], vec![0.3]);
    check(&HenonMap::new(1.3, 1.0).unwrap(), 1.0, &near, 1.0);
    check(
        &HenonMap::new(1.3, 0.6).unwrap(),
        0.5,
        &near,
        0.6_f64.sqrt(),
    );
    check(&StandardMap::new(1.5).unwrap(), 1.0, &near, 1.0);
}

#[test]
fn what_has_no_derivative_has_no_tangent_map() {
    assert!(SinglePrecision(strang()).capabilities().tangent.is_none());
    assert!(
        Repeat::new(SinglePrecision(strang()), 3)
            .unwrap()
            .capabilities()
            .tangent
            .is_none()
    );
    // A system that supplies no derivative of its force.
    let rotor = Arc::new(Rotor(Pendulum::default()));
    for name in ["strang", "rk4", "gauss4", "adaptive-strang"] {
        assert!(
            build(name, None, rotor.clone())
                .unwrap()
                .capabilities()
                .tangent
                .is_none(),
            "{name}"
        );
    }
    let part = |map: Box<dyn TimeAdvance>| (0.5, map);
    let mixed = Compose::new(vec![
        part(build("strang", None, rotor).unwrap()),
        part(build("strang", None, Arc::new(Pendulum::default())).unwrap()),
    ]);
    // They differ in their periods, so they do not go together in the first place.
    assert!(mixed.is_err());
}

#[test]
fn stages_that_are_not_solved_to_round_off_leave_no_tangent_map() {
    let to = |tolerance| Stop::Converged {
        tolerance,
        max_iterations: 200,
    };
    for solver in [Solver::FixedPoint, Solver::Newton] {
        let has = |stop| {
            let pendulum = Arc::new(Pendulum::default());
            let map = CATALOGUE.build(StageSolver { solver, stop }, "gauss4", None, pendulum);
            map.unwrap().capabilities().tangent.is_some()
        };
        assert!(has(to(0.0)) && has(to(1e-15)));
        assert!(!has(to(1e-12)) && !has(to(1e-6)) && !has(Stop::Iterations(3)));
    }
}

#[test]
fn newton_and_fixed_point_iteration_give_the_same_tangents() {
    let pendulum = || Arc::new(Pendulum::default());
    for name in [
        "implicit-midpoint",
        "gauss6",
        "trapezoidal",
        "averaged-vector-field",
    ] {
        let solved_by = |solver| {
            let settings = StageSolver {
                solver,
                ..StageSolver::default()
            };
            let map = CATALOGUE.build(settings, name, None, pendulum()).unwrap();
            with_tangent(&map, 0.6, &(vec![0.7], vec![0.9]), &direction(1, 0)).1
        };
        let off = distance(&solved_by(Solver::FixedPoint), &solved_by(Solver::Newton));
        assert!(off < 3e-15, "{name}: {off:e}");
    }
}

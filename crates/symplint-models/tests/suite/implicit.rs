//! Implicit methods: what their stages are solved to, and what follows from it.

use std::sync::Arc;

use crate::common::{State, distance, stepped};
use crate::two_form::two_form_defect;
use symplint::state::{Rows, RowsMut};
use symplint::{Block, Circle, Diagnostic, Ensemble, LoopIntegral, Rule, TimeAdvance, VerdictKind};
use symplint_models::integrators::catalogue::CATALOGUE;
use symplint_models::integrators::{
    ImplicitRungeKutta, RungeKutta, Solver, StageSolver, Stop, Tableau, TableauPair, tableaus,
};
use symplint_models::systems::{
    Chain, DoublePendulum, Ends, HenonHeiles, Kepler, Pendulum, TodaBond,
};
use symplint_models::{Hamiltonian, ModelError};

const SOLVERS: [Solver; 2] = [Solver::FixedPoint, Solver::Newton];

fn solved_to(solver: Solver, tolerance: f64) -> StageSolver {
    StageSolver {
        solver,
        stop: Stop::Converged {
            tolerance,
            max_iterations: StageSolver::MAX_ITERATIONS,
        },
    }
}

fn energy(system: &dyn Hamiltonian, (q, p): &State) -> f64 {
    let (dof, mut out) = (q.len(), [0.0]);
    system.energy(Rows::new(q, dof, 1, 1), Rows::new(p, dof, 1, 1), &mut out);
    out[0]
}

/// |ΔI/I| of a circle after one step.
fn loop_defect(map: &dyn TimeAdvance, circle: &Circle, h: f64) -> f64 {
    let integral = |ensemble: &Ensemble| {
        let integral = LoopIntegral::of(ensemble, &Rule::Pseudospectral);
        integral.unwrap().value
    };
    let mut ensemble = Ensemble::sample(circle, 512).unwrap();
    let before = integral(&ensemble);
    ensemble.advance(map, h).unwrap();
    (integral(&ensemble) / before - 1.0).abs()
}

#[test]
fn the_loop_defect_follows_the_tolerance() {
    let circle = Circle::new(vec![0.0, 0.1], vec![0.3, 0.0], 0.2).unwrap();
    for tableau in [
        tableaus::implicit_midpoint(),
        tableaus::gauss4(),
        tableaus::gauss6(),
    ] {
        let defect = |tolerance: f64| {
            let solver = solved_to(Solver::FixedPoint, tolerance);
            let map = ImplicitRungeKutta::new(tableau.clone(), HenonHeiles, solver).unwrap();
            loop_defect(&map, &circle, 0.5)
        };
        let tolerances: Vec<f64> = (1..=14).map(|k| 10.0_f64.powi(-k)).collect();
        let defects: Vec<f64> = tolerances
            .iter()
            .map(|&tolerance| defect(tolerance))
            .collect();
        let name = tableau.name();
        for (tolerance, defect) in tolerances.iter().zip(&defects) {
            assert!(
                *defect < 3.0 * tolerance + 2e-15,
                "{name}, {tolerance:e}: {defect:e}"
            );
        }
        // Not only below the tolerance but with it: a thousandth for each three powers of ten, give
        // or take an iteration, down to round-off.
        for k in 0..9 {
            let ratio = defects[k] / defects[k + 3];
            assert!(
                (30.0..3e4).contains(&ratio),
                "{name}: {ratio} in {defects:e}",
                defects = defects[k]
            );
        }
    }
}

/// If each sample stops by itself, neighbours differ by the tolerance: the map is not continuous,
/// and the verdict reports this. After a fixed number of iterations it is smooth, and each iteration adds
/// an order to its defect.
#[test]
fn verdicts_on_stages_that_are_not_solved() {
    let circle = Circle::new(vec![0.0, 0.1], vec![0.3, 0.0], 0.2).unwrap();
    let verdict = |stop| {
        let solver = StageSolver {
            stop,
            ..StageSolver::default()
        };
        let tableau = tableaus::implicit_midpoint();
        let map = ImplicitRungeKutta::new(tableau, HenonHeiles, solver).unwrap();
        let diagnosis = Diagnostic::halving(0, -6).run(&map, &circle);
        diagnosis.unwrap().verdict
    };
    let loose = Stop::Converged {
        tolerance: 1e-6,
        max_iterations: 50,
    };
    assert_eq!(verdict(loose).kind, VerdictKind::BrokenLoops);
    for iterations in 1..=4 {
        let verdict = verdict(Stop::Iterations(iterations));
        assert_eq!(verdict.kind, VerdictKind::NotSymplectic);
        assert_eq!(verdict.order, Some(iterations as f64 + 2.0));
    }
}

/// One iteration from the slope at the start is the explicit midpoint rule.
#[test]
fn one_iteration_of_the_midpoint_rule_is_the_explicit_one() {
    let solver = StageSolver {
        stop: Stop::Iterations(1),
        ..StageSolver::default()
    };
    let start = (vec![0.1, -0.2], vec![0.3, 0.2]);
    let tableau = tableaus::implicit_midpoint();
    let once = ImplicitRungeKutta::new(tableau, HenonHeiles, solver).unwrap();
    let explicit = RungeKutta::new(tableaus::midpoint(), HenonHeiles).unwrap();
    assert!(
        distance(
            &stepped(&once, 0.5, &start),
            &stepped(&explicit, 0.5, &start)
        ) < 1e-16
    );
}

#[test]
fn newton_and_fixed_points_agree() {
    let start = (vec![0.4, -0.3], vec![0.2, 0.5]);
    for tableau in [
        tableaus::implicit_midpoint(),
        tableaus::gauss4(),
        tableaus::gauss6(),
        tableaus::trapezoidal(),
        tableaus::averaged_vector_field(),
    ] {
        let step = |solver| {
            let solver = solved_to(solver, 1e-15);
            let system = DoublePendulum::default();
            let map = ImplicitRungeKutta::new(tableau.clone(), system, solver).unwrap();
            stepped(&map, 0.3, &start)
        };
        let [fixed, newton] = SOLVERS.map(step);
        let difference = distance(&fixed, &newton);
        assert!(difference < 3e-15, "{}: {difference:e}", tableau.name());
    }
}

/// With h = 3 a fixed-point iteration of the pendulum does not contract; Newton's method converges,
/// and the step is symplectic.
#[test]
fn newton_takes_steps_that_fixed_points_do_not() {
    let map = |solver| {
        ImplicitRungeKutta::new(
            tableaus::implicit_midpoint(),
            Pendulum::default(),
            solved_to(solver, 1e-14),
        )
        .unwrap()
    };
    let start: State = (vec![0.4], vec![0.9]);
    let newton = map(Solver::Newton);
    assert!(two_form_defect(&newton, 3.0, &start) < 1e-9);

    let (mut q, mut p) = ([0.0, 0.4], [0.0, 0.9]);
    let mut block = Block::new(RowsMut::new(&mut q, 1, 2, 2), RowsMut::new(&mut p, 1, 2, 2));
    let failure = map(Solver::FixedPoint)
        .advance(3.0, &mut block)
        .unwrap_err();
    // The first sample rests on the hilltop, where there is nothing to solve.
    assert_eq!(failure.sample, 1);
    for part in [
        "implicit-midpoint",
        "1000 iterations",
        "smaller step",
        "Newton",
    ] {
        assert!(failure.reason.contains(part), "{failure}");
    }
}

#[test]
fn a_step_towards_a_collision_fails_and_names_the_sample() {
    let kepler = Kepler::new(1.0, 0.0).unwrap();
    let map = ImplicitRungeKutta::new(tableaus::gauss4(), kepler, StageSolver::default()).unwrap();
    let (mut q, mut p) = ([1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]);
    let mut block = Block::new(RowsMut::new(&mut q, 2, 2, 2), RowsMut::new(&mut p, 2, 2, 2));
    assert_eq!(map.advance(0.1, &mut block).unwrap_err().sample, 1);
}

#[test]
fn a_sample_does_not_feel_its_block() {
    let samples = 37;
    let state = |k: usize| -> State {
        let x = k as f64 / 7.0;
        (vec![x.sin(), 2.0 * (1.3 * x).cos()], vec![x.cos(), 0.1 * x])
    };
    for solver in SOLVERS {
        let map = ImplicitRungeKutta::new(
            tableaus::gauss4(),
            DoublePendulum::default(),
            solved_to(solver, 1e-9),
        )
        .unwrap();
        let coordinate = |pick: &dyn Fn(State) -> f64| -> Vec<f64> {
            (0..samples).map(|k| pick(state(k))).collect()
        };
        let mut q = [coordinate(&|s| s.0[0]), coordinate(&|s| s.0[1])].concat();
        let mut p = [coordinate(&|s| s.1[0]), coordinate(&|s| s.1[1])].concat();
        let mut block = Block::new(
            RowsMut::new(&mut q, 2, samples, samples),
            RowsMut::new(&mut p, 2, samples, samples),
        );
        map.advance(0.4, &mut block).unwrap();
        for k in 0..samples {
            let alone = stepped(&map, 0.4, &state(k));
            let together = (vec![q[k], q[samples + k]], vec![p[k], p[samples + k]]);
            assert_eq!(alone, together, "{solver:?}, sample {k}");
        }
    }
}

/// Trapezoidal = χ⁻¹ ∘ midpoint ∘ χ with χ half a step of explicit Euler, whose inverse is half a
/// step of implicit Euler with −h.
#[test]
fn the_trapezoidal_rule_is_conjugate_to_the_midpoint_rule() {
    let system = DoublePendulum::default();
    let implicit = |tableau: Tableau| {
        ImplicitRungeKutta::new(tableau, system, StageSolver::default()).unwrap()
    };
    let euler = RungeKutta::new(tableaus::euler(), system).unwrap();
    let (trapezoidal, midpoint, back) = (
        implicit(tableaus::trapezoidal()),
        implicit(tableaus::implicit_midpoint()),
        implicit(tableaus::euler().adjoint()),
    );
    for k in 0..10 {
        let x = f64::from(k) / 5.0;
        let start = (vec![x, 1.0 - x], vec![0.3 * x, -0.4]);
        let h = 0.2;
        let there = stepped(&midpoint, h, &stepped(&euler, 0.5 * h, &start));
        let conjugate = stepped(&back, -0.5 * h, &there);
        let direct = stepped(&trapezoidal, h, &start);
        let difference = distance(&conjugate, &direct);
        assert!(difference < 2e-15, "{difference:e}");
        // It is not the midpoint rule itself.
        assert!(distance(&direct, &stepped(&midpoint, h, &start)) > 1e-6);
    }
}

/// A trapezoidal step multiplies areas by (1 + h²V''(q)/4) / (1 + h²V''(q')/4).
#[test]
fn the_trapezoidal_rule_changes_areas_as_its_conjugacy_says() {
    let solver = StageSolver::default();
    let map =
        ImplicitRungeKutta::new(tableaus::trapezoidal(), Pendulum::default(), solver).unwrap();
    let start = (vec![0.7], vec![0.9]);
    for h in [0.2, 0.5, 1.0] {
        // V = cos q.
        let factor = |q: f64| 1.0 - 0.25 * h * h * q.cos();
        let expected = factor(0.7) / factor(stepped(&map, h, &start).0[0]);
        let got = crate::two_form::jacobian(&map, h, &start).determinant();
        assert!((got - expected).abs() < 1e-10, "{got} for {expected}");
        assert!((got - 1.0).abs() > 1e-4);
    }
}

#[test]
fn the_averaged_vector_field_conserves_the_energy() {
    let toda = Chain::new(TodaBond, 3, Ends::Periodic).unwrap();
    // Steps at which its quadrature is exact to round-off; for Hénon–Heiles, a cubic, any step.
    let cases: [(Arc<dyn Hamiltonian>, State, f64); 3] = [
        (
            Arc::new(HenonHeiles),
            (vec![0.1, -0.2], vec![0.3, 0.2]),
            0.5,
        ),
        (
            Arc::new(DoublePendulum::default()),
            (vec![0.5, -0.2], vec![0.2, 0.1]),
            0.05,
        ),
        (
            Arc::new(toda),
            (vec![0.4, -0.1, 0.2], vec![0.5, -0.7, 0.3]),
            0.2,
        ),
    ];
    for (system, start, h) in cases {
        let run = |tableau: Tableau| {
            let map = ImplicitRungeKutta::new(tableau, Arc::clone(&system), StageSolver::default());
            let map = map.unwrap();
            let end = (0..200).fold(start.clone(), |state, _| stepped(&map, h, &state));
            (energy(&*system, &end) - energy(&*system, &start)).abs()
        };
        let averaged = run(tableaus::averaged_vector_field());
        assert!(averaged < 1e-12, "{averaged:e}");
        let midpoint = run(tableaus::implicit_midpoint());
        assert!(midpoint > 1e-6, "{midpoint:e}");
    }
}

/// Energy errors of the discrete gradient follow the tolerance, too.
#[test]
fn energy_is_conserved_to_the_tolerance() {
    let start = (vec![0.1, -0.2], vec![0.3, 0.2]);
    for tolerance in [1e-4, 1e-7, 1e-10] {
        let solver = solved_to(Solver::FixedPoint, tolerance);
        let map = ImplicitRungeKutta::new(tableaus::averaged_vector_field(), HenonHeiles, solver)
            .unwrap();
        let error =
            energy(&HenonHeiles, &stepped(&map, 0.5, &start)) - energy(&HenonHeiles, &start);
        assert!(
            (1e-4 * tolerance..tolerance).contains(&error.abs()),
            "{error:e}"
        );
    }
}

#[test]
fn implicit_steps_are_symplectic_where_nothing_separates() {
    let start = (vec![0.8, -0.5], vec![0.6, 0.3]);
    let defect = |method: TableauPair| {
        let system = DoublePendulum::default();
        let map = ImplicitRungeKutta::new(method, system, StageSolver::default()).unwrap();
        two_form_defect(&map, 0.4, &start)
    };
    for method in [
        tableaus::implicit_midpoint().into(),
        tableaus::gauss4().into(),
        tableaus::gauss6().into(),
        tableaus::lobatto3a_3b(),
    ] {
        let name = method.name().to_owned();
        let defect = defect(method);
        assert!(defect < 1e-9, "{name}: {defect:e}");
    }
    // The pair of Strang is symplectic on separable Hamiltonians only.
    for method in [
        tableaus::trapezoidal().into(),
        tableaus::averaged_vector_field().into(),
        tableaus::strang_position_first(),
    ] {
        let name = method.name().to_owned();
        let defect = defect(method);
        assert!(defect > 1e-6, "{name}: {defect:e}");
    }
}

#[test]
fn solvers_without_meaning_are_refused() {
    let refusal = |solver: StageSolver, system: Arc<dyn symplint_models::Separable>| {
        CATALOGUE
            .build(solver, "gauss4", None, system)
            .map(|_| ())
            .unwrap_err()
    };
    let chain = |masses| Arc::new(Chain::new(TodaBond, masses, Ends::Fixed).unwrap());
    for tolerance in [-1.0, f64::NAN, f64::INFINITY] {
        let solver = solved_to(Solver::FixedPoint, tolerance);
        assert!(matches!(
            refusal(solver, chain(2)),
            ModelError::OutOfRange { .. }
        ));
    }
    for stop in [
        Stop::Iterations(0),
        Stop::Converged {
            tolerance: 0.1,
            max_iterations: 0,
        },
    ] {
        let solver = StageSolver {
            stop,
            ..StageSolver::default()
        };
        assert_eq!(refusal(solver, chain(2)), ModelError::NoIterations);
    }
    let error = refusal(solved_to(Solver::Newton, 1e-12), chain(25));
    assert_eq!(
        error,
        ModelError::TooManyUnknowns {
            unknowns: 100,
            limit: StageSolver::MAX_UNKNOWNS
        }
    );
}

//! The advice about a tolerance, and about forces that jump.

use std::f64::consts::PI;

use symplint::verdict::CauseKind;
use symplint::{Circle, Diagnosis, Diagnostic, PerSample, Rule, TimeAdvance, VerdictKind};

use crate::solver_tolerance::midpoint::Pendulum;
use crate::solver_tolerance::{diagnose, truth};

fn is_of_a_solver(found: &Diagnosis) -> bool {
    let cause = found.verdict.cause.as_ref();
    cause.is_some_and(|cause| cause.kind == CauseKind::SolverTolerance)
}

#[test]
fn a_tolerance_that_is_the_likely_cause_is_named_with_the_size_of_the_jumps() {
    let circle = truth::Circle {
        centre: &[0.3, 0.5],
        radius: 1.0,
    };
    for tolerance in [1e-5, 1e-6, 1e-7, 1e-8, 1e-9] {
        let found = diagnose::<Pendulum>(&circle, 0.5, tolerance, Rule::Auto);
        let truth = truth::truth::<Pendulum>(&circle, 0.5, tolerance);
        assert!(is_of_a_solver(&found), "{tolerance:e}: {}", found.verdict);
        let cause = found.verdict.cause.as_ref().unwrap();
        let numbers: Vec<f64> = (cause.text.split(|c: char| !c.is_ascii_digit()))
            .filter_map(|word| word.parse().ok())
            .collect();
        let (flickering, breaks) = (numbers[0], numbers[1]);
        assert!(8.0 * flickering >= breaks && breaks == truth.breaks.len() as f64);
        let (_, remedy) = cause.remedy.split_once("errors of about ").unwrap();
        let (largest, _) = remedy.split_once(',').unwrap();
        let largest: f64 = largest.parse().unwrap();
        let expected = truth.jumps.iter().copied().fold(0.0, f64::max);
        assert!((largest / expected - 1.0).abs() < 0.1, "{largest:e}");
        let said = found.verdict.advice().join(" ");
        assert!(!said.contains("If a force jumps"), "{said}");
    }
}

/// The implicit midpoint rule for a pendulum by chords instead of Newton's method: it stops at a residual.
fn by_chords(tolerance: f64) -> impl TimeAdvance {
    PerSample::new(1, move |h: f64, q: &mut [f64], p: &mut [f64]| {
        let momentum = |middle: f64| p[0] - 0.5 * h * middle.sin();
        let mut middle = q[0];
        loop {
            let residual = middle - q[0] - 0.5 * h * momentum(middle);
            if residual.abs() < tolerance {
                break;
            }
            middle -= residual / (1.0 + 0.25 * h * h);
        }
        p[0] = 2.0 * momentum(middle) - p[0];
        q[0] = 2.0 * middle - q[0];
    })
}

#[test]
fn solvers_that_stop_at_a_residual_are_named_too() {
    for tolerance in [1e-5, 1e-6, 1e-7, 1e-8, 1e-9] {
        let circle = Circle::new(vec![1.0], vec![-0.2], 0.7).unwrap();
        let diagnostic = Diagnostic::halving(-1, -4);
        let found = diagnostic.run(&by_chords(tolerance), &circle).unwrap();
        assert_eq!(found.verdict.kind, VerdictKind::BrokenLoops);
        assert!(is_of_a_solver(&found), "{tolerance:e}: {}", found.verdict);
    }
}

/// A kick by a force that jumps by a little where a particle passes q = `at`.
fn small_wedge(at: f64, jump: f64) -> impl TimeAdvance {
    PerSample::new(1, move |h: f64, q: &mut [f64], p: &mut [f64]| {
        q[0] += 0.5 * h * p[0];
        p[0] -= h * (q[0] - at).sin() + h * jump * (q[0] - at).signum();
        q[0] += 0.5 * h * p[0];
    })
}

#[test]
fn a_force_that_jumps_a_little_is_no_solver() {
    for jump in [1e-5, 1e-7, 1e-9] {
        // Far from the origin the rounding of states is as wide as the tolerance of a solver.
        for at in [0.1, PI, 100.0, 1e4] {
            let circle = Circle::new(vec![at], vec![0.4], 0.7).unwrap();
            let diagnostic = Diagnostic {
                loops: 2,
                ..Diagnostic::halving(-1, -3)
            };
            let found = diagnostic.run(&small_wedge(at, jump), &circle).unwrap();
            let kind = found.verdict.kind;
            assert_eq!(kind, VerdictKind::BrokenLoops, "{jump:e} at {at}");
            assert!(
                !is_of_a_solver(&found),
                "{jump:e} at {at}: {}",
                found.verdict
            );
        }
    }
}

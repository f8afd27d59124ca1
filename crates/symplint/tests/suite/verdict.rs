//! Verdicts on evidence that is written by hand.

use symplint::evidence::Check;
use symplint::map::balanced_radii;
use symplint::verdict::{Finding, MapFinding};
use symplint::{Block, Circle, Diagnostic, Evidence, Loop, PerSample, VerdictKind, judge};

#[test]
fn without_a_loop_nothing_is_decided() {
    let verdict = judge(&Evidence::default());
    assert_eq!(verdict.kind, VerdictKind::Undecided);
    assert!(verdict.fits.is_empty());
    assert!(verdict.summary().contains("No loop"), "{verdict}");
}

/// Its jumps and its defect are the same at every h.
#[test]
fn a_broken_loop_whose_defect_has_no_trend_has_no_order() {
    let map = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        p[0] += 0.1 * (q[0] - 0.2).signum() * (1.0 + q[0]);
        q[0] += h * p[0];
        p[0] *= 0.9;
    });
    let circle = Circle::new(vec![0.1], vec![0.2], 1.0).unwrap();
    let diagnosis = (Diagnostic::halving(-4, -8).run(&map, &circle)).unwrap();
    assert_eq!(diagnosis.verdict.kind, VerdictKind::BrokenLoops);
    assert_eq!(diagnosis.verdict.order, None, "{:?}", diagnosis.fits());
}

/// Explicit Euler steps of slow pendula, whose changes are rounding at the default step sizes, or at the given one.
#[test]
fn steps_that_change_states_by_rounding_alone_are_undecided() {
    let default_sizes = Diagnostic::default().step_sizes;
    let cases = [1e-13, 1e-15, 3e-16, 1e-16].map(|frequency| (frequency, default_sizes.clone()));
    let tiny = [1e-14, 1e-15, 1e-17, 1e-300].map(|h| (1.0, vec![h]));
    for (frequency, step_sizes) in cases.into_iter().chain(tiny) {
        let euler = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
            let force = q[0].sin();
            q[0] += h * frequency * p[0];
            p[0] -= h * frequency * force;
        });
        let circle = Circle::new(vec![1.0], vec![0.5], 1.0).unwrap();
        let diagnostic = Diagnostic {
            budget: Some(20_000),
            step_sizes: step_sizes.clone(),
            ..Diagnostic::default()
        };
        let found = diagnostic.run(&euler, &circle).unwrap().verdict;
        let case = format!("{frequency}, {step_sizes:?}: {found}");
        assert_eq!(found.kind, VerdictKind::Undecided, "{case}");
        assert!(found.advice()[0].contains("larger step"), "{case}");
    }
}

/// A kick of velocities: momenta without a force change by rounding alone.
#[test]
fn a_kick_beside_degrees_of_freedom_that_only_round_is_symplectic() {
    const MASS: f64 = 1.1;
    let kick = PerSample::new(3, |h, q: &mut [f64], p: &mut [f64]| {
        for (p, force) in p.iter_mut().zip([-q[0], 0.0, 0.0]) {
            *p = (*p / MASS + h * force / MASS) * MASS;
        }
    });
    let circle = Circle::new(vec![0.3, 0.2, 0.1], vec![0.1, 0.4, 0.2], 1.0).unwrap();
    let found = Diagnostic::default().run(&kick, &circle).unwrap().verdict;
    assert_eq!(found.kind, VerdictKind::Symplectic, "{found}");
}

/// The Fourier coefficients fall by ten orders in 16 modes, and then stay at the rounding of √(1 + 2δ + …) − 1.
#[test]
fn an_analytic_loop_is_not_rough_where_rounding_inside_the_map_ends_the_fall() {
    const BETA: f64 = 0.9;
    let energy = |p: f64| (1.0 + 2.0 * p + (BETA * p).powi(2)).sqrt() - 1.0;
    let momentum =
        |d: f64| ((((1.0 + d) * BETA).powi(2) + 1.0 - BETA * BETA).sqrt() - 1.0) / (BETA * BETA);
    for k in [11.0, 13.0, 15.0, 17.0, 19.0, 25.0] {
        let cavity = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
            p[0] = momentum(energy(p[0] + 0.16 * h / k * (k * q[0]).sin()));
        });
        let circle = Circle::with_radii(vec![0.0], vec![3e-3], vec![2e-2], vec![8e-3]).unwrap();
        for budget in [20_000, 1_000_000] {
            let diagnostic = Diagnostic {
                budget: Some(budget),
                step_sizes: vec![1.0, 0.5, 0.25],
                ..Diagnostic::default()
            };
            let found = diagnostic.run(&cavity, &circle).unwrap().verdict;
            assert!(!is_rough(&found), "{k}, {budget}: {found}");
        }
    }
}

/// Whether a verdict calls the loop rough.
fn is_rough(found: &symplint::Verdict) -> bool {
    let is_regularity =
        |finding: &Finding| matches!(finding, Finding::Map(MapFinding::Regularity { .. }));
    found.findings.iter().any(is_regularity)
}

#[test]
fn a_loop_with_a_momentum_at_rest_is_not_rough() {
    struct Flat(f64);
    impl Loop for Flat {
        fn dof(&self) -> usize {
            2
        }
        fn sample(&self, s: &[f64], block: &mut Block<'_>) {
            for (k, &s) in s.iter().enumerate() {
                let (sin, cos) = (std::f64::consts::TAU * s).sin_cos();
                block.q.row_mut(0)[k] = sin;
                block.q.row_mut(1)[k] = cos + 0.2 * sin * sin;
                block.p.row_mut(0)[k] = cos;
                block.p.row_mut(1)[k] = self.0;
            }
        }
    }
    let free = PerSample::new(2, |h, q: &mut [f64], p: &mut [f64]| {
        for (q, p) in q.iter_mut().zip(p) {
            *q += h * *p;
        }
    });
    for at_rest in [0.0, 1e-300] {
        let diagnostic = Diagnostic {
            step_sizes: vec![0.5],
            loops: 1,
            jacobian: false,
            ..Diagnostic::default()
        };
        let found = diagnostic.run(&free, &Flat(at_rest)).unwrap().verdict;
        assert!(!is_rough(&found), "{at_rest:e}: {found}");
    }
}

#[test]
fn evaluations_that_choose_radii_are_counted_beside_the_budget() {
    let map = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        p[0] -= h * 1e4 * q[0];
        q[0] += h * p[0];
    });
    let found = balanced_radii(&map, &[0.3], &[0.0], 1e-3).unwrap();
    let circle =
        || Circle::with_radii(vec![0.3], vec![0.0], found.q.clone(), found.p.clone()).unwrap();
    let diagnostic = Diagnostic {
        step_sizes: vec![1e-3, 5e-4, 2.5e-4],
        ..Diagnostic::default()
    };
    for repeat in [1, 3] {
        let diagnostic = Diagnostic {
            repeat,
            ..diagnostic.clone()
        };
        let run = |phase_loop: &dyn Loop| diagnostic.run(&map, phase_loop).unwrap();
        let (plain, counted) = (run(&circle()), run(&found.counted(circle())));
        let (before, after) = (&plain.evidence.evaluations, &counted.evidence.evaluations);
        assert!(found.evaluations > 0);
        assert_eq!(after.made, before.made + found.evaluations);
        assert_eq!(after.budget, before.budget + found.evaluations);
        assert_eq!(after.of(Check::Radii), found.evaluations);
        assert_eq!(plain.verdict.kind, counted.verdict.kind);
    }
}

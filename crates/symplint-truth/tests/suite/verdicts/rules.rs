//! Rules that are chosen by hand.

use std::sync::Arc;

use symplint::diagnosis::SampleCount;
use symplint::rules::{Cutoffs, Piecewise, Streaming};
use symplint::{Diagnostic, PerSample, Rule, VerdictKind};
use symplint_models::Separable;
use symplint_models::integrators::catalogue::build;
use symplint_models::systems::{AbsoluteValue, InterpolatedPendulum, Pendulum};

use crate::verdicts::{circle, diagnose};

#[test]
fn the_wedge_breaks_loops_that_cross_it() {
    let wedge: Arc<dyn Separable> = Arc::new(AbsoluteValue::new(0.0).unwrap());
    for name in ["lie-trotter", "strang"] {
        for variant in ["position-first", "momentum-first"] {
            let map = build(name, Some(variant), Arc::clone(&wedge)).unwrap();
            for rule in [
                Rule::Auto,
                Rule::Pseudospectral,
                Rule::FiniteDifference(Cutoffs::relative(1000.0)),
                Rule::Streaming(Streaming::default()),
            ] {
                let diagnostic = Diagnostic {
                    rule,
                    ..Diagnostic::default()
                };
                let across = diagnose(&diagnostic, &*map, &circle(&[0.0], &[0.0], 1.0));
                assert_eq!(
                    across.verdict.kind,
                    VerdictKind::BrokenLoops,
                    "{name}, {variant}"
                );
                assert!(!across.evidence.breaks.is_empty());
            }
        }
    }
}

#[test]
fn finite_differences_alone_do_not_decide_a_smooth_case() {
    let map = build(
        "strang",
        None,
        Arc::new(Pendulum::default()) as Arc<dyn Separable>,
    )
    .unwrap();
    // λ = 3 leaves out smooth cells, and what is left looks like a large defect.
    for lambda in [3.0, 10.0, 1000.0] {
        let diagnostic = Diagnostic {
            rule: Rule::FiniteDifference(Cutoffs::relative(lambda)),
            samples: SampleCount::Fixed(4096),
            ..Diagnostic::default()
        };
        let verdict = diagnose(&diagnostic, &*map, &circle(&[2.0], &[0.5], 1.0)).verdict;
        assert_eq!(
            verdict.kind,
            VerdictKind::Undecided,
            "λ = {lambda}: {verdict:?}"
        );
    }
}

#[test]
fn cutoffs_on_a_steep_loop_do_not_make_a_verdict() {
    for (epsilon, lambda, p0) in [(1e-6, 10.0, 0.0), (1e-4, 1000.0, 0.5), (1e-3, 30.0, 0.5)] {
        let system: Arc<dyn Separable> = Arc::new(AbsoluteValue::new(epsilon).unwrap());
        let diagnostic = Diagnostic {
            rule: Rule::FiniteDifference(Cutoffs::relative(lambda)),
            ..Diagnostic::default()
        };
        for variant in ["position-first", "momentum-first"] {
            let map = build("strang", Some(variant), Arc::clone(&system)).unwrap();
            let verdict = diagnose(&diagnostic, &*map, &circle(&[0.0], &[p0], 1.0)).verdict;
            assert_eq!(
                verdict.kind,
                VerdictKind::Undecided,
                "ε = {epsilon}, {variant}: {verdict:?}"
            );
        }
    }
}

#[test]
fn pieces_do_not_step_over_what_samples_see() {
    // Bumps of three samples' width and less, far narrower than the first pieces.
    for (width, decided) in [(8e-3, true), (4e-3, false), (1e-3, false), (1e-4, false)] {
        let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
            p[0] += h * ((-((q[0] - 0.31) / width).powi(2)).exp() - q[0]);
        });
        let diagnostic = Diagnostic {
            rule: Rule::Piecewise(Piecewise::default()),
            ..Diagnostic::default()
        };
        let found = diagnose(&diagnostic, &map, &circle(&[0.4], &[0.7], 1.0));
        let kind = found.verdict.kind;
        // Where one bump is met, another may be missed, but not where the first one leads to it.
        let undecided = !decided && kind == VerdictKind::Undecided;
        let well = undecided || kind == VerdictKind::Symplectic;
        assert!(well, "{width}: {:?}", found.verdict);
    }
}

#[test]
fn regularity_follows_the_degree_of_the_splines() {
    // A force from splines of degree n has a jump in its derivative of order n − 1: H^(n − 1/2).
    for degree in 1..=4 {
        let system: Arc<dyn Separable> = Arc::new(InterpolatedPendulum::new(degree, 25).unwrap());
        let map = build("strang", None, system).unwrap();
        let diagnostic = Diagnostic {
            loops: 1,
            ..Diagnostic::halving(-1, -3)
        };
        let found = diagnose(&diagnostic, &*map, &circle(&[3.0], &[0.2], 1.0));
        for point in &found.points() {
            let expected = degree as f64 - 0.5;
            let regularity = point.regularity.expect("thousands of samples");
            assert!(
                (regularity - expected).abs() < 0.3,
                "degree {degree}, h = {}: {regularity}",
                point.step_size
            );
        }
    }
}

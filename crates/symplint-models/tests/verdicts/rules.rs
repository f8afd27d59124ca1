//! Rules that are chosen by hand.

use std::sync::Arc;

use symplint::{Cutoffs, Diagnostic, Rule, RuleChoice, SampleCount, VerdictKind};
use symplint_models::Separable;
use symplint_models::integrators::catalogue::build;
use symplint_models::systems::{AbsoluteValue, Pendulum};

use crate::{circle, diagnose};

#[test]
fn the_wedge_breaks_loops_that_cross_it() {
    let wedge: Arc<dyn Separable> = Arc::new(AbsoluteValue::new(0.0).unwrap());
    for name in ["lie-trotter", "strang"] {
        for variant in ["position-first", "momentum-first"] {
            let map = build(name, Some(variant), Arc::clone(&wedge)).unwrap();
            for rule in [
                RuleChoice::Auto,
                RuleChoice::Fixed(Rule::Pseudospectral),
                RuleChoice::Fixed(Rule::FiniteDifference(Cutoffs::relative(1000.0))),
                RuleChoice::Streaming,
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
                assert!(!across.breaks.is_empty());
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
            rule: RuleChoice::Fixed(Rule::FiniteDifference(Cutoffs::relative(lambda))),
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
            rule: RuleChoice::Fixed(Rule::FiniteDifference(Cutoffs::relative(lambda))),
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

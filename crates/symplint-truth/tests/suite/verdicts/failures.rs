//! Maps that fail, and loops that leave their domain.

use symplint::diagnosis::SampleCount;
use symplint::error::StateLocation;
use symplint::rules::Piecewise;
use symplint::verdict::step_size_text;
use symplint::{
    Block, Diagnostic, Error, PerSample, Phases, Rule, StepFailure, TimeAdvance, VerdictKind,
};

use crate::verdicts::{circle, diagnose};

#[test]
fn states_that_are_not_finite_are_named() {
    let map = PerSample::new(2, |h, q: &mut [f64], _: &mut [f64]| {
        if h < 0.2 && q[1] > 0.95 {
            q[1] = f64::NAN;
        }
        q[0] += h;
    });
    let diagnostic = Diagnostic {
        samples: SampleCount::Fixed(1000),
        ..Diagnostic::halving(-3, -4)
    };
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let phase_loop = circle(&[0.0; 2], &[0.0; 2], 1.0).with_phases(Phases::Equal);
        let error = pool.install(|| diagnostic.run(&map, &phase_loop).unwrap_err());
        // sin 2πk/1000 first exceeds 0.95 at k = 200 (0.9511); at both step sizes, of which the largest is named.
        assert!(
            matches!(
                error,
                Error::NotFinite { coordinate: "q", dof: 1, at: StateLocation::SampleOf { sample: 200, samples: 1000 }, step_size: Some(h), .. } if h == 0.125
            ),
            "{error:?}"
        );
        let text = error.to_string();
        for part in ["q[1] is", "sample 200", "h = 0.125"] {
            assert!(text.contains(part), "{text}");
        }
    }
}

#[test]
fn failures_of_the_map_are_named() {
    struct Stubborn;
    impl TimeAdvance for Stubborn {
        fn dof(&self) -> usize {
            1
        }
        fn advance(&self, _: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
            match block.q.row(0).iter().position(|&q| q < -0.5) {
                None => Ok(()),
                Some(sample) => Err(StepFailure {
                    sample,
                    reason: "Newton's method did not converge in 20 steps".into(),
                }),
            }
        }
    }
    let error = Diagnostic::default()
        .run(&Stubborn, &circle(&[0.0], &[0.0], 1.0))
        .unwrap_err();
    // sin 2πk/2048 < −1/2 first at k = 1195, in the third block.
    assert!(
        matches!(
            error,
            Error::StepFailed {
                at: StateLocation::SampleOf {
                    sample: 1195,
                    samples: 2048
                },
                ..
            }
        ),
        "{error:?}"
    );
    assert!(error.to_string().contains("Newton"));
}

#[test]
fn a_map_that_fails_at_some_step_sizes_is_measured_at_the_others() {
    // Of ten step sizes 2^-1 … 2^-10 the largest, one in the middle, or the smallest.
    for bad in [1, 4, 10].map(|m| 0.5f64.powi(m)) {
        for quiet_nan in [false, true] {
            for (friction, kind) in [
                (0.0, VerdictKind::Symplectic),
                (0.1, VerdictKind::NotSymplectic),
            ] {
                let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
                    if h == bad && q[0] > 0.3 {
                        q[0] = f64::NAN;
                        return if quiet_nan { Ok(()) } else { Err("it hangs") };
                    }
                    p[0] -= h * (q[0].sin() + friction * p[0]);
                    q[0] += h * p[0];
                    Ok(())
                });
                let diagnosis =
                    diagnose(&Diagnostic::default(), &map, &circle(&[0.2], &[0.4], 1.0));
                assert_eq!(diagnosis.verdict.kind, kind, "{:?}", diagnosis.verdict);
                let sizes: Vec<f64> = (diagnosis.evidence.loops[0].steps.iter())
                    .filter_map(|step| step.step_size)
                    .collect();
                assert_eq!((sizes.len(), sizes.contains(&bad)), (9, false));
                let text = diagnosis.verdict.sentences().join(" ");
                let named = format!("The step size h = {} was left out", step_size_text(bad));
                assert!(text.contains(&named), "{text}");
                assert!(text.contains(if quiet_nan { "NaN" } else { "it hangs" }));
                let counted = diagnosis.evidence.evaluations;
                assert!(counted.made <= counted.budget);
            }
        }
    }
}

#[test]
fn overflow_is_an_error_and_no_verdict() {
    let map = PerSample::new(1, |_, q: &mut [f64], p: &mut [f64]| {
        q[0] *= 1e200;
        p[0] *= 1e200;
    });
    let error = Diagnostic::default()
        .run(&map, &circle(&[0.0], &[0.0], 1.0))
        .unwrap_err();
    assert!(matches!(error, Error::Overflow { dof: 0, .. }), "{error:?}");
    let loops = circle(&[0.0], &[0.0], 1e160);
    let map = PerSample::new(1, |_, _: &mut [f64], _: &mut [f64]| {});
    assert!(Diagnostic::default().run(&map, &loops).is_err());
}

#[test]
fn random_loops_may_leave_the_domain_of_the_map() {
    // log is defined on the given loop, just so; the outermost random loops stay inside it.
    let map = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        p[0] -= h * (q[0] + 1.2).ln();
        q[0] += h * p[0];
    });
    for seed in 1..12 {
        let diagnostic = Diagnostic {
            seed,
            ..Diagnostic::default()
        };
        let verdict = diagnose(&diagnostic, &map, &circle(&[0.0], &[0.0], 1.0)).verdict;
        assert_eq!(
            verdict.kind,
            VerdictKind::Symplectic,
            "seed {seed}: {verdict:?}"
        );
    }
    // On a circle that is flat in q but for one degree of freedom, others are moved as far.
    let two = PerSample::new(2, |h, q: &mut [f64], p: &mut [f64]| {
        p[0] -= h * q[0].sin();
        q[0] += h * p[0];
        p[1] -= 0.2 * h * p[1];
        q[1] += h * p[1];
    });
    let flat = circle(&[0.0; 2], &[0.3; 2], 1.0).on(&[0]).unwrap();
    let verdict = diagnose(&Diagnostic::default(), &two, &flat).verdict;
    assert_eq!(verdict.kind, VerdictKind::NotSymplectic, "{verdict:?}");
}

#[test]
fn steps_of_any_size_do_not_panic() {
    type Step = fn(f64, &mut [f64], &mut [f64]);
    let steps: [Step; 4] = [
        |h, q, p| {
            p[0] -= h / q[0];
            q[0] += h * p[0];
        },
        |h, q, p| {
            p[0] -= h * q[0].signum();
            q[0] += h * p[0];
        },
        |h, q, p| {
            p[0] -= h * q[0].powi(3);
            q[0] += 1e-300 * h * p[0];
        },
        |h, q, _| q[0] = h * q[0].tan(),
    ];
    for step in steps {
        let map = PerSample::new(1, step);
        for exponent in [-300, -200, -20, 5, 100, 153, 155, 200, 300] {
            for radius in [1e-12, 1.0, 1e100] {
                for rule in [Rule::Auto, Rule::Piecewise(Piecewise::default())] {
                    let diagnostic = Diagnostic {
                        rule,
                        budget: Some(3_000),
                        step_sizes: vec![10f64.powi(exponent)],
                        ..Diagnostic::default()
                    };
                    let on = circle(&[0.4], &[0.7], radius);
                    let _ = diagnostic.run(&map, &on);
                }
            }
        }
    }
}

//! Steps and samples that are not evidence.

use std::sync::Arc;

use symplint::{Diagnostic, PerSample, VerdictKind};
use symplint_models::Separable;
use symplint_models::integrators::catalogue::build;
use symplint_models::systems::{HarmonicOscillator, Pendulum};

use crate::verdicts::{circle, diagnose, verdict_of};

#[test]
fn a_step_that_moves_nothing_proves_nothing() {
    assert_eq!(verdict_of(|_, _, _| {}).0, VerdictKind::Undecided);
    let map = build(
        "rk4",
        None,
        Arc::new(Pendulum::default()) as Arc<dyn Separable>,
    )
    .unwrap();
    let tiny = Diagnostic::halving(-12, -16);
    let verdict = diagnose(&tiny, &*map, &circle(&[2.0], &[0.5], 1.0)).verdict;
    assert_eq!(verdict.kind, VerdictKind::Undecided, "{verdict:?}");
}

#[test]
fn a_translation_is_no_test() {
    // Far out on the p axis a step of an oscillator moves the loop far and deforms it little.
    let oscillator = HarmonicOscillator::new(vec![1.0]).unwrap();
    let rk4 = build("rk4", None, Arc::new(oscillator) as Arc<dyn Separable>).unwrap();
    let phase_loop = circle(&[0.0], &[1000.0], 1.0);
    let verdict = diagnose(&Diagnostic::halving(-10, -16), &*rk4, &phase_loop).verdict;
    assert_eq!(verdict.kind, VerdictKind::Undecided, "{verdict:?}");
    // A step that is exactly a translation is not the approximation of any method.
    assert_eq!(verdict_of(|_, q, _| *q += 1.0).0, VerdictKind::Symplectic);
    // A kick alone deforms p as a function of q.
    assert_eq!(
        verdict_of(|h, q, p| *p -= h * 2.0 * q.sin()).0,
        VerdictKind::Symplectic
    );
}

#[test]
fn samples_that_jump_over_the_grid_do_not_decide() {
    use symplint_plasma::pic::{Pic1d, PicConfig, TwoStream};
    // 2.6 × 10^5 cells of a field too weak to be felt, from one sample to the next.
    let pic = Pic1d::new(PicConfig {
        degree: 1,
        length: 1e-6,
        ..PicConfig::default()
    })
    .unwrap();
    let (x, v) = TwoStream::default().sample(&pic, 5).unwrap();
    let map = build("strang", None, Arc::new(pic) as Arc<dyn Separable>).unwrap();
    let verdict = diagnose(&Diagnostic::default(), &*map, &circle(&x, &v, 1.0)).verdict;
    assert_eq!(verdict.kind, VerdictKind::Undecided, "{verdict:?}");
    assert!(verdict.summary().contains("grid cells"), "{verdict}");
}

#[test]
fn narrow_features_of_small_systems_are_seen() {
    // A kick that acts on a thousandth of the loop only.
    let (kind, ..) = verdict_of(|h, q, p| {
        if (*q - 0.31).abs() < 2e-3 {
            *p += h;
        }
        *q += h * *p;
    });
    assert_eq!(kind, VerdictKind::BrokenLoops);
    let verdict = diagnose(
        &Diagnostic::default(),
        &PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
            q[0] += h * p[0];
            p[0] -= h * q[0].sin();
        }),
        &circle(&[0.4], &[0.7], 1.0),
    )
    .verdict;
    assert!(
        verdict
            .sentences()
            .iter()
            .any(|line| line.contains("finer than 1/2048"))
    );
}

#[test]
fn orders_need_enough_step_sizes() {
    let map = build(
        "rk2",
        None,
        Arc::new(Pendulum::default()) as Arc<dyn Separable>,
    )
    .unwrap();
    let order_of = |step_sizes: &[f64]| {
        let diagnostic = Diagnostic {
            step_sizes: step_sizes.to_vec(),
            ..Diagnostic::default()
        };
        let verdict = diagnose(&diagnostic, &*map, &circle(&[2.0], &[0.5], 1.0)).verdict;
        assert_eq!(verdict.kind, VerdictKind::NotSymplectic, "{step_sizes:?}");
        assert!(
            !verdict
                .advice()
                .iter()
                .any(|line| line.contains("wrong sign")),
            "{step_sizes:?}"
        );
        verdict.order
    };
    for few in [&[0.5][..], &[0.5, 0.49], &[0.5, 0.25], &[0.5, 0.49, 0.48]] {
        assert_eq!(order_of(few), None, "{few:?}");
    }
    assert_eq!(order_of(&[0.125, 0.0625, 0.03125]), Some(3.0));
    assert_eq!(order_of(&[0.1, 0.05, 0.025, 0.0125]), Some(3.0));
    assert_eq!(order_of(&[0.0125, 0.1, 0.025, 0.05, 0.2]), Some(3.0));
}

//! The streaming rule: chosen by hand, and by itself.

use std::sync::Arc;

use symplint::diagnosis::SampleCount;
use symplint::rules::Streaming;
use symplint::{Block, Diagnostic, PerSample, Rule, StepFailure, TimeAdvance, VerdictKind};
use symplint_models::Separable;
use symplint_models::integrators::catalogue::build;
use symplint_models::systems::{HenonHeiles, InterpolatedPendulum, Pendulum, PendulumArray};

use crate::verdicts::{circle, diagnose};

fn streaming() -> Diagnostic {
    Diagnostic {
        rule: Rule::Streaming(Streaming::default()),
        ..Diagnostic::halving(-1, -7)
    }
}

#[test]
fn smooth_systems_get_the_verdicts_of_the_truth_table() {
    let array = PendulumArray::new(5, 1.0, 1.0).unwrap();
    let (q0, p0) = array.uniform_state(1);
    let systems: [(Arc<dyn Separable>, _); 3] = [
        (Arc::new(Pendulum::default()), circle(&[2.0], &[0.5], 1.0)),
        (Arc::new(array), circle(&q0, &p0, 1.0)),
        (Arc::new(HenonHeiles), circle(&[0.1, 0.0], &[0.1, 0.2], 0.3)),
    ];
    for (system, phase_loop) in systems {
        for (name, variant, order) in [
            ("strang", None, None),
            ("yoshida4", None, None),
            ("euler", None, Some(2.0)),
            ("rk2", Some("midpoint"), Some(3.0)),
            ("rk2", Some("heun"), Some(4.0)),
        ] {
            let map = build(name, variant, Arc::clone(&system)).unwrap();
            let diagnosis = diagnose(&streaming(), &*map, &phase_loop);
            let verdict = &diagnosis.verdict;
            assert!(
                diagnosis
                    .points()
                    .iter()
                    .all(|point| point.rule.name() == "streaming")
            );
            if order.is_some() {
                assert_eq!(
                    verdict.kind,
                    VerdictKind::NotSymplectic,
                    "{name}: {verdict:?}"
                );
                assert_eq!(verdict.order, order, "{name}: {verdict:?}");
            } else {
                assert_eq!(verdict.kind, VerdictKind::Symplectic, "{name}: {verdict:?}");
                assert!(verdict.digits.unwrap() > 13.0, "{name}: {verdict:?}");
            }
        }
    }
}

#[test]
fn kinks_and_noise_are_not_taken_for_a_defect() {
    let spline: Arc<dyn Separable> = Arc::new(InterpolatedPendulum::new(2, 33).unwrap());
    let map = build("strang", None, spline).unwrap();
    let verdict = diagnose(&streaming(), &*map, &circle(&[3.0], &[0.0], 1.0)).verdict;
    assert_eq!(verdict.kind, VerdictKind::Symplectic, "{verdict:?}");
    assert!(
        (6.0..10.0).contains(&verdict.digits.unwrap()),
        "{verdict:?}"
    );

    let single = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        q[0] = f64::from((q[0] + 0.5 * h * p[0]) as f32);
        p[0] = f64::from((p[0] - h * q[0].sin()) as f32);
        q[0] = f64::from((q[0] + 0.5 * h * p[0]) as f32);
    });
    let verdict = diagnose(&streaming(), &single, &circle(&[2.0], &[0.5], 1.0)).verdict;
    assert_eq!(verdict.kind, VerdictKind::Symplectic, "{verdict:?}");
    assert!((6.0..9.0).contains(&verdict.digits.unwrap()), "{verdict:?}");
}

/// A kick and a drift in every degree of freedom, row by row.
struct Rows<F> {
    dof: usize,
    force: F,
}

impl<F: Fn(usize, f64) -> f64 + Send + Sync> TimeAdvance for Rows<F> {
    fn dof(&self) -> usize {
        self.dof
    }
    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        for i in 0..self.dof {
            for (q, p) in block.q.row_mut(i).iter_mut().zip(block.p.row_mut(i)) {
                *p += h * (self.force)(i, *q);
                *q += h * *p;
            }
        }
        Ok(())
    }
}

fn at_one_step(samples: SampleCount) -> Diagnostic {
    Diagnostic {
        samples,
        loops: 1,
        jacobian: false,
        ..Diagnostic::halving(-1, -1)
    }
}

#[test]
fn samples_that_would_not_fit_are_streamed() {
    const DOF: usize = 40_000;
    let phase_loop = circle(&vec![0.3; DOF], &vec![0.5; DOF], 1.0);
    let map = Rows {
        dof: DOF,
        force: |_, q: f64| -q,
    };
    for (samples, rule) in [(512, "pseudospectral"), (1024, "streaming")] {
        let diagnosis = diagnose(&at_one_step(SampleCount::Fixed(samples)), &map, &phase_loop);
        assert_eq!(diagnosis.points()[0].rule.name(), rule);
        assert_eq!(diagnosis.points()[0].samples, samples);
        assert_eq!(diagnosis.verdict.kind, VerdictKind::Symplectic);
    }
}

#[test]
fn kinks_of_more_degrees_of_freedom_than_pieces_follow_have_all_samples_that_fit() {
    // More kinks than the piecewise rule may follow unasked.
    const DOF: usize = 1024;
    let phase_loop = circle(&[0.0; DOF], &[0.5; DOF], 1.0);
    let map = Rows {
        dof: DOF,
        force: |i, q: f64| -(q - 0.9 * (i as f64).sin()).abs(),
    };
    let diagnosis = diagnose(&at_one_step(SampleCount::Auto), &map, &phase_loop);
    let point = &diagnosis.points()[0];
    assert_eq!(
        (point.rule.name(), point.samples),
        ("pseudospectral", 1 << 15)
    );
    assert_eq!(diagnosis.verdict.kind, VerdictKind::Symplectic);
}

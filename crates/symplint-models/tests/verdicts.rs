//! Verdicts on maps whose right answer is known from theory.

use std::f64::consts::PI;
use std::sync::Arc;

use symplint::{
    Circle, Coordinates, Cutoffs, Diagnosis, Diagnostic, Error, Loop, PerSample, Rule, RuleChoice,
    SampleCount, StepFailure, TimeAdvance, VerdictKind,
};
use symplint_models::integrators::catalogue::{CATALOGUE, build};
use symplint_models::systems::{
    AbsoluteValue, HarmonicOscillator, HenonHeiles, InterpolatedPendulum, Pendulum, PendulumArray,
    PendulumPotential,
};
use symplint_models::{Model, Separable};

fn diagnose(diagnostic: &Diagnostic, map: &dyn TimeAdvance, phase_loop: &dyn Loop) -> Diagnosis {
    diagnostic.run(map, phase_loop, &|_| {}).unwrap()
}

fn circle(q0: &[f64], p0: &[f64], radius: f64) -> Circle {
    Circle::new(q0.to_vec(), p0.to_vec(), radius).unwrap()
}

/// One degree of freedom, step by step, with the default diagnostic on the circle round (0.4, 0.7).
fn verdict_of(
    step: impl Fn(f64, &mut f64, &mut f64) + Send + Sync,
) -> (VerdictKind, Option<f64>, Option<f64>) {
    let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        step(h, &mut q[0], &mut p[0]);
    });
    let verdict = diagnose(&Diagnostic::default(), &map, &circle(&[0.4], &[0.7], 1.0)).verdict;
    (verdict.kind, verdict.order, verdict.digits)
}

/// A smooth nonlinear system with the loop's centre and radius.
type Case = (&'static str, Arc<dyn Separable>, Vec<f64>, Vec<f64>, f64);

fn smooth_systems() -> Vec<Case> {
    let array = PendulumArray::new(8, 1.0, 1.0).unwrap();
    let (q0, p0) = array.uniform_state(3);
    vec![
        (
            "pendulum",
            Arc::new(Pendulum::default()),
            vec![2.0],
            vec![0.5],
            1.0,
        ),
        (
            "pendulum, sin",
            Arc::new(Pendulum::new(PendulumPotential::Sin)),
            vec![0.5],
            vec![0.3],
            1.0,
        ),
        (
            "Hénon–Heiles",
            Arc::new(HenonHeiles),
            vec![0.0, 0.1],
            vec![0.2, 0.1],
            0.3,
        ),
        ("array", Arc::new(array), q0, p0, 1.0),
        (
            "wedge, rounded",
            Arc::new(AbsoluteValue::new(0.3).unwrap()),
            vec![0.2],
            vec![0.1],
            1.0,
        ),
        (
            "interpolated, degree 5",
            Arc::new(InterpolatedPendulum::new(5, 25).unwrap()),
            vec![PI],
            vec![0.5],
            1.0,
        ),
        (
            "not interpolated",
            Arc::new(InterpolatedPendulum::new(0, 25).unwrap()),
            vec![PI],
            vec![0.5],
            1.0,
        ),
    ]
}

#[test]
fn every_integrator_on_every_smooth_system() {
    for (system_name, system, q0, p0, radius) in smooth_systems() {
        let phase_loop = circle(&q0, &p0, radius);
        let model = Model::Separable(Arc::clone(&system));
        for info in CATALOGUE.iter().filter(|info| info.is_for(&model)) {
            let variants: Vec<Option<&str>> = match info.variants {
                [] => vec![None],
                variants => variants.iter().copied().map(Some).collect(),
            };
            for variant in variants {
                let what = format!("{system_name}, {}, {variant:?}", info.name);
                let map = build(info.name, variant, Arc::clone(&system)).unwrap();
                let verdict = diagnose(&Diagnostic::default(), &*map, &phase_loop).verdict;
                // Euler's Jacobian determinant is 1 + h² V''; the midpoint rule's first term is odd
                // in p, of third order; Heun's is of fourth. The classical rule's is h⁶ in one degree
                // of freedom and h⁵ in several.
                let expected = match (info.name, variant) {
                    ("euler", _) => Some(2.0),
                    ("rk2", Some("midpoint")) => Some(3.0),
                    ("rk2", _) => Some(4.0),
                    ("rk4", _) if q0.len() > 1 => Some(5.0),
                    ("rk4", _) => Some(6.0),
                    // Conjugate to the midpoint rule, and near it: what differs is odd in p.
                    ("trapezoidal" | "averaged-vector-field", _) => Some(3.0),
                    // The gradient of the step size, which is of order h, against the flow.
                    ("adaptive-strang", _) => Some(1.0),
                    ("wrong-sign-euler", _) => Some(2.0),
                    ("rk45" | "dop853", _) => {
                        // So accurate that few step sizes show the order, if any.
                        assert!(!info.symplectic, "{what}");
                        assert_eq!(verdict.kind, VerdictKind::NotSymplectic, "{what}");
                        let order = verdict.order.unwrap_or(f64::INFINITY);
                        assert!(order > f64::from(info.order) + 0.9, "{what}: {verdict:?}");
                        continue;
                    }
                    _ => None,
                };
                match expected {
                    None => {
                        assert!(info.symplectic, "{what}");
                        assert_eq!(verdict.kind, VerdictKind::Symplectic, "{what}: {verdict:?}");
                        assert!(verdict.digits.unwrap() > 11.0, "{what}: {verdict:?}");
                    }
                    order => {
                        assert!(!info.symplectic, "{what}");
                        assert_eq!(verdict.kind, VerdictKind::NotSymplectic, "{what}");
                        assert_eq!(verdict.order, order, "{what}: {verdict:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn linear_oscillators_have_the_orders_of_their_determinants() {
    // det = 1 + h²ω², 1 + h⁴ω⁴/4 and 1 − h⁶ω⁶/72 + …
    let system: Arc<dyn Separable> = Arc::new(HarmonicOscillator::new(vec![1.0, 0.5]).unwrap());
    for (name, variant, order) in [
        ("euler", None, 2.0),
        ("rk2", Some("midpoint"), 4.0),
        ("rk2", Some("heun"), 4.0),
        ("rk4", None, 6.0),
    ] {
        let map = build(name, variant, Arc::clone(&system)).unwrap();
        let phase_loop = circle(&[0.0; 2], &[0.0; 2], 1.0);
        let verdict = diagnose(&Diagnostic::halving(0, -8), &*map, &phase_loop).verdict;
        assert_eq!(verdict.kind, VerdictKind::NotSymplectic);
        assert_eq!(
            verdict.order,
            Some(order),
            "{name} {variant:?}: {verdict:?}"
        );
    }
}

#[test]
fn splines_break_loops_at_degree_1_only() {
    for degree in 1..=5 {
        let system: Arc<dyn Separable> = Arc::new(InterpolatedPendulum::new(degree, 25).unwrap());
        let phase_loop = circle(&[PI], &[0.0], 1.0);
        for (name, symplectic) in [("strang", true), ("yoshida4", true), ("rk2", false)] {
            let map = build(name, None, Arc::clone(&system)).unwrap();
            let kind = diagnose(&Diagnostic::default(), &*map, &phase_loop)
                .verdict
                .kind;
            let expected = match (degree, symplectic) {
                (1, _) => VerdictKind::BrokenLoops,
                (_, true) => VerdictKind::Symplectic,
                (_, false) => VerdictKind::NotSymplectic,
            };
            assert_eq!(kind, expected, "degree {degree}, {name}");
        }
    }
}

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
            let beside = diagnose(&Diagnostic::default(), &*map, &circle(&[9.0], &[0.0], 1.0));
            assert_eq!(
                beside.verdict.kind,
                VerdictKind::Symplectic,
                "{name}, {variant}"
            );
        }
    }
}

#[test]
fn steep_but_smooth_is_not_broken() {
    for epsilon in [1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-6] {
        let system: Arc<dyn Separable> = Arc::new(AbsoluteValue::new(epsilon).unwrap());
        let map = build("strang", None, system).unwrap();
        let verdict = diagnose(&Diagnostic::default(), &*map, &circle(&[0.0], &[0.0], 1.0)).verdict;
        assert_eq!(
            verdict.kind,
            VerdictKind::Symplectic,
            "ε = {epsilon}: {verdict:?}"
        );
        assert!(verdict.digits >= Some(9.0), "ε = {epsilon}: {verdict:?}");
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
fn wrong_signs_damping_and_growth_are_seen() {
    // Symplectic Euler with the kick taken at the old position: explicit Euler, order 2.
    let euler = verdict_of(|h, q, p| {
        let force = -q.sin();
        *q += h * *p;
        *p += h * force;
    });
    assert_eq!((euler.0, euler.1), (VerdictKind::NotSymplectic, Some(2.0)));
    // Damping changes areas by −γh.
    let damped = verdict_of(|h, q, p| {
        *p -= h * (q.sin() + 0.1 * *p);
        *q += h * *p;
    });
    assert_eq!(
        (damped.0, damped.1),
        (VerdictKind::NotSymplectic, Some(1.0))
    );
    // A shrinking that does not depend on h.
    let shrinking = verdict_of(|h, q, p| {
        *q += h * *p;
        *p *= 0.999;
    });
    assert_eq!(
        (shrinking.0, shrinking.1),
        (VerdictKind::NotSymplectic, None)
    );
}

#[test]
fn a_wrong_sign_in_symplectic_euler_is_still_symplectic() {
    // The flow of the wrong Hamiltonian: wrong physics, but an exact shear each.
    let flipped = verdict_of(|h, q, p| {
        *p += h * q.sin();
        *q += h * *p;
    });
    assert_eq!(flipped.0, VerdictKind::Symplectic);
}

#[test]
fn symmetric_loops_do_not_hide_a_defect() {
    // det = 1 + 2hp: odd in p, so the circle round p = 0 keeps its area exactly.
    let map = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        p[0] += h * p[0] * p[0];
        q[0] += h * p[0];
    });
    let verdict = diagnose(&Diagnostic::default(), &map, &circle(&[0.0], &[0.0], 0.5)).verdict;
    assert_eq!(
        (verdict.kind, verdict.order),
        (VerdictKind::NotSymplectic, Some(1.0))
    );
    // One plane grows as the other shrinks: their sum stays on equal circles.
    let map = PerSample::new(2, |h, q: &mut [f64], p: &mut [f64]| {
        p[0] *= 1.0 + 0.1 * h;
        p[1] *= 1.0 - 0.1 * h;
        q[0] += h * p[0];
        q[1] += h * p[1];
    });
    let verdict = diagnose(
        &Diagnostic::default(),
        &map,
        &circle(&[0.0; 2], &[0.0; 2], 1.0),
    )
    .verdict;
    assert_eq!(
        (verdict.kind, verdict.order),
        (VerdictKind::NotSymplectic, Some(1.0))
    );
}

#[test]
fn single_precision_is_symplectic_to_single_precision() {
    let (kind, _, digits) = verdict_of(|h, q, p| {
        let (mut x, mut y, h) = (*q as f32, *p as f32, h as f32);
        x += 0.5 * h * y;
        y -= h * x.sin();
        x += 0.5 * h * y;
        (*q, *p) = (f64::from(x), f64::from(y));
    });
    assert_eq!(kind, VerdictKind::Symplectic);
    let digits = digits.unwrap();
    assert!((6.0..9.5).contains(&digits), "{digits} digits");
}

#[test]
fn a_floor_that_rises_as_h_falls_is_no_defect() {
    let (kind, _, _) = verdict_of(|h, q, p| {
        // The kick is formed by dividing by h: its rounding grows as h falls.
        *q += 0.5 * h * *p;
        let kick = ((1.0 / h) + h * q.sin()) - 1.0 / h;
        *p -= kick;
        *q += 0.5 * h * *p;
    });
    assert_ne!(kind, VerdictKind::NotSymplectic);
    assert_ne!(kind, VerdictKind::BrokenLoops);
}

/// Strang on the pendulum by a code that keeps q in [0, 2π).
struct Wrapping {
    coordinates: Coordinates,
}

impl TimeAdvance for Wrapping {
    fn dof(&self) -> usize {
        1
    }
    fn advance(&self, h: f64, block: &mut symplint::Block<'_>) -> Result<(), StepFailure> {
        for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row_mut(0)) {
            *q += 0.5 * h * *p;
            *p -= h * q.sin();
            *q = (*q + 0.5 * h * *p).rem_euclid(2.0 * PI);
        }
        Ok(())
    }
    fn coordinates(&self) -> Coordinates {
        self.coordinates.clone()
    }
}

#[test]
fn wrapped_positions_need_their_period() {
    let phase_loop = circle(&[0.2], &[0.5], 1.0);
    let stated = Wrapping {
        coordinates: Coordinates::plain(1).with_periods(vec![2.0 * PI]).unwrap(),
    };
    let verdict = diagnose(&Diagnostic::default(), &stated, &phase_loop).verdict;
    assert_eq!(verdict.kind, VerdictKind::Symplectic, "{verdict:?}");
    let silent = Wrapping {
        coordinates: Coordinates::plain(1),
    };
    let verdict = diagnose(&Diagnostic::default(), &silent, &phase_loop).verdict;
    assert_eq!(verdict.kind, VerdictKind::BrokenLoops);
    assert!(verdict.advice.iter().any(|line| line.contains("period")));
}

#[test]
fn weights_make_velocities_canonical() {
    // Two particles of unequal mass on a spring, in velocities.
    let masses = [1.0, 3.0];
    struct Pair(Coordinates, [f64; 2]);
    impl TimeAdvance for Pair {
        fn dof(&self) -> usize {
            2
        }
        fn advance(&self, h: f64, block: &mut symplint::Block<'_>) -> Result<(), StepFailure> {
            for k in 0..block.len() {
                let stretch = block.q.row(1)[k] - block.q.row(0)[k];
                for (i, sign) in [(0, 1.0), (1, -1.0)] {
                    block.p.row_mut(i)[k] += sign * h * stretch.sin() / self.1[i];
                    let v = block.p.row(i)[k];
                    block.q.row_mut(i)[k] += h * v;
                }
            }
            Ok(())
        }
        fn coordinates(&self) -> Coordinates {
            self.0.clone()
        }
    }
    let phase_loop = circle(&[0.0, 1.0], &[0.2, -0.3], 0.8);
    let weighted = Pair(
        Coordinates::plain(2).with_weights(masses.to_vec()).unwrap(),
        masses,
    );
    let verdict = diagnose(&Diagnostic::default(), &weighted, &phase_loop).verdict;
    assert_eq!(verdict.kind, VerdictKind::Symplectic, "{verdict:?}");
    let plain = Pair(Coordinates::plain(2), masses);
    let verdict = diagnose(&Diagnostic::default(), &plain, &phase_loop).verdict;
    assert_eq!(
        (verdict.kind, verdict.order),
        (VerdictKind::NotSymplectic, Some(1.0))
    );
}

#[test]
fn threads_do_not_change_a_bit() {
    let array = PendulumArray::new(37, 1.0, 1.0).unwrap();
    let (q0, p0) = array.uniform_state(1);
    let map = build("rk4", None, Arc::new(array) as Arc<dyn Separable>).unwrap();
    let phase_loop = circle(&q0, &p0, 1.0);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| diagnose(&Diagnostic::halving(-1, -4), &*map, &phase_loop).points)
    };
    let one = run(1);
    for threads in [2, 3, 5] {
        assert_eq!(run(threads), one, "{threads} threads");
    }
}

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
        ..Diagnostic::halving(-1, -4)
    };
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let phase_loop = circle(&[0.0; 2], &[0.0; 2], 1.0);
        let error = pool.install(|| diagnostic.run(&map, &phase_loop, &|_| {}).unwrap_err());
        // sin 2πk/1000 first exceeds 0.95 at k = 200 (0.9511); h = 1/8 is the first below 0.2.
        assert!(
            matches!(
                error,
                Error::NotFinite { coordinate: "q", dof: 1, sample: 200, step_size: Some(h), .. } if h == 0.125
            ),
            "{error:?}"
        );
        let text = error.to_string();
        for part in ["degree of freedom 1", "sample 200", "h = 0.125"] {
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
        fn advance(&self, _: f64, block: &mut symplint::Block<'_>) -> Result<(), StepFailure> {
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
        .run(&Stubborn, &circle(&[0.0], &[0.0], 1.0), &|_| {})
        .unwrap_err();
    // sin 2πk/4096 < −1/2 first at k = 2390, in the third block.
    assert!(
        matches!(error, Error::StepFailed { sample: 2390, .. }),
        "{error:?}"
    );
    assert!(error.to_string().contains("Newton"));
}

#[test]
fn composing_with_the_inverse_returns_the_loop() {
    use symplint_models::integrators::{Splitting, Variant, splitting_methods};
    use symplint_models::maps::{Compose, Inverse};
    let method = || splitting_methods::mclachlan4(Variant::MomentumFirst);
    let forth: Box<dyn TimeAdvance> = Box::new(Splitting::new(method(), HenonHeiles));
    let back: Box<dyn TimeAdvance> = Box::new(Inverse(Splitting::new(method(), HenonHeiles)));
    let both = Compose::new(vec![(1.0, forth), (1.0, back)]).unwrap();
    let phase_loop = circle(&[0.0, 0.1], &[0.2, 0.1], 0.3);
    let before = symplint::Ensemble::sample(&phase_loop, 100).unwrap();
    let mut after = before.clone();
    after.advance(&both, 0.5).unwrap();
    for (rows, again) in [(before.q(), after.q()), (before.p(), after.p())] {
        for i in 0..2 {
            for (a, b) in rows.row(i).iter().zip(again.row(i)) {
                assert!((a - b).abs() < 1e-15);
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
        .run(&map, &circle(&[0.0], &[0.0], 1.0), &|_| {})
        .unwrap_err();
    assert!(matches!(error, Error::Overflow { dof: 0, .. }), "{error:?}");
    let loops = circle(&[0.0], &[0.0], 1e160);
    let map = PerSample::new(1, |_, _: &mut [f64], _: &mut [f64]| {});
    assert!(Diagnostic::default().run(&map, &loops, &|_| {}).is_err());
}

#[test]
fn a_translation_is_no_test() {
    // Far out on the p axis a step of an oscillator moves the loop far and deforms it little.
    let oscillator = HarmonicOscillator::new(vec![1.0]).unwrap();
    let rk4 = build("rk4", None, Arc::new(oscillator) as Arc<dyn Separable>).unwrap();
    let phase_loop = circle(&[0.0], &[1000.0], 1.0);
    let verdict = diagnose(&Diagnostic::halving(-10, -16), &*rk4, &phase_loop).verdict;
    assert_eq!(verdict.kind, VerdictKind::Undecided, "{verdict:?}");
    assert_eq!(verdict_of(|_, q, _| *q += 1.0).0, VerdictKind::Undecided);
    // A kick alone deforms p as a function of q.
    assert_eq!(
        verdict_of(|h, q, p| *p -= h * 2.0 * q.sin()).0,
        VerdictKind::Symplectic
    );
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

#[test]
fn steep_stretches_near_a_wrap_are_no_breaks() {
    struct Steep(f64);
    impl TimeAdvance for Steep {
        fn dof(&self) -> usize {
            1
        }
        fn advance(&self, h: f64, block: &mut symplint::Block<'_>) -> Result<(), StepFailure> {
            for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row_mut(0)) {
                *p -= h * 0.1 * ((2.0 * PI * *q).sin() / self.0).tanh();
                *q = (*q + h * *p).rem_euclid(1.0);
            }
            Ok(())
        }
        fn coordinates(&self) -> Coordinates {
            Coordinates::plain(1).with_periods(vec![1.0]).unwrap()
        }
    }
    for width in [1e-2, 1e-4] {
        for samples in [64, 100, 256, 1024] {
            let diagnostic = Diagnostic {
                samples: SampleCount::Fixed(samples),
                ..Diagnostic::halving(0, -4)
            };
            let verdict =
                diagnose(&diagnostic, &Steep(width), &circle(&[0.1], &[0.3], 0.3)).verdict;
            assert_ne!(
                verdict.kind,
                VerdictKind::BrokenLoops,
                "{width}, {samples}: {verdict:?}"
            );
            assert_ne!(
                verdict.kind,
                VerdictKind::NotSymplectic,
                "{width}, {samples}"
            );
        }
    }
}

#[test]
fn small_jumps_and_jumps_at_small_steps_are_found() {
    let (kind, ..) = verdict_of(|h, q, p| {
        *p -= h * q.sin();
        if h < 0.1 && *q > 0.3 {
            *p += 1e-5;
        }
        *q += h * *p;
    });
    assert_eq!(kind, VerdictKind::BrokenLoops);
    let (kind, ..) = verdict_of(|h, q, p| {
        *p -= h * q.sin();
        *q += h * *p;
        if *q > 0.3 {
            *p += 1e-9;
        }
    });
    assert_eq!(kind, VerdictKind::BrokenLoops);
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
            .evidence
            .iter()
            .any(|line| line.contains("narrower than 1/4096"))
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
                .advice
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

#[test]
fn breaks_in_very_many_coordinates_are_sorted_out() {
    const DOF: usize = 2000;
    let map = PerSample::new(DOF, |h, q: &mut [f64], p: &mut [f64]| {
        for i in 0..DOF {
            p[i] += h * (q[(i + 1) % DOF] + q[7 * i % DOF]).sin();
            if q[i] > (i as f64).sin() {
                p[i] += 0.1 * h;
            }
        }
        for i in 0..DOF {
            q[i] += h * p[i];
        }
    });
    let phase_loop = circle(&[0.0; DOF], &[0.5; DOF], 1.0);
    let verdict = diagnose(&Diagnostic::halving(-1, -2), &map, &phase_loop).verdict;
    assert_eq!(verdict.kind, VerdictKind::BrokenLoops);
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
fn particle_in_cell_breaks_loops_unless_its_shapes_are_c1() {
    use symplint_models::pic::{Pic, PicConfig, ShapeFamily, TwoStream};
    fn kind<const D: usize>(family: ShapeFamily, degree: usize, integrator: &str) -> VerdictKind {
        let pic = Pic::<D>::new(PicConfig {
            family,
            degree,
            cells: 16,
            length: 12.0,
            ..PicConfig::default()
        })
        .unwrap();
        let (x, v) = TwoStream::default().sample(&pic, 5).unwrap();
        let map = build(integrator, None, Arc::new(pic) as Arc<dyn Separable>).unwrap();
        diagnose(&Diagnostic::halving(-1, -4), &*map, &circle(&x, &v, 1.0))
            .verdict
            .kind
    }
    for degree in [2, 3] {
        let spline = ShapeFamily::BSpline;
        assert_eq!(
            kind::<1>(spline, degree, "strang"),
            VerdictKind::Symplectic,
            "{degree}"
        );
        assert_eq!(
            kind::<2>(spline, degree, "strang"),
            VerdictKind::Symplectic,
            "{degree}"
        );
        assert_eq!(
            kind::<1>(spline, degree, "rk2"),
            VerdictKind::NotSymplectic,
            "{degree}"
        );
        assert_eq!(
            kind::<2>(spline, degree, "rk2"),
            VerdictKind::NotSymplectic,
            "{degree}"
        );
    }
    for (family, degree) in [
        (ShapeFamily::BSpline, 1),
        (ShapeFamily::Lagrange, 1),
        (ShapeFamily::Lagrange, 2),
        (ShapeFamily::Lagrange, 3),
    ] {
        let what = format!("{family:?}, degree {degree}");
        assert_eq!(
            kind::<1>(family, degree, "strang"),
            VerdictKind::BrokenLoops,
            "{what}"
        );
        assert_eq!(
            kind::<2>(family, degree, "strang"),
            VerdictKind::BrokenLoops,
            "{what}"
        );
    }
}

#[test]
fn samples_that_jump_over_the_grid_do_not_decide() {
    use symplint_models::pic::{Pic1d, PicConfig, TwoStream};
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
    assert!(verdict.summary.contains("do not see the grid"), "{verdict}");
}

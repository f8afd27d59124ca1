//! Maps without a step size, maps composed with themselves, and stated periods that are not those of the map.

use std::f64::consts::TAU;
use std::sync::atomic::{AtomicUsize, Ordering};

use symplint::evidence::Evaluations;
use symplint::map::Repeat;
use symplint::verdict::{Advice, Finding, MapFinding};
use symplint::{
    Circle, Coordinates, Diagnostic, Error, FourierLoop, PerSample, TimeAdvance, VerdictKind,
};

fn small_circle() -> Circle {
    Circle::new(vec![2e-3], vec![1e-3], 8e-3).unwrap()
}

/// The fringe field of a magnet, with momenta times `factor` after it.
fn edge(factor: f64) -> impl TimeAdvance {
    PerSample::new(1, move |_, q: &mut [f64], p: &mut [f64]| {
        p[0] *= factor / (1.0 + 0.3 * q[0] * q[0]);
        q[0] += 0.1 * q[0].powi(3);
    })
}

#[test]
fn a_fringe_field_is_symplectic_on_larger_loops_as_well() {
    let found = (Diagnostic::without_step_size().run(&edge(1.0), &small_circle())).unwrap();
    assert_eq!(found.verdict.kind, VerdictKind::Symplectic);
    assert!(found.points().iter().all(|point| point.step_size.is_nan()));
    // 64 times as large, if the map works there.
    let reach = found.evidence.reach.expect("it moves the loop little");
    assert_eq!((reach.factor, reach.step.step_size), (64.0, None));
    let json = serde_json::to_string(&found.evidence).unwrap();
    assert!(json.contains("\"step_size\":null") && !json.contains("\"step_size\":1"));
    let read = serde_json::from_str(&json).unwrap();
    assert_eq!(found.evidence, read);
    let text = found.verdict.summary() + &found.verdict.sentences().concat();
    assert!(
        !text.contains("h =") && !text.contains("step size"),
        "{text}"
    );
}

#[test]
fn a_small_defect_of_a_map_without_a_step_size_shows() {
    for lost in [1e-3, 1e-6, 1e-9] {
        let map = edge(1.0 - lost);
        let found = (Diagnostic::without_step_size().run(&map, &small_circle())).unwrap();
        assert_eq!(found.verdict.kind, VerdictKind::NotSymplectic, "{lost}");
        assert_eq!(found.verdict.order, None);
        assert!(!found.verdict.advice.contains(&Advice::StateStepSizes));
    }
}

#[test]
fn larger_loops_end_where_the_map_does() {
    // Defined for |q| < 0.1.
    let map = PerSample::new(1, |_, q: &mut [f64], p: &mut [f64]| {
        p[0] += 1e-4 * q[0] / (0.01 - q[0] * q[0]).sqrt();
        q[0] += 1e-6 * p[0];
    });
    let found = (Diagnostic::without_step_size().run(&map, &small_circle())).unwrap();
    assert_eq!(found.verdict.kind, VerdictKind::Symplectic);
    assert!((4.0..64.0).contains(&found.evidence.reach.unwrap().factor));
}

#[test]
fn the_identity_is_named() {
    let map = PerSample::new(1, |_, _: &mut [f64], _: &mut [f64]| {});
    let found = (Diagnostic::without_step_size().run(&map, &small_circle())).unwrap();
    assert_eq!(found.verdict.kind, VerdictKind::Symplectic);
    let text = found.verdict.sentences().concat();
    assert!(text.contains("leaves every state"), "{text}");
    assert_eq!(found.verdict.advice, [Advice::MovesNothing]);
    // With a step size it is a step that returns nothing.
    let found = (Diagnostic::halving(-1, -4).run(&map, &small_circle())).unwrap();
    assert_eq!(found.verdict.kind, VerdictKind::Undecided);
    assert_eq!(found.verdict.advice, [Advice::ReturnStates]);
}

#[test]
fn an_accurate_method_shows_at_a_larger_step() {
    // Explicit midpoint rule of an oscillator: the defect is h⁴/4.
    let map = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        let (q_half, p_half) = (q[0] + 0.5 * h * p[0], p[0] - 0.5 * h * q[0]);
        q[0] += h * p_half;
        p[0] -= h * q_half;
    });
    let circle = Circle::new(vec![0.3], vec![0.5], 1.0).unwrap();
    let steps = |h: f64| Diagnostic {
        step_sizes: vec![h, 0.5 * h],
        ..Diagnostic::default()
    };
    let found = steps(1e-5).run(&map, &circle).unwrap();
    assert_eq!(found.verdict.kind, VerdictKind::Undecided);
    let [Advice::LargerSteps { factor, .. }] = found.verdict.advice[..] else {
        panic!("{}", found.verdict);
    };
    let found = steps(1e-5 * factor.unwrap()).run(&map, &circle).unwrap();
    assert_eq!(found.verdict.kind, VerdictKind::NotSymplectic);
}

#[test]
fn repetitions_are_counted_as_evaluations() {
    let calls = AtomicUsize::new(0);
    let map = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        calls.fetch_add(1, Ordering::Relaxed);
        p[0] -= h * q[0].sin();
        q[0] += h * p[0];
    });
    let circle = Circle::new(vec![0.3], vec![0.5], 0.5).unwrap();
    let diagnostic = Diagnostic {
        repeat: 7,
        budget: Some(30_000),
        ..Diagnostic::halving(-3, -6)
    };
    let found = diagnostic.run(&map, &circle).unwrap();
    let Evaluations { made, budget, .. } = found.evidence.evaluations;
    assert_eq!((made, budget), (calls.load(Ordering::Relaxed), 30_000));
    // The same numbers as for the composition.
    let once = Diagnostic {
        repeat: 1,
        budget: Some(30_000 / 7),
        ..diagnostic.clone()
    };
    let composed = once.run(&Repeat::new(&map, 7).unwrap(), &circle).unwrap();
    assert_eq!(found.points(), composed.points());
    for (repeat, what) in [(0, "repetitions"), (200, "budget")] {
        let diagnostic = Diagnostic {
            repeat,
            ..diagnostic.clone()
        };
        let error = diagnostic.run(&map, &circle).unwrap_err().to_string();
        assert!(error.contains(what), "{error}");
    }
}

/// A pendulum that may wrap its position by 2π.
fn pendulum(stated: f64, wraps: bool) -> impl TimeAdvance {
    let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        p[0] -= h * q[0].sin();
        q[0] += h * p[0];
        if wraps {
            q[0] = q[0].rem_euclid(TAU);
        }
    });
    let coordinates = Coordinates::plain(1).with_periods(vec![stated]).unwrap();
    map.with_coordinates(coordinates).unwrap()
}

#[test]
fn a_period_that_is_not_one_of_the_map_is_named() {
    let circle = Circle::new(vec![0.3], vec![0.5], 0.5).unwrap();
    let diagnostic = Diagnostic::halving(-1, -4);
    let wrong = |found: &Finding| matches!(found, Finding::Map(MapFinding::WrongPeriod(wrong)) if wrong.dof == 0);
    for (stated, is_wrong) in [(TAU, false), (2.0 * TAU, false), (6.25, true), (3.0, true)] {
        let found = diagnostic.run(&pendulum(stated, false), &circle).unwrap();
        assert_eq!(found.verdict.kind, VerdictKind::Symplectic, "{stated}");
        assert_eq!(
            found.verdict.findings.iter().any(wrong),
            is_wrong,
            "{stated}"
        );
        assert_eq!(
            found.verdict.advice.contains(&Advice::CorrectPeriod),
            is_wrong
        );
        assert_eq!(
            found.evidence.loops.iter().any(|found| found.winds),
            !is_wrong
        );
        // A loop that winds by it is not closed.
        let winding = FourierLoop::random(vec![0.3], vec![3.0], &[0.5], &[0.5], 1).unwrap();
        let winding = winding.winding(0, stated).unwrap();
        let found = diagnostic.run(&pendulum(stated, false), &winding);
        match found {
            Ok(found) => assert_eq!(
                (found.verdict.kind, is_wrong),
                (VerdictKind::Symplectic, false)
            ),
            Err(error) => assert!(
                is_wrong && matches!(error, Error::NotAPeriod { .. }),
                "{error}"
            ),
        }
        // Nor is the image of one that crosses the end of the box.
        if stated < 2.0 * TAU {
            let found = diagnostic.run(&pendulum(stated, true), &circle);
            assert_eq!(
                matches!(found, Err(Error::NotAPeriod { .. })),
                is_wrong,
                "{stated}"
            );
        }
    }
}

#[test]
fn rounding_and_failures_beside_the_box_are_no_wrong_periods() {
    let circle = Circle::new(vec![0.3], vec![0.5], 0.2).unwrap();
    let coordinates = || Coordinates::plain(1).with_periods(vec![TAU]).unwrap();
    let single = |x: f64| f64::from(x as f32);
    let step = |h: f64, q: &mut [f64], p: &mut [f64]| {
        p[0] -= h * q[0].sin();
        q[0] += h * p[0];
    };
    let rounds = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        step(h, q, p);
        (q[0], p[0]) = (single(q[0]), single(p[0]));
    });
    let inside = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        p[0] -= h * f64::from((q[0] as f32).sin());
        q[0] += h * p[0];
    });
    let in_a_box = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        let outside = q[0] > TAU;
        step(h, q, p);
        q[0] = if outside { f64::NAN } else { q[0] };
    });
    let diagnostic = Diagnostic {
        loops: 1,
        ..Diagnostic::halving(-1, -3)
    };
    let maps: [Box<dyn TimeAdvance>; 3] = [
        Box::new(rounds.with_coordinates(coordinates()).unwrap()),
        Box::new(inside.with_coordinates(coordinates()).unwrap()),
        Box::new(in_a_box.with_coordinates(coordinates()).unwrap()),
    ];
    for map in maps {
        let found = diagnostic.run(&map, &circle).unwrap();
        assert_eq!(found.evidence.survey.wrong_period, None);
    }
}

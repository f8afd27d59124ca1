//! Maps whose momenta are periodic.

use std::f64::consts::TAU;

use symplint::diagnosis::SampleCount;
use symplint::rules::{Cutoffs, Piecewise, Streaming};
use symplint::{
    Circle, Coordinates, Diagnostic, Error, LoopIntegral, PerSample, Rule, TimeAdvance, VerdictKind,
};

/// Wraps both coordinates of a step into [0, period).
fn on_torus(
    period: f64,
    step: impl Fn(f64, f64) -> (f64, f64) + Send + Sync,
    stated: bool,
) -> impl TimeAdvance {
    let momentum = if stated { period } else { 0.0 };
    let coordinates = Coordinates::plain(1)
        .with_periods(vec![period])
        .unwrap()
        .with_momentum_periods(vec![momentum])
        .unwrap();
    PerSample::new(1, move |_, q: &mut [f64], p: &mut [f64]| {
        let (new_q, new_p) = step(q[0], p[0]);
        q[0] = new_q.rem_euclid(period);
        p[0] = new_p.rem_euclid(period);
    })
    .with_coordinates(coordinates)
    .unwrap()
}

/// Chirikov's map.
fn standard(stated: bool) -> impl TimeAdvance {
    let step = |q: f64, p: f64| {
        let p = p + 0.9 * q.sin();
        (q + p, p)
    };
    on_torus(TAU, step, stated)
}

fn diagnose(map: &dyn TimeAdvance, centre: [f64; 2], radius: f64, rule: Rule) -> VerdictKind {
    let circle = Circle::new(vec![centre[0]], vec![centre[1]], radius).unwrap();
    let diagnostic = Diagnostic {
        step_sizes: vec![1.0],
        rule,
        ..Diagnostic::default()
    };
    let diagnosis = diagnostic.run(map, &circle).unwrap();
    println!("{}", diagnosis.verdict);
    diagnosis.verdict.kind
}

fn rules() -> [Rule; 5] {
    [
        Rule::Auto,
        Rule::Pseudospectral,
        Rule::FiniteDifference(Cutoffs::none()),
        Rule::Piecewise(Piecewise::default()),
        Rule::Streaming(Streaming::default()),
    ]
}

#[test]
fn the_standard_map_on_the_torus_is_symplectic_by_every_rule() {
    for rule in rules() {
        // Advanced momenta cross 0, and 2π where the centre is there.
        for centre in [[0.5, 0.1], [3.0, 6.2]] {
            let kind = diagnose(&standard(true), centre, 0.8, rule);
            match rule {
                // Of first order: its bound is too weak for a verdict.
                Rule::FiniteDifference(_) => assert_ne!(kind, VerdictKind::NotSymplectic),
                _ => assert_eq!(kind, VerdictKind::Symplectic, "{rule:?} {centre:?}"),
            }
        }
    }
}

#[test]
fn without_the_period_its_loops_are_broken() {
    let kind = diagnose(&standard(false), [0.5, 0.1], 0.8, Rule::Auto);
    assert_eq!(kind, VerdictKind::BrokenLoops);
}

#[test]
fn integrals_are_those_of_the_map_on_the_plane() {
    let plane = PerSample::new(1, |_, q: &mut [f64], p: &mut [f64]| {
        p[0] += 0.9 * q[0].sin();
        q[0] = 1.3 * q[0] + p[0];
    });
    let step = |q: f64, p: f64| {
        let p = p + 0.9 * q.sin();
        (1.3 * q + p, p)
    };
    let torus = on_torus(TAU, step, true);
    let circle = Circle::new(vec![0.5], vec![0.1], 0.8).unwrap();
    let kept = |map: &dyn TimeAdvance, rule: Rule| {
        let mut samples = symplint::Ensemble::sample(&circle, 512).unwrap();
        samples.advance(map, 1.0).unwrap();
        LoopIntegral::in_coordinates(&samples, &rule, &map.capabilities().coordinates).unwrap()
    };
    for rule in [Rule::Pseudospectral, rules()[2]] {
        let [on_plane, on_torus] = [kept(&plane, rule), kept(&torus, rule)];
        assert!((on_plane.value - on_torus.value).abs() < 1e-14);
        assert!(on_torus.quadrature_error.is_some());
    }
    let pieces = |map: &dyn TimeAdvance| Piecewise::default().integrate(map, &circle, 1.0);
    let [on_plane, on_torus] = [&plane as &dyn TimeAdvance, &torus].map(|map| pieces(map).unwrap());
    assert!((on_plane.continuous.value - on_torus.continuous.value).abs() < 1e-13);
    let streamed = |map: &dyn TimeAdvance| {
        Streaming::default()
            .integrate(map, &circle, 1.0, 512)
            .unwrap()
    };
    let [on_plane, on_torus] = [&plane as &dyn TimeAdvance, &torus].map(streamed);
    assert!((on_plane.integral.value - on_torus.integral.value).abs() < 1e-14);
    assert!(on_torus.found.is_none());
}

#[test]
fn the_cat_map_is_symplectic_and_a_stretched_one_is_not() {
    // Continuous on the torus, though every coordinate jumps.
    let cat = on_torus(1.0, |q, p| (2.0 * q + p, q + p), true);
    assert_eq!(
        diagnose(&cat, [0.1, 0.95], 0.2, Rule::Auto),
        VerdictKind::Symplectic
    );
    let stretched = |q: f64, p: f64| (q + 0.1 * (TAU * q).sin() / TAU + p, p);
    let stretched = on_torus(1.0, stretched, true);
    for rule in [Rule::Auto, rules()[3], rules()[4]] {
        assert_eq!(
            diagnose(&stretched, [0.1, 0.95], 0.2, rule),
            VerdictKind::NotSymplectic
        );
    }
}

#[test]
fn a_kick_that_jumps_breaks_loops_and_chords_close_them() {
    // A jump of 0.3 in p, where q passes 0.2.
    let kick = |q: f64| if q > 0.2 { 0.3 } else { 0.0 };
    let step = move |q: f64, p: f64| {
        let p = p + kick(q);
        (q + p, p)
    };
    let torus = on_torus(1.0, step, true);
    assert_eq!(
        diagnose(&torus, [0.1, 0.85], 0.25, Rule::Auto),
        VerdictKind::BrokenLoops
    );
    let plane = PerSample::new(1, move |_, q: &mut [f64], p: &mut [f64]| {
        p[0] += kick(q[0]);
        q[0] += p[0];
    });
    let circle = Circle::new(vec![0.1], vec![0.85], 0.25).unwrap();
    let pieces = |map: &dyn TimeAdvance| Piecewise::default().integrate(map, &circle, 1.0);
    let [on_plane, on_torus] = [&plane as &dyn TimeAdvance, &torus].map(|map| pieces(map).unwrap());
    assert_eq!(on_torus.breaks.len(), 2);
    assert!((on_plane.continuous.value - on_torus.continuous.value).abs() < 1e-11);
    assert!((on_plane.closed().value - on_torus.closed().value).abs() < 1e-11);
}

#[test]
fn loops_round_the_torus_are_refused() {
    let winding = symplint::FourierLoop::random(vec![0.0], vec![0.0], &[0.3], &[0.3], 1)
        .unwrap()
        .winding(0, TAU)
        .unwrap();
    let diagnostic = Diagnostic {
        step_sizes: vec![1.0],
        samples: SampleCount::Fixed(64),
        ..Diagnostic::default()
    };
    let error = diagnostic.run(&standard(true), &winding).unwrap_err();
    assert_eq!(error, Error::WindsRoundTorus { dof: 0 });
    assert!(error.to_string().contains("contracted"));
}

#[test]
fn periods_of_momenta_are_checked() {
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        let plain = Coordinates::plain(1);
        assert!(plain.with_momentum_periods(vec![bad]).is_err());
    }
    assert!(
        Coordinates::plain(2)
            .with_momentum_periods(vec![1.0])
            .is_err()
    );
}

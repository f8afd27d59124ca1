//! Maps of few digits: single precision, printed numbers, forces of few digits.

use symplint::rules::Piecewise;
use symplint::{Circle, Diagnosis, Diagnostic, PerSample, Rule, TimeAdvance, VerdictKind};

fn pendulum32(h: f64, q: &mut [f64], p: &mut [f64]) {
    let (mut x, mut y, h) = (q[0] as f32, p[0] as f32, h as f32);
    x += 0.5 * h * y;
    y -= h * x.sin();
    x += 0.5 * h * y;
    (q[0], p[0]) = (f64::from(x), f64::from(y));
}

fn force32(h: f64, q: &mut [f64], p: &mut [f64]) {
    q[0] += 0.5 * h * p[0];
    p[0] -= h * f64::from((q[0] as f32).sin());
    q[0] += 0.5 * h * p[0];
}

fn decimals(digits: i32) -> impl Fn(f64, &mut [f64], &mut [f64]) + Send + Sync {
    let unit = 10f64.powi(digits);
    move |h, q: &mut [f64], p: &mut [f64]| {
        q[0] += 0.5 * h * p[0];
        p[0] -= h * q[0].sin();
        q[0] += 0.5 * h * p[0];
        q[0] = (q[0] * unit).round() / unit;
        p[0] = (p[0] * unit).round() / unit;
    }
}

fn network32(h: f64, q: &mut [f64], p: &mut [f64]) {
    // A gradient network with a smooth activation, in single precision.
    let mut force = 0f32;
    for k in 0..16 {
        let (a, b) = ((k as f32 * 0.37).sin() * 1.5, (k as f32 * 1.1).cos());
        force += a * (a * q[0] as f32 + b).tanh() * 0.1;
    }
    let force = f64::from(force);
    p[0] -= h * force;
    q[0] += h * p[0];
    (q[0], p[0]) = (f64::from(q[0] as f32), f64::from(p[0] as f32));
}

fn relu32(h: f64, q: &mut [f64], p: &mut [f64]) {
    let mut force = 0f32;
    for k in 0..16 {
        let (a, b) = ((k as f32 * 0.37).sin() * 1.5, (k as f32 * 1.1).cos());
        force += a * (a * q[0] as f32 + b).max(0.0) * 0.1;
    }
    let force = f64::from(force);
    p[0] -= h * force;
    q[0] += h * p[0];
    (q[0], p[0]) = (f64::from(q[0] as f32), f64::from(p[0] as f32));
}

/// A map of one degree of freedom, and what it is called.
type Named = (&'static str, Box<dyn TimeAdvance>);

fn named<F>(name: &'static str, step: F) -> Named
where
    F: Fn(f64, &mut [f64], &mut [f64]) + Send + Sync + 'static,
{
    (name, Box::new(PerSample::new(1, step)))
}

fn maps() -> Vec<Named> {
    vec![
        named("single precision", pendulum32),
        named("force in single precision", force32),
        named("3 decimals", decimals(3)),
        named("6 decimals", decimals(6)),
        named("9 decimals", decimals(9)),
        named("network", network32),
        named("piecewise linear network", relu32),
    ]
}

#[test]
fn rounding_breaks_no_loop() {
    // Near the origin and far from it, on loops down to some thousand roundings.
    for (q0, radius) in [
        (0.3, 1.0),
        (0.3, 0.1),
        (0.3, 1e-2),
        (0.3, 1e-3),
        (50.0, 1e-2),
    ] {
        let on = Circle::new(vec![q0], vec![0.4], radius).unwrap();
        for (name, map) in maps() {
            for budget in [None, Some(50_000), Some(1_000)] {
                let found = check(&*map, &on, Rule::Auto, budget);
                let title = format!("{name}, r = {radius} round {q0}, budget {budget:?}");
                let kind = found.verdict.kind;
                let right = matches!(kind, VerdictKind::Symplectic | VerdictKind::Undecided);
                assert!(right, "{title}: {}", found.verdict);
                // What is undecided is so because its digits are few.
                let least = match name {
                    "3 decimals" => f64::INFINITY,
                    "6 decimals" => 1.0,
                    _ => 0.1,
                };
                let wide = radius >= least && budget != Some(1_000);
                assert!(
                    kind == VerdictKind::Symplectic || !wide,
                    "{title}: {}",
                    found.verdict
                );
            }
        }
    }
}

#[test]
fn rounding_breaks_no_loop_by_pieces_either() {
    for radius in [1.0, 0.1, 1e-3] {
        let on = Circle::new(vec![0.3], vec![0.4], radius).unwrap();
        for (name, map) in maps() {
            let rule = Rule::Piecewise(Piecewise::default());
            let found = check(&*map, &on, rule, None);
            let kind = found.verdict.kind;
            let right = matches!(kind, VerdictKind::Symplectic | VerdictKind::Undecided);
            assert!(right, "{name}, r = {radius}: {}", found.verdict);
            // The grain is known, so that no step of it is followed.
            let made = found.evidence.evaluations.made;
            assert!(made < 100_000, "{name}, r = {radius}: {made}");
        }
    }
}

#[test]
fn what_is_more_than_rounding_is_told_in_few_digits_too() {
    let on = Circle::new(vec![0.3], vec![0.4], 1.0).unwrap();
    let single = |x: f64| f64::from(x as f32);
    let euler = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        let (x, y) = (q[0], p[0]);
        (q[0], p[0]) = (single(x + h * y), single(y - h * x.sin()));
    });
    // The force jumps by 2e-4 at q = 0.5.
    let broken = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        p[0] = single(p[0] - h * (q[0].sin() + if q[0] > 0.5 { 1e-4 } else { -1e-4 }));
        q[0] = single(q[0] + h * p[0]);
    });
    for rule in [Rule::Auto, Rule::Piecewise(Piecewise::default())] {
        let found = check(&euler, &on, rule, None).verdict;
        assert_eq!(found.kind, VerdictKind::NotSymplectic, "{found}");
        let found = check(&broken, &on, rule, None).verdict;
        assert_eq!(found.kind, VerdictKind::BrokenLoops, "{found}");
    }
}

fn check(map: &dyn TimeAdvance, on: &Circle, rule: Rule, budget: Option<usize>) -> Diagnosis {
    let diagnostic = Diagnostic {
        rule,
        budget,
        ..Diagnostic::default()
    };
    diagnostic.run(map, on).unwrap()
}

#[test]
fn degrees_of_freedom_at_rest_are_rounded_too() {
    // Two pendulums, coupled or not, in single precision, of which the loop moves one.
    for coupling in [0.0, 0.3] {
        let map = PerSample::new(2, move |h, q: &mut [f64], p: &mut [f64]| {
            let (mut x, h) = ([q[0] as f32, q[1] as f32], h as f32);
            let mut y = [p[0] as f32, p[1] as f32];
            (0..2).for_each(|i| x[i] += 0.5 * h * y[i]);
            let between = coupling as f32 * (x[0] - x[1]).sin();
            y[0] -= h * (x[0].sin() + between);
            y[1] -= h * (x[1].sin() - between);
            (0..2).for_each(|i| x[i] += 0.5 * h * y[i]);
            (0..2).for_each(|i| (q[i], p[i]) = (f64::from(x[i]), f64::from(y[i])));
        });
        let circle = Circle::new(vec![0.3, 5.1], vec![0.4, 0.2], 0.3).unwrap();
        let on = circle.on(&[0]).unwrap();
        for rule in [Rule::Auto, Rule::Piecewise(Piecewise::default())] {
            let diagnostic = Diagnostic {
                rule,
                ..Diagnostic::default()
            };
            let found = diagnostic.run(&map, &on).unwrap().verdict;
            let right = [VerdictKind::Symplectic, VerdictKind::Undecided];
            assert!(right.contains(&found.kind), "{coupling}: {found}");
        }
    }
}

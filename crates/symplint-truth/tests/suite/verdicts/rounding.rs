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
                // A map is undecided only because its digits are few.
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

fn rounded_to(unit: f64) -> impl TimeAdvance {
    PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        p[0] -= 0.5 * h * q[0].sin();
        q[0] += h * p[0];
        p[0] -= 0.5 * h * q[0].sin();
        for x in [q, p] {
            x[0] = (x[0] / unit).round() * unit;
        }
    })
}

/// Loops of a few grains, down to those of which rounding leaves a point: the numbers decide nothing, the advice is to
/// return more digits, and no evaluations are spent below the floor.
#[test]
fn few_levels_in_any_unit_do_not_decide() {
    let degree = std::f64::consts::PI / 180.0;
    for unit in [1e-3, 1e-3 * degree, 1e-3 * 0.0254, 1e-3 / 3.0] {
        let map = rounded_to(unit);
        for (q0, levels) in [0.5, 3.0, 50.0].into_iter().flat_map(|q0| {
            [0.02, 0.2, 2.0, 5.0, 20.0, 60.0, 300.0, 2000.0].map(|levels| (q0, levels))
        }) {
            let on = Circle::new(vec![q0], vec![0.3], 0.5 * levels * unit).unwrap();
            for budget in [Some(200), Some(1_000), Some(20_000), None] {
                let found = check(&map, &on, Rule::Auto, budget);
                let title = format!("{unit:e}, {levels} levels round {q0}, budget {budget:?}");
                assert_rounding_decides(&found, &title);
            }
            for rule in [
                Rule::Pseudospectral,
                Rule::Streaming(Default::default()),
                Rule::Piecewise(Piecewise::default()),
            ] {
                let title = format!("{unit:e}, {levels} levels round {q0}, {rule:?}");
                assert_rounding_decides(&check(&map, &on, rule, None), &title);
            }
        }
    }
}

/// Forces in single precision, and single precision that is returned in other units, on loops of any size.
#[test]
fn loops_of_a_few_units_of_single_precision_do_not_decide() {
    let degree = std::f64::consts::PI / 180.0;
    let degrees = move |h: f64, q: &mut [f64], p: &mut [f64]| {
        p[0] -= h * q[0].sin();
        q[0] += h * p[0];
        for x in [q, p] {
            x[0] = f64::from((x[0] / degree) as f32) * degree;
        }
    };
    for (name, map) in [
        named("pendulum", pendulum32),
        named("force", force32),
        named("degrees", degrees),
    ] {
        for (q0, radius) in [0.5, 3.0, 50.0]
            .into_iter()
            .flat_map(|q0| [1e-6, 1e-5, 1e-4, 1e-3, 1e-2].map(|radius| (q0, radius)))
        {
            let on = Circle::new(vec![q0], vec![0.3], radius).unwrap();
            for budget in [Some(200), Some(1_000), Some(20_000), None] {
                let found = check(&*map, &on, Rule::Auto, budget);
                let title = format!("{name}, r = {radius} round {q0}, budget {budget:?}");
                let kind = found.verdict.kind;
                let right = matches!(kind, VerdictKind::Symplectic | VerdictKind::Undecided);
                assert!(right, "{title}: {}", found.verdict);
                let made = found.evidence.evaluations.made;
                assert!(made <= 50_000, "{title}: {made} evaluations");
            }
        }
    }
}

/// A map is undecided only because of rounding, and not more than 50,000 evaluations show it.
fn assert_rounding_decides(found: &Diagnosis, title: &str) {
    let verdict = &found.verdict;
    assert_eq!(verdict.kind, VerdictKind::Undecided, "{title}: {verdict}");
    let advice = verdict.advice();
    let first = advice.first().map_or("", String::as_str);
    assert!(
        !advice.iter().any(|line| line.contains("If a force jumps")),
        "{title}: {advice:?}"
    );
    let by_budget = first.contains("budget") || first.contains("evaluations");
    assert!(
        first.contains("more digits") || by_budget,
        "{title}: {advice:?}"
    );
    assert_eq!(found.evidence.survey.singular, None, "{title}");
    let made = found.evidence.evaluations.made;
    assert!(made <= 50_000, "{title}: {made} evaluations");
}

/// A force that jumps by far more than a grain, and a defect far above it.
#[test]
fn coarse_output_hides_no_large_break_and_no_large_defect() {
    let degree = 1e-3 * std::f64::consts::PI / 180.0;
    for unit in [1e-3, degree] {
        let on = Circle::new(vec![0.3], vec![0.4], 1.0).unwrap();
        let broken = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
            p[0] -= h * (q[0].sin() + if q[0] > 0.5 { 0.2 } else { -0.2 });
            q[0] += h * p[0];
            for x in [q, p] {
                x[0] = (x[0] / unit).round() * unit;
            }
        });
        let found = check(&broken, &on, Rule::Auto, None).verdict;
        assert_eq!(found.kind, VerdictKind::BrokenLoops, "{found}");
        let damped = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
            p[0] = 0.9 * p[0] - h * q[0].sin();
            q[0] += h * p[0];
            for x in [q, p] {
                x[0] = (x[0] / unit).round() * unit;
            }
        });
        let found = check(&damped, &on, Rule::Auto, None).verdict;
        assert_eq!(found.kind, VerdictKind::NotSymplectic, "{found}");
    }
}

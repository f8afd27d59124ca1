//! How far a diagnosis has come, and the evaluations that it expects to make, on maps of every kind.

use std::sync::{Arc, Mutex, OnceLock};

use symplint::diagnosis::{Event, Progress};
use symplint::{Circle, Diagnostic, PerSample};

/// Runs a diagnosis, and notes the evaluations finished and expected at every call of the map.
fn followed(
    diagnostic: &Diagnostic,
    step: impl Fn(f64, &mut [f64], &mut [f64]) + Sync + Send,
) -> (usize, Vec<(usize, Option<usize>)>) {
    let progress: OnceLock<Arc<Progress>> = OnceLock::new();
    let noted = Mutex::new(Vec::new());
    let map = PerSample::new(1, |h: f64, q: &mut [f64], p: &mut [f64]| {
        if let Some(progress) = progress.get() {
            (noted.lock().unwrap()).push((progress.finished(), progress.left()));
        }
        step(h, q, p);
    });
    let circle = Circle::new(vec![0.3], vec![0.5], 1.0).unwrap();
    let diagnosis = diagnostic
        .run_watched(&map, &circle, &|event| {
            if let Event::Started(started) = event {
                let _ = progress.set(Arc::clone(started));
            }
        })
        .unwrap();
    (
        diagnosis.evidence.evaluations.made,
        noted.into_inner().unwrap(),
    )
}

/// The largest factor between the evaluations expected and made in the second half of a run, without its last twentieth.
fn worst_factor(made: usize, noted: &[(usize, Option<usize>)]) -> f64 {
    (noted.iter())
        .filter(|(finished, _)| 2 * finished >= made && 20 * finished <= 19 * made)
        .map(|&(finished, left)| {
            let left = left.unwrap_or(0) as f64 / (made - finished) as f64;
            left.max(1.0 / left)
        })
        .fold(1.0, f64::max)
}

#[test]
fn expected_evaluations_are_within_a_factor_of_two_in_the_second_half() {
    type Step = fn(f64, &mut [f64], &mut [f64]);
    let steps: [(&str, Step); 5] = [
        ("symplectic Euler", |h, q, p| {
            p[0] -= h * q[0].sin();
            q[0] += h * p[0];
        }),
        ("explicit Euler", |h, q, p| {
            let force = -q[0].sin();
            q[0] += h * p[0];
            p[0] += h * force;
        }),
        ("friction", |h, q, p| {
            p[0] = (p[0] - h * q[0].sin()) * (-0.1 * h).exp();
            q[0] += h * p[0];
        }),
        ("a wall", |h, q, p| {
            q[0] += h * p[0];
            if q[0] > 1.0 {
                (q[0], p[0]) = (2.0 - q[0], -p[0]);
            }
        }),
        ("a jump", |h, q, p| {
            p[0] -= h * (q[0].sin() + if q[0] > 0.5 { 0.3 } else { 0.0 });
            q[0] += h * p[0];
        }),
    ];
    for (name, step) in steps {
        for budget in [2_000, 20_000, 1_000_000] {
            let diagnostic = Diagnostic {
                budget: Some(budget),
                ..Diagnostic::default()
            };
            let (made, noted) = followed(&diagnostic, step);
            let worst = worst_factor(made, &noted);
            assert!(
                worst < 2.0,
                "{name}, {budget} evaluations: a factor of {worst}"
            );
        }
    }
}

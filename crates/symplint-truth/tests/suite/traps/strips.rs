//! Narrow strips of friction that few samples meet: what the spectrum makes of them is not a bound.

use std::f64::consts::PI;

use symplint::verdict::JacobianVerdict;
use symplint::{Circle, Diagnostic, PerSample, VerdictKind};

/// Momenta times 1 − depth exp(−x²), x = (q − at)/σ, in a pendulum on the unit circle, where 2σ are `width` of the loop.
fn diagnose(width: f64, at: f64, depth: f64, budget: usize) -> (symplint::Diagnosis, f64) {
    let sigma = PI * (1.0 - at * at).sqrt() * width;
    let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        p[0] *= 1.0 - depth * (-((q[0] - at) / sigma).powi(2)).exp();
        p[0] -= h * q[0].sin();
        q[0] += h * p[0];
    });
    // −2 a ∫ √(1 − q²) exp(−x²) dq / π, by the trapezoidal rule, which is exact for Gaussians.
    let parts = (-800..=800).map(|k| {
        let x = 0.01 * f64::from(k);
        let q = at + sigma * x;
        0.01 * sigma * (1.0 - q * q).max(0.0).sqrt() * (-x * x).exp()
    });
    let change = 2.0 * depth * parts.sum::<f64>() / PI;
    let on = Circle::new(vec![0.0], vec![0.1], 1.0).unwrap();
    let diagnostic = Diagnostic {
        budget: Some(budget),
        ..Diagnostic::halving(-1, -8)
    };
    (diagnostic.run(&map, &on).unwrap(), change)
}

#[test]
fn strips_that_samples_have_met_are_not_called_symplectic_to_too_many_digits() {
    for budget in [20_000, 1_000_000] {
        for width in [1e-3, 3e-3, 1e-2] {
            for at in [0.317, -0.6] {
                for depth in [1e-5, 1e-3, 0.1] {
                    let (found, change) = diagnose(width, at, depth, budget);
                    let verdict = &found.verdict;
                    let digits = verdict.digits.unwrap_or(0.0);
                    let what = format!("{width:e} at {at}, {depth:e}, {budget}, {change:e}");
                    assert!(digits <= -change.log10(), "{what}: {verdict}");
                    assert_ne!(verdict.kind, VerdictKind::BrokenLoops, "{what}: {verdict}");
                    if budget == 1_000_000 {
                        assert_eq!(
                            verdict.kind,
                            VerdictKind::NotSymplectic,
                            "{what}: {verdict}"
                        );
                    }
                }
            }
        }
    }
}

/// A kick in a potential, kicked once more by `extra` within a strip of 1/1000 of the loop; `friction` times the momenta there.
fn in_a_strip(
    at: f64,
    kick: impl Fn(f64, f64) -> f64 + Send + Sync + 'static,
    friction: impl Fn(f64) -> f64 + Send + Sync + 'static,
) -> symplint::Diagnosis {
    let sigma = PI * (1.0 - at * at).sqrt() * 1e-3;
    let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        let strip = (-((q[0] - at) / sigma).powi(2)).exp();
        p[0] *= 1.0 - friction(h) * strip;
        p[0] -= h * q[0].sin() + kick(h, strip);
        q[0] += h * p[0];
    });
    let on = Circle::new(vec![0.0], vec![0.1], 1.0).unwrap();
    Diagnostic {
        budget: Some(100_000),
        ..Diagnostic::halving(-1, -8)
    }
    .run(&map, &on)
    .unwrap()
}

/// The place of the second sample of eight of the circle.
const MET: f64 = std::f64::consts::FRAC_1_SQRT_2;

#[test]
fn the_jacobian_shows_a_strip_of_friction_and_clears_a_strip_of_forces() {
    let kicked = in_a_strip(MET, |h, strip| 1e-4 * h * strip, |_| 0.0);
    assert_eq!(
        kicked.verdict.kind,
        VerdictKind::Symplectic,
        "{}",
        kicked.verdict
    );
    let rubbed = in_a_strip(MET, |_, _| 0.0, |h| 1e-2 * h);
    assert_eq!(
        rubbed.verdict.kind,
        VerdictKind::NotSymplectic,
        "{}",
        rubbed.verdict
    );
    let jacobian = rubbed.evidence.jacobian.as_ref().unwrap();
    assert!(
        matches!(jacobian.verdict(), JacobianVerdict::NotSymplectic { .. }),
        "{}",
        jacobian.verdict()
    );
}

#[test]
fn a_strip_that_acts_at_one_small_step_size_alone_is_seen() {
    // The samples of the largest step, which shows nothing, are those of all.
    let is_small = |h: f64| f64::from(h < 0.1 && h > 0.05);
    let rubbed = in_a_strip(MET, |_, _| 0.0, move |h| 1e-2 * is_small(h));
    let steps = &rubbed.evidence.loops[0].steps;
    let with_feature: Vec<f64> = (steps.iter().filter(|step| step.has_feature))
        .filter_map(|step| step.step_size)
        .collect();
    assert_eq!(with_feature, [0.0625]);
    assert_ne!(
        rubbed.verdict.kind,
        VerdictKind::Symplectic,
        "{}",
        rubbed.verdict
    );
}

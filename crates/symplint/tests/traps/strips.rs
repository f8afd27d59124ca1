//! Narrow strips of friction that few samples meet: what the spectrum makes of them is no bound.

use std::f64::consts::PI;

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

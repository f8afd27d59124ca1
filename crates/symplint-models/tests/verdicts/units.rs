//! Units, and steps too small for them: verdicts do not depend on the unit of time or length.

use std::sync::Arc;

use symplint::{Diagnostic, PerSample, VerdictKind};
use symplint_models::Separable;
use symplint_models::integrators::catalogue::build;
use symplint_models::systems::HarmonicOscillator;

use crate::{circle, diagnose};

/// Jupiter round the Sun in astronomical units and days, momenta per mass of Jupiter, by the classical Runge–Kutta
/// method.
fn jupiter() -> PerSample<impl Fn(f64, &mut [f64], &mut [f64]) + Send + Sync> {
    const MU: f64 = 2.959_122_082_855_911e-4;
    let derivative = |z: [f64; 4]| {
        let r3 = (z[0] * z[0] + z[1] * z[1]).powf(1.5);
        [z[2], z[3], -MU * z[0] / r3, -MU * z[1] / r3]
    };
    PerSample::new(2, move |h, q: &mut [f64], p: &mut [f64]| {
        let z = [q[0], q[1], p[0], p[1]];
        let at = |k: [f64; 4], by: f64| std::array::from_fn(|i| z[i] + by * k[i]);
        let k1 = derivative(z);
        let k2 = derivative(at(k1, 0.5 * h));
        let k3 = derivative(at(k2, 0.5 * h));
        let k4 = derivative(at(k3, h));
        let step = |i: usize| h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        (q[0], q[1]) = (z[0] + step(0), z[1] + step(1));
        (p[0], p[1]) = (z[2] + step(2), z[3] + step(3));
    })
}

#[test]
fn a_step_of_half_a_day_says_nothing_of_jupiter() {
    // Its velocity is 7.5e-3 AU a day: a radius of 1e-3 AU in q and 1e-3 AU/day in p.
    let orbit = circle(&[5.2, 0.0], &[0.0, 7.54e-3], 1e-3);
    let with = |step_sizes: Vec<f64>| Diagnostic {
        step_sizes,
        ..Diagnostic::default()
    };
    let halved = |h: f64| (0..6).map(|k| h * 0.5f64.powi(k)).collect();
    let small = diagnose(&with(halved(0.5)), &jupiter(), &orbit).verdict;
    assert_eq!(small.kind, VerdictKind::Undecided, "{small}");
    let advice = small.advice()[0].clone();
    assert!(advice.contains("Take step sizes near "), "{advice}");
    let large = diagnose(&with(halved(700.0)), &jupiter(), &orbit).verdict;
    assert_eq!(large.kind, VerdictKind::NotSymplectic, "{large}");
}

#[test]
fn the_phase_advance_of_an_oscillation_is_its_frequency_times_the_step() {
    for scale in [1e-9, 1e-3, 1.0, 1e6] {
        // The exact flow in coordinates q → q scale, p → p / scale.
        let map = PerSample::new(1, move |h: f64, q: &mut [f64], p: &mut [f64]| {
            let (x, y) = (q[0] / scale, p[0] * scale);
            q[0] = scale * (h.cos() * x + h.sin() * y);
            p[0] = (h.cos() * y - h.sin() * x) / scale;
        });
        let h = 0.3;
        let diagnostic = Diagnostic {
            step_sizes: vec![h],
            loops: 2,
            ..Diagnostic::default()
        };
        let found = diagnose(&diagnostic, &map, &circle(&[scale], &[0.2 / scale], scale.min(1.0 / scale)));
        let theta = found.evidence.survey.phase_advance.expect("a number");
        assert!((theta / (2.0 * (h / 2.0).sin()) - 1.0).abs() < 1e-4, "{scale}: {theta}");
    }
}

#[test]
fn shears_have_no_phase_advance_in_any_number_of_degrees_of_freedom() {
    for dof in [1, 2, 5, 40] {
        let oscillator = HarmonicOscillator::new(vec![1.0; dof]).unwrap();
        let system = Arc::new(oscillator) as Arc<dyn Separable>;
        let theta = |map: &dyn symplint::TimeAdvance| {
            let diagnostic = Diagnostic {
                step_sizes: vec![0.5],
                loops: 1,
                jacobian: false,
                ..Diagnostic::default()
            };
            let phase_loop = circle(&vec![0.3; dof], &vec![0.1; dof], 1.0);
            let found = diagnose(&diagnostic, map, &phase_loop);
            found.evidence.survey.phase_advance.expect("a number")
        };
        let drift = PerSample::new(dof, |h, q: &mut [f64], p: &mut [f64]| {
            q.iter_mut().zip(p).for_each(|(q, p)| *q += h * *p);
        });
        assert!(theta(&drift) < 1e-4, "{dof}: {}", theta(&drift));
        let strang = build("strang", None, system).unwrap();
        // cos θ = 1 − h²/2.
        let expected = 2.0 * (0.5f64 * (1.0f64 - 0.125).acos()).sin();
        assert!((theta(&*strang) - expected).abs() < 1e-3, "{dof}");
    }
}

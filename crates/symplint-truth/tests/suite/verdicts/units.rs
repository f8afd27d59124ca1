//! Units, and steps too small for them: verdicts do not depend on the unit of time or length.

use std::sync::Arc;

use symplint::evidence::Check;
use symplint::map::balanced_radii;
use symplint::{Circle, Diagnostic, PerSample, VerdictKind};
use symplint_models::Separable;
use symplint_models::integrators::catalogue::build;
use symplint_models::systems::HarmonicOscillator;

use crate::verdicts::{circle, diagnose};

/// The Sun's attraction, in astronomical units and days.
const MU: f64 = 2.959_122_082_855_911e-4;

/// A planet in a plane: positions, then momenta per mass.
fn derivative(z: [f64; 4]) -> [f64; 4] {
    let r3 = (z[0] * z[0] + z[1] * z[1]).powf(1.5);
    [z[2], z[3], -MU * z[0] / r3, -MU * z[1] / r3]
}

/// z + h times the mean of slopes with these weights.
fn along(z: [f64; 4], h: f64, slopes: &[([f64; 4], f64)]) -> [f64; 4] {
    std::array::from_fn(|i| z[i] + h * slopes.iter().map(|(k, by)| k[i] * by).sum::<f64>())
}

fn by(
    method: impl Fn([f64; 4], f64) -> [f64; 4] + Send + Sync,
) -> PerSample<impl Fn(f64, &mut [f64], &mut [f64]) + Send + Sync> {
    PerSample::new(2, move |h, q: &mut [f64], p: &mut [f64]| {
        let z = method([q[0], q[1], p[0], p[1]], h);
        q.copy_from_slice(&z[..2]);
        p.copy_from_slice(&z[2..]);
    })
}

fn runge_kutta(z: [f64; 4], h: f64) -> [f64; 4] {
    let k1 = derivative(z);
    let k2 = derivative(along(z, h, &[(k1, 0.5)]));
    let k3 = derivative(along(z, h, &[(k2, 0.5)]));
    let k4 = derivative(along(z, h, &[(k3, 1.0)]));
    along(z, h / 6.0, &[(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)])
}

fn heun(z: [f64; 4], h: f64) -> [f64; 4] {
    let k1 = derivative(z);
    let k2 = derivative(along(z, h, &[(k1, 1.0)]));
    along(z, h, &[(k1, 0.5), (k2, 0.5)])
}

#[test]
fn steps_of_half_a_day_say_nothing_of_planets() {
    let halved = |h: f64| Diagnostic {
        step_sizes: (0..6).map(|k| h * 0.5f64.powi(k)).collect(),
        ..Diagnostic::default()
    };
    let jupiter = ([5.2, 0.0], [0.0, 7.54e-3]);
    let neptune = ([30.1, 0.0], [0.0, 3.14e-3]);
    let check = |method: fn([f64; 4], f64) -> [f64; 4], (q0, p0): ([f64; 2], [f64; 2])| {
        let map = by(method);
        let mut orbit = circle(&q0, &p0, 0.1);
        let mut h = 0.5;
        // Following the advice is enough for a verdict.
        for rounds in 0.. {
            let verdict = diagnose(&halved(h), &map, &orbit).verdict;
            if verdict.kind == VerdictKind::NotSymplectic {
                assert!(rounds > 0, "{verdict}");
                break;
            }
            assert!(rounds < 3, "h = {h}: {verdict}");
            assert_eq!(verdict.kind, VerdictKind::Undecided, "{verdict}");
            let advice = verdict.advice()[0].clone();
            if advice.contains("radius = \"auto\"") {
                let radii = balanced_radii(&map, &q0, &p0, h).unwrap();
                orbit = Circle::with_radii(q0.to_vec(), p0.to_vec(), radii.q, radii.p).unwrap();
            } else {
                h = (advice.split("near ").nth(1))
                    .and_then(|rest| rest.split(':').next()?.parse().ok())
                    .unwrap_or_else(|| panic!("{advice}"));
            }
        }
    };
    check(runge_kutta, jupiter);
    check(heun, neptune);
}

#[test]
fn the_phase_advance_of_an_oscillation_is_its_frequency_times_the_step() {
    let system = Arc::new(HarmonicOscillator::new(vec![1.0; 40]).unwrap()) as Arc<dyn Separable>;
    let strang = build("strang", None, system).unwrap();
    let diagnostic = Diagnostic {
        step_sizes: vec![0.5],
        jacobian: false,
        ..Diagnostic::default()
    };
    let found = diagnose(&diagnostic, &*strang, &circle(&[0.3; 40], &[0.1; 40], 1.0));
    // cos θ = 1 − h²/2.
    let exact = 2.0 * (0.5 * f64::acos(1.0 - 0.125)).sin();
    for found in &found.evidence.loops {
        let motion = found.steps[0].motion.expect("samples in memory");
        assert!((motion.phase_advance - exact).abs() < 0.05, "{motion:?}");
    }
    let given = found.evidence.loops[0].steps[0].motion.unwrap();
    assert!((given.phase_advance - exact).abs() < 1e-6, "{given:?}");
}

#[test]
fn step_sizes_and_radii_are_found_in_all_units() {
    // The same planet in units of 2^-20 and 2^20 times the length and the time.
    let mut found = Vec::new();
    for (length, time) in [
        (1.0, 1.0),
        (2f64.powi(-20), 2f64.powi(20)),
        (2f64.powi(20), 2f64.powi(-20)),
    ] {
        let map = PerSample::new(2, move |h, q: &mut [f64], p: &mut [f64]| {
            let speed = length / time;
            let z = [q[0] / length, q[1] / length, p[0] / speed, p[1] / speed];
            let z = runge_kutta(z, h / time);
            (q[0], q[1]) = (z[0] * length, z[1] * length);
            (p[0], p[1]) = (z[2] * speed, z[3] * speed);
        });
        let (q0, p0) = ([5.2 * length, 0.0], [0.0, 7.54e-3 * length / time]);
        let radii = balanced_radii(&map, &q0, &p0, time).unwrap();
        assert!(
            (radii.q[0] / (0.52 * length) - 1.0).abs() < 0.5,
            "{radii:?}"
        );
        let area: Vec<f64> = radii.q.iter().zip(&radii.p).map(|(q, p)| q * p).collect();
        let orbit = Circle::with_radii(q0.to_vec(), p0.to_vec(), radii.q, radii.p).unwrap();
        let diagnosis = diagnose(&Diagnostic::around(time), &map, &orbit);
        let made = &diagnosis.evidence.evaluations;
        assert!((8..100).contains(&made.of(Check::StepSizes)), "{made:?}");
        let largest = diagnosis.points()[0].step_size / time;
        assert!((200.0..1400.0).contains(&largest), "{largest}");
        assert_eq!(diagnosis.verdict.kind, VerdictKind::NotSymplectic);
        // The term of order 5 of the classical method vanishes here.
        assert_eq!(diagnosis.verdict.order, Some(6.0), "{}", diagnosis.verdict);
        found.push((largest, area[0] * time / length.powi(2)));
    }
    for other in &found[1..] {
        assert_eq!(other.0, found[0].0);
        assert!((other.1 / found[0].1 - 1.0).abs() < 1e-9);
    }
}

#[test]
fn the_largest_step_that_works_is_found() {
    // An oscillator whose solver fails beyond h = 0.3.
    let limited = PerSample::new(1, |h: f64, q: &mut [f64], p: &mut [f64]| {
        if h > 0.3 {
            return Err("no convergence");
        }
        p[0] -= h * q[0];
        q[0] += h * p[0];
        Ok(())
    });
    let on = circle(&[0.0], &[0.0], 1.0);
    for typical in [1e-6, 0.01, 0.2, 5.0, 1e5] {
        let diagnosis = diagnose(&Diagnostic::around(typical), &limited, &on);
        let largest = diagnosis.points()[0].step_size;
        assert!((0.07..0.3).contains(&largest), "{typical}: {largest}");
        assert_eq!(diagnosis.verdict.kind, VerdictKind::Symplectic, "{typical}");
    }
    let never = PerSample::new(1, |_, _: &mut [f64], _: &mut [f64]| Err::<(), _>("never"));
    let error = Diagnostic::around(1.0).run(&never, &on).unwrap_err();
    assert!(error.to_string().contains("never"), "{error}");
}

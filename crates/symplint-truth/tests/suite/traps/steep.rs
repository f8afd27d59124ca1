//! Maps that look broken and are continuous: steep kicks, roots, and noise that differs from call to call.

use std::f64::consts::TAU;
use std::sync::atomic::{AtomicU64, Ordering};

use symplint::breaks::find_break;
use symplint::rules::Piecewise;
use symplint::{Circle, Diagnostic, Ensemble, Error, PerSample, TimeAdvance, VerdictKind};

use super::circle;

/// A number in [0, 1) that a count scrambles (splitmix64).
fn scrambled(count: u64) -> f64 {
    let mut x = count.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

fn drift_kick_drift(force: impl Fn(f64) -> f64 + Send + Sync) -> impl TimeAdvance {
    PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        q[0] += 0.5 * h * p[0];
        p[0] += h * force(q[0]);
        q[0] += 0.5 * h * p[0];
    })
}

/// No break, by samples or by pieces, and no verdict of broken loops at any budget.
fn assert_continuous(map: &dyn TimeAdvance, on: &Circle, what: &str) {
    let mut samples = Ensemble::sample(on, 2048).unwrap();
    samples.advance(map, 0.5).unwrap();
    assert_eq!(find_break(map, on, 0.5, &samples).unwrap(), None, "{what}");
    let few = Piecewise {
        most_evaluations: 100_000,
        ..Piecewise::default()
    };
    let found = few.integrate(map, on, 0.5).unwrap();
    assert!(found.breaks.is_empty(), "{what}: {:?}", found.breaks);
    for budget in [20_000, 200_000, 1_000_000] {
        let diagnostic = Diagnostic {
            budget: Some(budget),
            ..Diagnostic::halving(-1, -8)
        };
        match diagnostic.run(map, on) {
            Ok(found) => {
                let kind = found.verdict.kind;
                assert_ne!(
                    kind,
                    VerdictKind::BrokenLoops,
                    "{what}, {budget}: {}",
                    found.verdict
                );
                assert_ne!(
                    kind,
                    VerdictKind::NotSymplectic,
                    "{what}, {budget}: {}",
                    found.verdict
                );
            }
            // Noise may be taken for a memory.
            Err(error) => assert!(matches!(error, Error::Memory { .. }), "{what}: {error}"),
        }
    }
}

#[test]
fn softened_gravity_is_not_broken() {
    // The difference of neighbouring states is a rounding of q times the slope, 1/ε³, and 1e-9 of the peak.
    for k in 0..8 {
        let soft = 10f64.powf(-9.0 + 0.83 * f64::from(k));
        let map = drift_kick_drift(move |q| -q / (q * q + soft * soft).powf(1.5));
        for (q0, p0) in [(0.0, 0.0), (0.21, -0.13)] {
            assert_continuous(&map, &circle(q0, p0), &format!("{soft:e} at {q0}"));
        }
    }
}

#[test]
fn steep_kicks_are_not_broken_far_from_the_origin_and_where_the_loop_turns() {
    for width in [1e-3, 1e-6] {
        for (q0, at) in [(0.0, 0.2), (1e3, 0.2), (0.0, 1.0)] {
            let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
                p[0] -= h * ((q[0] - q0 - at) / width).tanh();
                q[0] += h * p[0];
            });
            let on = Circle::new(vec![q0], vec![0.1], 1.0).unwrap();
            assert_continuous(&map, &on, &format!("{width:e} at {at} from {q0}"));
        }
    }
}

#[test]
fn roots_that_a_loop_grazes_are_not_breaks() {
    for depth in [0.3, 1e-3, 1e-6, 1e-10] {
        let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
            p[0] -= h * (q[0] + (q[0] - (1.0 - depth)).max(0.0).sqrt());
            q[0] += h * p[0];
        });
        assert_continuous(&map, &circle(0.0, 0.1), &format!("{depth:e}"));
    }
}

/// A pendulum, and an error of its momentum that the count of calls makes.
fn noisy(error: impl Fn(u64) -> f64 + Send + Sync) -> impl TimeAdvance {
    let calls = AtomicU64::new(0);
    PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        let count = calls.fetch_add(1, Ordering::Relaxed);
        p[0] -= h * q[0].sin();
        q[0] += h * p[0];
        p[0] += error(count);
    })
}

#[test]
fn noise_is_not_a_break() {
    // On one thread, so that the count is the same each time.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.unwrap().install(|| {
        for seed in 0..6 {
            let salt = seed << 40;
            let rare = noisy(move |count| 1e-10 * f64::from(scrambled(count ^ salt) < 1.0 / 300.0));
            let heavy = noisy(move |count| {
                let angle = 0.5 * TAU * (scrambled(count ^ salt) - 0.5);
                1e-13 * angle.tan().clamp(-1e3, 1e3)
            });
            for (map, what) in [(&rare as &dyn TimeAdvance, "rare"), (&heavy, "heavy")] {
                assert_continuous(map, &circle(0.05 * seed as f64, 0.2), what);
            }
        }
    });
}

#[test]
fn a_break_is_found_beside_noise_and_slopes() {
    for (size, noise, slope) in [(1e-9, 0.0, 1.0), (1e-3, 1e-9, 1.0), (1e-2, 0.0, 1e4)] {
        let calls = AtomicU64::new(0);
        let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
            let count = calls.fetch_add(1, Ordering::Relaxed);
            let jump = size * f64::from(q[0] > 0.3);
            p[0] -= h * (slope * (q[0] - 0.3) + jump);
            q[0] += h * p[0];
            p[0] += noise * (scrambled(count) - 0.5);
        });
        let found = Piecewise::default()
            .integrate(&map, &circle(0.0, 0.1), 0.5)
            .unwrap();
        let substantial = |x: f64| (x.abs() / (0.5 * size) - 1.0).abs() < 0.01;
        let breaks = &found.breaks;
        assert!(breaks.len() >= 2, "{size:e}: {breaks:?}");
        assert!(breaks.iter().all(|x| substantial(x.jump_p)), "{breaks:?}");
    }
}

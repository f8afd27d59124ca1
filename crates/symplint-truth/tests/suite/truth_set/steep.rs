//! Maps that look broken and are not: steep kicks, roots that a loop grazes, and noise on smooth maps.
//!
//! Kicks are continuous functions of the positions, the gradient of a potential, and drifts follow: ∮ F(q) dq = 0, so that every integral
//! is conserved. Noise is a function of the bits of the state, so that the map is the same each time: a few states are off, by
//! little.

use std::f64::consts::TAU;
use std::sync::Arc;

use symplint::Diagnostic;

use crate::truth_set::member::{
    Ellipses, Expected, Member, SYMPLECTIC, Step, Truth, halvings, map_of,
};
use crate::truth_set::random::Random;

pub const COUNT: usize = 240;

/// One state in this number is off, if few states are off.
const ONE_IN: usize = 300;

/// A number in [0, 1) that the bits of a state scramble (splitmix64).
fn scrambled(q: f64, p: f64, salt: u64) -> f64 {
    let mut x = q.to_bits() ^ p.to_bits().rotate_left(21) ^ salt;
    x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// A kick by this force between two halves of a drift.
fn drift_kick_drift(force: impl Fn(f64) -> f64 + Send + Sync + 'static) -> Step {
    Arc::new(move |h, q, p| {
        q[0] += 0.5 * h * p[0];
        p[0] += h * force(q[0]);
        q[0] += 0.5 * h * p[0];
    })
}

/// Fixed-point iterations of the implicit midpoint rule for a pendulum from a random start, until they move by less than `size`. Where they
/// stop depends on the state, so that their errors do not cancel: the map is not symplectic by a part of `size`.
fn random_start(size: f64, salt: u64) -> Step {
    Arc::new(move |h, q, p| {
        let start = 1e-2 * (scrambled(q[0], p[0], salt) - 0.5);
        let (mut q_middle, mut p_middle) = (q[0] + start, p[0] - 0.7 * start);
        for _ in 0..200 {
            let next_q = q[0] + 0.5 * h * p_middle;
            let next_p = p[0] - 0.5 * h * q_middle.sin();
            let moved = (next_q - q_middle).abs().max((next_p - p_middle).abs());
            (q_middle, p_middle) = (next_q, next_p);
            if moved < size {
                break;
            }
        }
        q[0] = 2.0 * q_middle - q[0];
        p[0] = 2.0 * p_middle - p[0];
    })
}

/// The relative change of the loop integral that a step makes and a symplectic one that is near to it does not: chord sums of both, whose
/// errors cancel.
fn change(on: &Ellipses, step: &Step, symplectic: &Step, h: f64) -> f64 {
    const SAMPLES: usize = 1 << 14;
    let sum = |step: &Step| {
        let states: Vec<[f64; 2]> = (0..SAMPLES)
            .map(|k| {
                let (sin, cos) = (TAU * k as f64 / SAMPLES as f64).sin_cos();
                let mut q = [on.q0[0] + on.radii_q[0] * sin];
                let mut p = [on.p0[0] + on.radii_p[0] * cos];
                step(h, &mut q, &mut p);
                [q[0], p[0]]
            })
            .collect();
        let next = |k: usize| states[(k + 1) % SAMPLES];
        let chord = |k: usize| 0.5 * (states[k][1] + next(k)[1]) * (next(k)[0] - states[k][0]);
        (0..SAMPLES).map(chord).sum::<f64>()
    };
    (sum(step) - sum(symplectic)) / on.integral()
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(12, index);
    let centred = random.chance(0.5);
    let offset = |random: &mut Random| {
        if centred {
            0.0
        } else {
            random.between(-0.3, 0.3)
        }
    };
    let on = Ellipses {
        q0: vec![offset(random)],
        p0: vec![offset(random)],
        radii_q: vec![1.0],
        radii_p: vec![random.between(0.7, 1.4)],
    };
    let centre = on.q0[0] + random.between(-0.95, 0.95);
    let salt = random.seed();
    let size = random.log_between(1e-13, 1e-9);
    let soft = random.log_between(1e-9, 1e-3);
    let width = random.log_between(1e-9, 1e-1);
    let h = random.between(0.3, 0.6);
    let strength = random.sign() * random.between(0.3, 1.5);
    // Noise of this size, if the mean over all samples is far below it.
    let noisy = |size: f64| Expected::Symplectic {
        most_digits: 3.0 - size.log10(),
    };
    let (what, step, expected): (String, Step, Expected) = match index % 8 {
        0 => (
            format!("gravity, softened by {soft:.0e}"),
            drift_kick_drift(move |q| -q / (q * q + soft * soft).powf(1.5)),
            SYMPLECTIC,
        ),
        1 => (
            format!("tanh of width {width:.0e}"),
            drift_kick_drift(move |q| -strength * ((q - centre) / width).tanh()),
            SYMPLECTIC,
        ),
        2 => (
            format!("logistic of width {width:.0e}"),
            drift_kick_drift(move |q| -q.sin() - strength / (1.0 + ((centre - q) / width).exp())),
            SYMPLECTIC,
        ),
        3 => (
            "root".to_owned(),
            drift_kick_drift(move |q| -q - strength * (q - centre).max(0.0).sqrt()),
            SYMPLECTIC,
        ),
        4 => {
            // The loop turns just beyond the place where the root begins.
            let depth = random.log_between(1e-12, 1e-2);
            let top = on.q0[0] + 1.0 - depth;
            let step: Step = Arc::new(move |h, q, p| {
                p[0] -= h * (q[0].sin() + strength * (q[0] - top).max(0.0).sqrt());
                q[0] += h * p[0];
            });
            (
                format!("root that is grazed by {depth:.0e}"),
                step,
                SYMPLECTIC,
            )
        }
        5 => {
            let step: Step = Arc::new(move |h, q, p| {
                let off = scrambled(q[0], p[0], salt) < 1.0 / ONE_IN as f64;
                p[0] -= h * q[0].sin();
                q[0] += h * p[0];
                p[0] += f64::from(u8::from(off)) * size;
            });
            (
                format!("1 state in {ONE_IN} off by {size:.0e}"),
                step,
                noisy(size),
            )
        }
        6 => {
            let step: Step = Arc::new(move |h, q, p| {
                // Cauchy's distribution, up to a thousand times its scale.
                let angle = std::f64::consts::PI * (scrambled(q[0], p[0], salt) - 0.5);
                let noise = (0.01 * size) * angle.tan().clamp(-1e3, 1e3);
                p[0] -= h * q[0].sin();
                q[0] += h * p[0];
                p[0] += noise;
            });
            (
                format!("heavy tails of {:.0e}", 0.01 * size),
                step,
                noisy(0.01 * size),
            )
        }
        _ => {
            let step = random_start(size, salt);
            let defect = change(&on, &step, &random_start(0.0, salt), h);
            let expected = Expected::Hidden(defect.abs());
            (
                format!("random start, tolerance {size:.0e}"),
                step,
                expected,
            )
        }
    };
    let budget = [Some(20_000), Some(200_000), None][index / 8 % 3];
    let label = match budget {
        Some(budget) => format!("{what}, budget {budget}"),
        None => what,
    };
    let diagnostic = Diagnostic {
        budget,
        ..halvings(h, 8)
    };
    let truth = Truth {
        one_in: (index % 8 == 5).then_some(ONE_IN),
        ..Truth::of(expected)
    };
    Member::new(label, map_of(1, step), on.circle(), diagnostic, truth)
}

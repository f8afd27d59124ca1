//! Kicks that jump or have kinks at known positions, then a drift.
//!
//! A kick p += h J where q > θ breaks the loop where q = θ, along p, which carries no p dq. The drift q += h p/m adds
//! h/m ∮ p dp: between the breaks that is −(h/2m) Σ (p₊² − p₋²), and the chords give it back. On an ellipse of radii a
//! and b, u = (θ − q₀)/a, both breaks together are −2 h² J b √(1 − u²)/m.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::truth_set::member::{
    Ellipses, Expected, KnownBreak, Member, SYMPLECTIC, Step, Truth, halvings, map_of,
};
use crate::truth_set::random::Random;

pub const COUNT: usize = 320;

/// A position at which the force jumps, in the first degree of freedom.
#[derive(Clone, Copy)]
struct Threshold {
    theta: f64,
    jump: f64,
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(8, index);
    let dof = random.whole(1, 3);
    let on = Ellipses {
        q0: random.row(dof, -0.5, 0.5),
        p0: random.row(dof, -0.5, 0.5),
        radii_q: random.row(dof, 0.5, 1.2),
        radii_p: random.row(dof, 0.5, 1.2),
    };
    let h = random.between(0.2, 0.8);
    let mass = random.between(0.5, 2.0);
    let stiffness = random.row(dof, 0.3, 1.0);
    let kinks = index % 4 == 3;
    let factor = match random.chance(0.4) {
        true => 1.0 - random.between(0.01, 0.2),
        false => 1.0,
    };
    let count = random.whole(1, 4);
    let jumps: Vec<Threshold> = (0..count)
        .map(|k| {
            // Each in its part of (−0.95, 0.95), so that none is another one.
            let width = 1.9 / count as f64;
            let u = -0.95 + width * (k as f64 + random.between(0.1, 0.9));
            Threshold {
                theta: on.q0[0] + on.radii_q[0] * u,
                jump: random.sign() * random.log_between(1e-4, 0.5),
            }
        })
        .collect();
    let step: Step = {
        let jumps = jumps.clone();
        Arc::new(move |h, q, p| {
            for i in 0..q.len() {
                p[i] = factor * p[i] - h * stiffness[i] * q[i].sin();
            }
            for at in &jumps {
                if kinks {
                    p[0] += h * at.jump * (q[0] - at.theta).abs();
                } else if q[0] > at.theta {
                    p[0] += h * at.jump;
                }
            }
            for (q, p) in q.iter_mut().zip(p) {
                *q += h * *p / mass;
            }
        })
    };
    let (radius_q, radius_p, q0) = (on.radii_q[0], on.radii_p[0], on.q0[0]);
    let cosine = move |at: &Threshold| (1.0 - ((at.theta - q0) / radius_q).powi(2)).sqrt();
    let initial = on.integral();
    let truth = match kinks {
        true if factor < 1.0 => {
            Truth::of(Expected::NotSymplectic).with_change(move |_| factor - 1.0)
        }
        true => Truth::of(SYMPLECTIC).with_change(|_| 0.0),
        false => {
            let sum: f64 = jumps.iter().map(|at| at.jump * cosine(at)).sum();
            let law = move |h: f64| {
                factor - 1.0 - 2.0 * factor * h * h * radius_p * sum / (mass * initial)
            };
            let of_breaks = jumps.iter().flat_map(|at| {
                let s = ((at.theta - q0) / radius_q).asin() / TAU;
                // The rounding of q and of θ, over dq/ds, and that of s.
                let size = at.theta.abs() + q0.abs() + radius_q;
                let rounding = f64::EPSILON * (1.0 + size / (TAU * radius_q * cosine(at)));
                [s, 0.5 - s].map(|s| KnownBreak {
                    s: s.rem_euclid(1.0),
                    rounding,
                })
            });
            Truth {
                change: Some(Arc::new(law)),
                breaks: Some(of_breaks.collect()),
                ..Truth::of(Expected::Broken {
                    closed: Some(factor == 1.0),
                })
            }
        }
    };
    let what = if kinks { "kinks" } else { "jumps" };
    let label = format!("{count} {what} d = {dof}, p × {factor:.3}");
    let truth = Truth {
        initial: Some(initial),
        ..truth
    };
    Member::new(label, map_of(dof, step), on.circle(), halvings(h, 6), truth)
}

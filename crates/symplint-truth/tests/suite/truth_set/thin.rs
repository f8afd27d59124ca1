//! Maps that are no steps in time: kicks, point transformations, drifts, rotations, turns of a ring. They are called with step
//! sizes, which scale their strength or are ignored, or without any.

use std::sync::Arc;

use symplint::Diagnostic;

use crate::truth_set::member::{Ellipses, Expected, Member, SYMPLECTIC, Step, Truth, map_of};
use crate::truth_set::random::Random;

pub const COUNT: usize = 320;

/// The average of (q0 + x)⁴ over a disc of radius r.
fn mean_of_fourth_power(q0: f64, r: f64) -> f64 {
    q0.powi(4) + 1.5 * (q0 * r).powi(2) + r.powi(4) / 8.0
}

/// A map of strength h, and in how many degrees of freedom.
fn map(random: &mut Random, kind: usize, size: f64) -> (&'static str, usize, Step) {
    // How far it moves states, in units of the loop.
    let strength = random.log_between(1e-8, 0.3);
    let dof = random.whole(1, 3);
    match kind {
        0 => {
            let by = random.row(2 * dof, -1.0, 1.0);
            let step: Step = Arc::new(move |h, q, p| {
                for i in 0..dof {
                    q[i] += h * size * by[i];
                    p[i] += h * size * by[dof + i];
                }
            });
            ("translation", dof, step)
        }
        1 => {
            // (x + iy)^n, a potential that is harmonic.
            let n = random.whole(1, 5) as i32;
            let k = strength / (n as f64 * size.powi(n - 1));
            let step: Step = Arc::new(move |h, q, p| {
                let (r, angle) = (q[0].hypot(q[1]).powi(n), f64::from(n) * q[1].atan2(q[0]));
                p[0] -= h * k * r * angle.cos();
                p[1] += h * k * r * angle.sin();
            });
            ("multipole", 2, step)
        }
        2 => {
            let a = strength / (3.0 * size * size);
            let step: Step = Arc::new(move |h, q, p| {
                for i in 0..dof {
                    p[i] /= 1.0 + 3.0 * h * a * q[i] * q[i];
                    q[i] += h * a * q[i].powi(3);
                }
            });
            ("edge", dof, step)
        }
        3 => {
            // The generating function q·P + a q0² q1 P0: an edge that couples two planes.
            let a = strength / (size * size);
            let step: Step = Arc::new(move |h, q, p| {
                let (x, y) = (q[0], q[1]);
                let new = p[0] / (1.0 + 2.0 * h * a * x * y);
                p[1] -= h * a * x * x * new;
                p[0] = new;
                q[0] += h * a * x * x * y;
            });
            ("edge of two planes", 2, step)
        }
        4 => {
            let angle = random.sign() * strength.min(0.1);
            let step: Step = Arc::new(move |h, q, p| {
                let (t, pz) = ((h * angle).tan(), (1.0 - p[0] * p[0]).sqrt());
                q[0] /= (h * angle).cos() * (1.0 - t * p[0] / pz);
                p[0] = p[0] * (h * angle).cos() + (h * angle).sin() * pz;
            });
            ("tilt of the frame", 1, step)
        }
        5 => {
            let (length, beta) = (random.log_between(1e-3, 10.0), random.between(0.3, 0.999));
            let rounds = random.chance(0.5);
            let step: Step = Arc::new(move |h, q, p| {
                let energy = 1.0 + beta * beta * p[2];
                let total = (energy * energy - (1.0 - beta * beta)) / (beta * beta);
                let along = (total - p[0] * p[0] - p[1] * p[1]).sqrt();
                q[0] += h * length * p[0] / along;
                q[1] += h * length * p[1] / along;
                q[2] += h * length * (1.0 - energy / along);
                if rounds {
                    // To slopes, energies and other units, and back.
                    let (slope_x, slope_y) = (1e3 * p[0] / along, 1e3 * p[1] / along);
                    let (x, y) = (1e-3 * slope_x, 1e-3 * slope_y);
                    let back = total.sqrt() / (1.0 + x * x + y * y).sqrt();
                    p[0] = x * back;
                    p[1] = y * back;
                    let gamma = total * beta * beta + (1.0 - beta * beta);
                    p[2] = (gamma.sqrt() - 1.0) / (beta * beta);
                }
            });
            ("exact drift", 3, step)
        }
        6 => {
            let (k, phase) = (
                random.log_between(0.1, 10.0) / size,
                random.between(0.0, 6.0),
            );
            let step: Step = Arc::new(move |h, q, p| {
                p[0] += h * strength / k * (k * q[0] + phase).sin();
            });
            ("cavity", 1, step)
        }
        7 => {
            let angle = random.sign() * strength;
            let step: Step = Arc::new(move |h, q, p| {
                let (sin, cos) = (h * angle).sin_cos();
                for x in [q, p] {
                    (x[0], x[1]) = (cos * x[0] + sin * x[1], cos * x[1] - sin * x[0]);
                }
            });
            ("roll of the frame", 2, step)
        }
        8 => {
            let step: Step = Arc::new(move |h, q, p| {
                let scale = (h * strength).exp();
                for i in 0..dof {
                    q[i] *= scale;
                    p[i] /= scale;
                }
            });
            ("change of units", dof, step)
        }
        _ => {
            // One turn: a cavity, then the slip of the path.
            let tune = random.log_between(1e-3, 0.1);
            let step: Step = Arc::new(move |h, q, p| {
                for i in 0..dof {
                    p[i] -= h * tune * size * (q[i] / size).sin();
                    q[i] += tune * p[i];
                }
            });
            ("one turn", dof, step)
        }
    }
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(41, index);
    let size = random.log_between(1e-4, 0.1);
    let (name, dof, step) = map(random, index / 4 % 10, size);
    let on = Ellipses {
        q0: random.row(dof, -0.3 * size, 0.3 * size),
        p0: random.row(dof, -0.3 * size, 0.3 * size),
        radii_q: random.row(dof, 0.5 * size, size),
        radii_p: random.row(dof, 0.5 * size, size),
    };
    let is_ring = name == "one turn";
    let (mode, diagnostic) = match index % 4 {
        0 | 1 => ("no step size", Diagnostic::without_step_size()),
        2 => ("strength h", steps(&[1.0, 0.5, 0.25])),
        _ if is_ring || random.chance(0.5) => ("h ignored", steps(&[1.0])),
        _ => ("strength h", steps(&[0.25, 0.125])),
    };
    let step: Step = match mode {
        "strength h" => step,
        _ => Arc::new(move |_, q, p| step(1.0, q, p)),
    };
    let is_scaled = mode == "strength h";
    let strength = move |h: f64| if is_scaled { h } else { 1.0 };
    let (fault, step, truth): (String, Step, Truth) = match index / 40 % 2 {
        0 => (
            String::new(),
            step,
            Truth::of(SYMPLECTIC).with_change(|_| 0.0),
        ),
        _ => {
            let lost = random.log_between(1e-9, 1e-2);
            let damped: Step = Arc::new(move |h, q, p| {
                step(h, q, p);
                p.iter_mut().for_each(|p| *p *= 1.0 - lost * strength(h));
            });
            let largest = if is_scaled {
                diagnostic.step_sizes[0]
            } else {
                1.0
            };
            let truth = Truth::of(Expected::SmallDefect(lost * largest));
            let truth = truth.with_change(move |h| -lost * strength(h));
            (format!(", p × (1 − {lost:.0e})"), damped, truth)
        }
    };
    let (fault, step, truth) = match name {
        // An edge of which a term is missing.
        "edge" if index / 40 % 4 == 3 => wrong_edge(random, size, &on, &diagnostic, strength),
        _ => (fault, step, truth),
    };
    let truth = Truth {
        initial: Some(on.integral()),
        ..truth
    };
    let label = format!("{name} d = {dof}, size {size:.0e}, {mode}{fault}");
    Member::new(label, map_of(dof, step), on.circle(), diagnostic, truth)
}

fn steps(sizes: &[f64]) -> Diagnostic {
    Diagnostic {
        step_sizes: sizes.to_vec(),
        ..Diagnostic::default()
    }
}

/// p (1 − f') instead of p / (1 + f'): the determinant is 1 − f'².
fn wrong_edge(
    random: &mut Random,
    size: f64,
    on: &Ellipses,
    diagnostic: &Diagnostic,
    strength: impl Fn(f64) -> f64 + Copy + Send + Sync + 'static,
) -> (String, Step, Truth) {
    let a = random.log_between(1e-4, 1e-1) / (3.0 * size * size);
    let step: Step = Arc::new(move |h, q, p| {
        for i in 0..q.len() {
            p[i] *= 1.0 - 3.0 * strength(h) * a * q[i] * q[i];
            q[i] += strength(h) * a * q[i].powi(3);
        }
    });
    let area: f64 = (0..on.q0.len()).map(|i| on.area(i)).sum();
    let of_plane = |i: usize| on.area(i) * mean_of_fourth_power(on.q0[i], on.radii_q[i]);
    let mean = (0..on.q0.len()).map(of_plane).sum::<f64>() / area;
    let change = move |h: f64| -9.0 * (strength(h) * a).powi(2) * mean;
    let largest = match diagnostic.has_step_size {
        true => diagnostic.step_sizes[0],
        false => 1.0,
    };
    let mut truth = Truth::of(Expected::SmallDefect(change(largest).abs()));
    truth.change = Some(Arc::new(change));
    (", a term missing".into(), step, truth)
}

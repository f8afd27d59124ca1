//! Steps: splittings, which are symplectic, and explicit Runge–Kutta methods, which are not.

use std::sync::Arc;

use crate::truth_set::member::Step;
use crate::truth_set::systems::{MAX_DOF, System};

/// A composition of Strang steps, by its weights. Order 6: Yoshida 1990, solution A.
pub const SPLITTINGS: [(&str, &[f64]); 4] = [
    ("leapfrog", &[1.0]),
    ("yoshida4", &[YOSHIDA4, 1.0 - 2.0 * YOSHIDA4, YOSHIDA4]),
    (
        "suzuki4",
        &[SUZUKI4, SUZUKI4, 1.0 - 4.0 * SUZUKI4, SUZUKI4, SUZUKI4],
    ),
    ("yoshida6", &YOSHIDA6),
];

/// 1 / (2 − 2^{1/3}).
const YOSHIDA4: f64 = 1.351_207_191_959_657_8;
/// 1 / (4 − 4^{1/3}).
const SUZUKI4: f64 = 0.414_490_771_794_375_7;
const YOSHIDA6: [f64; 7] = [
    0.784_513_610_477_56,
    0.235_573_213_359_357,
    -1.177_679_984_178_87,
    1.315_186_320_683_906,
    -1.177_679_984_178_87,
    0.235_573_213_359_357,
    0.784_513_610_477_56,
];

/// An explicit Runge–Kutta method, with the order of its defect in one and in several degrees of freedom.
pub struct Tableau {
    pub name: &'static str,
    /// Rows of A below the diagonal.
    a: &'static [&'static [f64]],
    b: &'static [f64],
    orders: [&'static [f64]; 2],
}

/// HLW, section II.1.1; the last is Butcher's of order 5 (HNW, section II.5). Orders of the defect: one more than that of
/// the method, but for Heun's, whose remainder is −h²/4 (dk₁ − dk₂)∧(dk₁ − dk₂), and the classical one. Its h⁵ term is
/// a sum of dq_i∧dq_j: it vanishes in one degree of freedom, and on loops whose planes are in phase.
/// On other loops it may be so small compared with h⁶ that doubles do not show it: both orders are right there.
pub const TABLEAUS: [Tableau; 6] = [
    Tableau {
        name: "euler",
        a: &[&[]],
        b: &[1.0],
        orders: [&[2.0], &[2.0]],
    },
    Tableau {
        name: "midpoint",
        a: &[&[], &[0.5]],
        b: &[0.0, 1.0],
        orders: [&[3.0], &[3.0]],
    },
    Tableau {
        name: "heun",
        a: &[&[], &[1.0]],
        b: &[0.5, 0.5],
        orders: [&[4.0], &[4.0]],
    },
    Tableau {
        name: "kutta3",
        a: &[&[], &[0.5], &[-1.0, 2.0]],
        b: &[1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0],
        orders: [&[4.0], &[4.0]],
    },
    Tableau {
        name: "rk4",
        a: &[&[], &[0.5], &[0.0, 0.5], &[0.0, 0.0, 1.0]],
        b: &[1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0],
        orders: [&[6.0], &[5.0, 6.0]],
    },
    Tableau {
        name: "butcher5",
        a: &[
            &[],
            &[0.25],
            &[0.125, 0.125],
            &[0.0, -0.5, 1.0],
            &[3.0 / 16.0, 0.0, 0.0, 9.0 / 16.0],
            &[-3.0 / 7.0, 2.0 / 7.0, 12.0 / 7.0, -12.0 / 7.0, 8.0 / 7.0],
        ],
        b: &[
            7.0 / 90.0,
            0.0,
            32.0 / 90.0,
            12.0 / 90.0,
            32.0 / 90.0,
            7.0 / 90.0,
        ],
        orders: [&[6.0], &[6.0]],
    },
];

impl Tableau {
    /// The orders of the defect.
    pub fn orders(&self, dof: usize) -> &'static [f64] {
        self.orders[usize::from(dof > 1)]
    }
}

/// The method of this name.
pub fn tableau(name: &str) -> &'static Tableau {
    TABLEAUS.iter().find(|method| method.name == name).unwrap()
}

fn drift(system: &System, h: f64, q: &mut [f64], p: &[f64]) {
    for ((q, p), m) in q.iter_mut().zip(p).zip(&system.masses) {
        *q += h * p / m;
    }
}

fn kick(system: &System, h: f64, q: &[f64], p: &mut [f64]) {
    let mut force = [0.0; MAX_DOF];
    let force = &mut force[..q.len()];
    (system.force)(q, force);
    for (p, f) in p.iter_mut().zip(force) {
        *p += h * *f;
    }
}

/// A composition of Strang steps: drifts outside, or kicks.
pub fn splitting(system: &System, weights: &'static [f64], kick_first: bool) -> Step {
    let system = system.clone();
    Arc::new(move |h, q, p| {
        for w in weights {
            let h = w * h;
            if kick_first {
                kick(&system, 0.5 * h, q, p);
                drift(&system, h, q, p);
                kick(&system, 0.5 * h, q, p);
            } else {
                drift(&system, 0.5 * h, q, p);
                kick(&system, h, q, p);
                drift(&system, 0.5 * h, q, p);
            }
        }
    })
}

/// Leapfrog.
pub fn leapfrog(system: &System) -> Step {
    splitting(system, SPLITTINGS[0].1, true)
}

/// A step of a Runge–Kutta method.
pub fn runge_kutta(system: &System, method: &'static Tableau) -> Step {
    let system = system.clone();
    Arc::new(move |h, q, p| {
        let dof = q.len();
        let mut rates = [[[0.0; MAX_DOF]; 2]; 6];
        for (stage, row) in method.a.iter().enumerate() {
            let (mut x, mut y) = ([0.0; MAX_DOF], [0.0; MAX_DOF]);
            for i in 0..dof {
                let sum = |c: usize| -> f64 {
                    row.iter().zip(&rates).map(|(a, rate)| a * rate[c][i]).sum()
                };
                (x[i], y[i]) = (q[i] + h * sum(0), p[i] + h * sum(1));
            }
            for i in 0..dof {
                rates[stage][0][i] = y[i] / system.masses[i];
            }
            (system.force)(&x[..dof], &mut rates[stage][1][..dof]);
        }
        for i in 0..dof {
            for (b, rate) in method.b.iter().zip(&rates) {
                q[i] += h * b * rate[0][i];
                p[i] += h * b * rate[1][i];
            }
        }
    })
}

/// Momenta multiplied by `factor`, then the step: the integral of every loop is multiplied by it.
pub fn damped(step: Step, factor: f64) -> Step {
    Arc::new(move |h, q, p| {
        for p in p.iter_mut() {
            *p *= factor;
        }
        step(h, q, p);
    })
}

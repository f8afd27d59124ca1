//! Random separable Hamiltonians H = Σ p²/2m + V(q).

use std::sync::Arc;

use crate::truth_set::member::Ellipses;
use crate::truth_set::random::Random;

/// Degrees of freedom at most: states of steps stand on the stack.
pub const MAX_DOF: usize = 12;

/// −∇V(q).
pub type Force = Arc<dyn Fn(&[f64], &mut [f64]) + Send + Sync>;

/// A Hamiltonian, and a loop on which its steps work.
#[derive(Clone)]
pub struct System {
    pub name: &'static str,
    pub masses: Vec<f64>,
    pub force: Force,
    /// The fastest frequency near the loop, about.
    pub omega: f64,
    pub on: Ellipses,
}

impl System {
    /// Degrees of freedom.
    pub fn dof(&self) -> usize {
        self.masses.len()
    }
}

/// A pendulum, Hénon–Heiles, a Kepler orbit, or coupled quartic oscillators.
pub fn any(random: &mut Random) -> System {
    match random.whole(0, 4) {
        0 => pendulum(random),
        1 => henon_heiles(random),
        2 => kepler(random),
        _ => {
            let dof = random.whole(1, 10);
            chain(random, dof)
        }
    }
}

/// k (1 − cos q) + k' sin 2q.
pub fn pendulum(random: &mut Random) -> System {
    let (k, second) = (random.log_between(0.3, 3.0), random.between(-0.2, 0.2));
    let radius = random.between(0.3, 0.8);
    System {
        name: "pendulum",
        masses: vec![1.0],
        force: Arc::new(move |q, f| f[0] = -k * q[0].sin() - second * (2.0 * q[0]).cos()),
        omega: k.sqrt(),
        on: Ellipses {
            q0: vec![random.between(-1.0, 1.0)],
            p0: vec![random.between(0.2, 0.7) * random.sign()],
            radii_q: vec![radius],
            radii_p: vec![radius * k.sqrt()],
        },
    }
}

/// Hénon–Heiles with a random cubic term.
pub fn henon_heiles(random: &mut Random) -> System {
    let c = random.between(0.5, 1.2);
    System {
        name: "Hénon–Heiles",
        masses: vec![1.0; 2],
        force: Arc::new(move |q, f| {
            f[0] = -q[0] - 2.0 * c * q[0] * q[1];
            f[1] = -q[1] - c * (q[0] * q[0] - q[1] * q[1]);
        }),
        omega: 1.0,
        on: Ellipses {
            q0: random.row(2, -0.15, 0.15),
            p0: random.row(2, -0.15, 0.15),
            radii_q: random.row(2, 0.1, 0.2),
            radii_p: random.row(2, 0.1, 0.2),
        },
    }
}

/// An orbit round a fixed centre at distance 1, eccentricity up to 0.2.
pub fn kepler(random: &mut Random) -> System {
    let mass = random.log_between(0.3, 3.0);
    let speed = mass * random.between(0.9, 1.1);
    System {
        name: "Kepler",
        masses: vec![mass; 2],
        force: Arc::new(move |q, f| {
            let r2 = q[0] * q[0] + q[1] * q[1];
            let r3 = r2 * r2.sqrt();
            (f[0], f[1]) = (-mass * q[0] / r3, -mass * q[1] / r3);
        }),
        omega: 1.0,
        on: Ellipses {
            q0: vec![1.0, random.between(-0.1, 0.1)],
            p0: vec![mass * random.between(-0.1, 0.1), speed],
            radii_q: random.row(2, 0.05, 0.1),
            radii_p: random.row(2, 0.05 * mass, 0.1 * mass),
        },
    }
}

/// Quartic and cubic oscillators, neighbours on springs.
pub fn chain(random: &mut Random, dof: usize) -> System {
    let masses = random.row(dof, 0.5, 2.0);
    let k = random.row(dof, 0.3, 1.0);
    let cubic = random.row(dof, -0.2, 0.2);
    let quartic = random.row(dof, 0.05, 0.4);
    let spring = random.between(0.05, 0.4);
    // Each oscillator has m ω² of k + 2 springs + what the anharmonic terms add on the loop.
    let omega = (0..dof)
        .map(|i| ((k[i] + 2.0 * spring + 0.4 + 3.0 * quartic[i]) / masses[i]).sqrt())
        .fold(0.0, f64::max);
    let force = Arc::new(move |q: &[f64], f: &mut [f64]| {
        for i in 0..dof {
            let x = q[i];
            f[i] = -k[i] * x - cubic[i] * x * x - quartic[i] * x * x * x;
            if i > 0 {
                f[i] -= spring * (x - q[i - 1]);
            }
            if i + 1 < dof {
                f[i] -= spring * (x - q[i + 1]);
            }
        }
    });
    let on = Ellipses {
        q0: random.row(dof, -0.4, 0.4),
        p0: random.row(dof, -0.4, 0.4),
        radii_q: random.row(dof, 0.3, 0.6),
        radii_p: random.row(dof, 0.3, 0.6),
    };
    System {
        name: "oscillators",
        masses,
        force,
        omega,
        on,
    }
}

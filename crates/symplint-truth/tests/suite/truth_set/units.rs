//! Maps in awkward units: canonical scalings of every degree of freedom, and a unit of time.

use std::sync::Arc;

use symplint::Diagnostic;
use symplint::map::balanced_radii;

use crate::truth_set::member::{
    Ellipses, Expected, Member, SYMPLECTIC, Step, Truth, halvings, map_of,
};
use crate::truth_set::methods::{SPLITTINGS, damped, runge_kutta, splitting, tableau};
use crate::truth_set::random::Random;
use crate::truth_set::systems::{self, MAX_DOF, System};

pub const COUNT: usize = 600;

/// q is `a[i]` times as large and measured from a point `origin` units away, p is `b[i]` times as large, a step takes
/// `time` times as long. All `a[i] b[i]` are the same.
#[derive(Clone)]
struct Units {
    a: Vec<f64>,
    b: Vec<f64>,
    time: f64,
    origin: f64,
}

impl Units {
    /// One unit for all positions, or one for each, within a factor of 1e4.
    fn random(random: &mut Random, dof: usize) -> Self {
        let (length, momentum) = (random.log_between(1e-9, 1e9), random.log_between(1e-9, 1e9));
        let apart = random.chance(0.4);
        let a: Vec<f64> = (0..dof)
            .map(|_| match apart {
                true => length * random.log_between(1e-2, 1e2),
                false => length,
            })
            .collect();
        Units {
            b: a.iter().map(|a| length * momentum / a).collect(),
            a,
            time: random.log_between(1e-12, 1e12),
            origin: match random.chance(0.2) {
                true => random.sign() * random.log_between(1.0, 1e5),
                false => 0.0,
            },
        }
    }

    fn step(&self, step: Step) -> Step {
        let Units { a, b, time, origin } = self.clone();
        Arc::new(move |h, q, p| {
            let dof = q.len();
            let (mut x, mut y) = ([0.0; MAX_DOF], [0.0; MAX_DOF]);
            for i in 0..dof {
                (x[i], y[i]) = (q[i] / a[i] - origin, p[i] / b[i]);
            }
            step(h / time, &mut x[..dof], &mut y[..dof]);
            for i in 0..dof {
                (q[i], p[i]) = (a[i] * (x[i] + origin), b[i] * y[i]);
            }
        })
    }

    fn ellipses(&self, on: &Ellipses) -> Ellipses {
        let times = |x: &[f64], unit: &[f64]| x.iter().zip(unit).map(|(x, u)| x * u).collect();
        let q0: Vec<f64> = on.q0.iter().map(|q| q + self.origin).collect();
        Ellipses {
            q0: times(&q0, &self.a),
            p0: times(&on.p0, &self.b),
            radii_q: times(&on.radii_q, &self.a),
            radii_p: times(&on.radii_p, &self.b),
        }
    }
}

/// A step, and what is known of it.
fn method(random: &mut Random, system: &System) -> (String, Step, Truth) {
    if random.chance(0.5) {
        let (name, weights) = random.pick(&SPLITTINGS);
        let step = splitting(system, weights, random.chance(0.5));
        let truth = Truth::of(SYMPLECTIC).with_change(|_| 0.0);
        return (name.into(), step, truth);
    }
    let truth = Truth::of(Expected::NotSymplectic);
    if random.chance(0.4) {
        let factor = 1.0 - random.log_between(1e-5, 0.1);
        let step = damped(splitting(system, SPLITTINGS[0].1, true), factor);
        let name = format!("leapfrog, p × {factor:.6}");
        return (name, step, truth.with_change(move |_| factor - 1.0));
    }
    let name = random.pick(&["euler", "midpoint", "heun", "kutta3", "rk4"]);
    let method = tableau(name);
    (
        name.into(),
        runge_kutta(system, method),
        truth.with_orders(method.orders(system.dof())),
    )
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(1, index);
    let system = systems::any(random);
    let units = Units::random(random, system.dof());
    let (name, step, truth) = method(random, &system);
    let map = map_of(system.dof(), units.step(step));
    // The angle by which a step advances the fastest motion, in radians.
    let phase = random.log_between(0.3, 1.0);
    let h = phase / system.omega * units.time;
    let (kind, diagnostic) = match random.unit() {
        ..0.05 => {
            let far = random.log_between(1e-5, 1e-3);
            (format!("hω = {:.0e}", phase * far), halvings(h * far, 10))
        }
        ..0.2 => {
            let typical = h * random.log_between(1e-2, 10.0);
            ("steps looked for".into(), Diagnostic::around(typical))
        }
        _ => (format!("hω = {phase:.2}"), halvings(h, 10)),
    };
    let mut on = units.ellipses(&system.on);
    let mut radii = "";
    if random.chance(0.25)
        && let Ok(found) = balanced_radii(&map, &on.q0, &on.p0, h)
    {
        radii = ", balanced radii";
        (on.radii_q, on.radii_p) = (found.q, found.p);
    }
    let label = format!(
        "{} d = {}, {name}, {kind}{radii}",
        system.name,
        system.dof()
    );
    let far = if units.origin == 0.0 {
        "".into()
    } else {
        format!(", origin at {:.0e}", units.origin)
    };
    let label = format!("{label}{far}");
    let truth = Truth {
        initial: Some(on.integral()),
        ..truth
    };
    Member::new(label, map, on.circle(), diagnostic, truth)
}

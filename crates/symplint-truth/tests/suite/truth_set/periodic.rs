//! Positions on circles: periods are stated, and positions are wrapped after a step.

use std::sync::Arc;

use symplint::{Coordinates, PerSample, TimeAdvance};

use crate::truth_set::member::{Ellipses, Expected, Member, SYMPLECTIC, Step, Truth, halvings};
use crate::truth_set::methods::{damped, leapfrog, runge_kutta, tableau};
use crate::truth_set::random::Random;
use crate::truth_set::systems::System;

pub const COUNT: usize = 200;

/// Rotors in cosine potentials of one period, neighbours coupled by the cosine of their difference.
fn rotors(random: &mut Random, period: f64) -> System {
    let dof = random.whole(1, 4);
    let unit = std::f64::consts::TAU / period;
    let masses = random.row(dof, 0.5, 2.0);
    let depth = random.row(dof, 0.3, 1.0);
    let coupling = random.between(0.0, 0.4);
    let force = Arc::new(move |q: &[f64], f: &mut [f64]| {
        for i in 0..dof {
            f[i] = -unit * depth[i] * (unit * q[i]).sin();
            if i > 0 {
                f[i] -= unit * coupling * (unit * (q[i] - q[i - 1])).sin();
            }
            if i + 1 < dof {
                f[i] -= unit * coupling * (unit * (q[i] - q[i + 1])).sin();
            }
        }
    });
    // Anywhere on the circle, so that many loops cross its ends.
    let q0 = random.row(dof, 0.0, period);
    let on = Ellipses {
        q0,
        p0: random.row(dof, -unit, unit),
        radii_q: random.row(dof, 0.05 * period, 0.15 * period),
        radii_p: random.row(dof, 0.3 * unit, unit),
    };
    System {
        name: "rotors",
        masses,
        force,
        omega: 2.0 * unit,
        on,
    }
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(10, index);
    let period = random.log_between(0.01, 100.0);
    let system = rotors(random, period);
    let dof = system.dof();
    let (name, step, truth): (_, Step, _) = match index % 4 {
        0 | 1 => {
            let truth = Truth::of(SYMPLECTIC).with_change(|_| 0.0);
            ("leapfrog", leapfrog(&system), truth)
        }
        2 => {
            let factor = 1.0 - random.log_between(1e-4, 0.1);
            let truth = Truth::of(Expected::NotSymplectic).with_change(move |_| factor - 1.0);
            ("damped", damped(leapfrog(&system), factor), truth)
        }
        _ => {
            let method = tableau("heun");
            let truth = Truth::of(Expected::NotSymplectic).with_orders(method.orders(dof));
            ("heun", runge_kutta(&system, method), truth)
        }
    };
    let h = random.between(0.3, 1.0) / system.omega;
    let coordinates = Coordinates::plain(dof)
        .with_periods(vec![period; dof])
        .unwrap();
    let map = PerSample::new(dof, move |h, q: &mut [f64], p: &mut [f64]| {
        step(h, q, p);
        q.iter_mut().for_each(|q| *q = q.rem_euclid(period));
    });
    let map: Arc<dyn TimeAdvance> = Arc::new(map.with_coordinates(coordinates).unwrap());
    let label = format!("rotors d = {dof}, period {period:.1e}, {name}");
    let truth = Truth {
        initial: Some(system.on.integral()),
        ..truth
    };
    Member::new(label, map, system.on.circle(), halvings(h, 8), truth)
}

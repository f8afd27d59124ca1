//! Degrees of freedom of very different size: heavy and light bodies.

use std::sync::Arc;

use crate::truth_set::member::{
    Ellipses, Expected, Member, SYMPLECTIC, Step, Truth, halvings, map_of,
};
use crate::truth_set::methods::{leapfrog, runge_kutta, tableau};
use crate::truth_set::random::Random;
use crate::truth_set::systems::{MAX_DOF, System};

pub const COUNT: usize = 360;

/// Heavy bodies of mass 1, then light ones of mass `light`: all have forces in proportion to their mass, and each light
/// one is drawn to the first heavy one.
fn bodies(random: &mut Random, light: f64) -> (System, usize) {
    let (heavies, lights) = (random.whole(1, 2), random.whole(1, 3));
    let dof = heavies + lights;
    let mass = move |i: usize| if i < heavies { 1.0 } else { light };
    let k = random.row(dof, 0.4, 1.0);
    let quartic = random.row(dof, 0.05, 0.3);
    let pull = random.between(0.1, 0.4);
    let force = Arc::new(move |q: &[f64], f: &mut [f64]| {
        for i in 0..dof {
            f[i] = -mass(i) * (k[i] + quartic[i] * q[i] * q[i]) * q[i];
        }
        for i in heavies..dof {
            let pulled = light * pull * (q[i] - q[0]);
            f[i] -= pulled;
            f[0] += pulled;
        }
    });
    let sized = |row: Vec<f64>| row.iter().enumerate().map(|(i, x)| mass(i) * x).collect();
    let on = Ellipses {
        q0: random.row(dof, -0.4, 0.4),
        p0: sized(random.row(dof, -0.4, 0.4)),
        radii_q: random.row(dof, 0.3, 0.6),
        radii_p: sized(random.row(dof, 0.3, 0.6)),
    };
    let masses = (0..dof).map(mass).collect();
    let system = System {
        name: "bodies",
        masses,
        force,
        omega: 1.5,
        on,
    };
    (system, heavies)
}

/// The light bodies advanced by Heun's method in the field of the heavy ones at rest, then the heavy ones by leapfrog in
/// that of the light ones.
fn light_by_heun(system: &System, heavies: usize) -> Step {
    let (heun, leap) = (runge_kutta(system, tableau("heun")), leapfrog(system));
    Arc::new(move |h, q, p| {
        let dof = q.len();
        let (mut x, mut y) = ([0.0; MAX_DOF], [0.0; MAX_DOF]);
        x[..dof].copy_from_slice(q);
        y[..dof].copy_from_slice(p);
        heun(h, &mut x[..dof], &mut y[..dof]);
        leap(h, q, p);
        q[heavies..].copy_from_slice(&x[heavies..dof]);
        p[heavies..].copy_from_slice(&y[heavies..dof]);
    })
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(5, index);
    let light = random.log_between(1e-15, 1e-3);
    let (system, heavies) = bodies(random, light);
    let area = |of: std::ops::Range<usize>| -> f64 { of.map(|i| system.on.area(i)).sum() };
    let part = area(heavies..system.dof()) / area(0..system.dof());
    let (name, step, truth) = match index % 4 {
        0 | 1 => {
            let truth = Truth::of(SYMPLECTIC).with_change(|_| 0.0);
            ("leapfrog".into(), leapfrog(&system), truth)
        }
        2 => {
            let factor = 1.0 - random.between(0.01, 0.1);
            let leap = leapfrog(&system);
            let step: Step = Arc::new(move |h, q, p| {
                p[heavies..].iter_mut().for_each(|p| *p *= factor);
                leap(h, q, p);
            });
            let mut truth = Truth::of(Expected::NotSymplectic);
            let change = (factor - 1.0) * part;
            truth.change = Some(Arc::new(move |_| change));
            (format!("light ones damped by {factor:.3}"), step, truth)
        }
        _ => {
            let step = light_by_heun(&system, heavies);
            let truth = Truth::of(Expected::NotSymplectic);
            ("light ones by Heun".into(), step, truth)
        }
    };
    let label = format!(
        "{heavies} heavy, {} light of {light:.0e}, {name}",
        system.dof() - heavies
    );
    let h = random.between(0.4, 1.0) / system.omega;
    let truth = Truth {
        initial: Some(system.on.integral()),
        ..truth
    };
    let map = map_of(system.dof(), step);
    Member::new(label, map, system.on.circle(), halvings(h, 10), truth)
}

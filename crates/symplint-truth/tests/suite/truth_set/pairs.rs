//! Particles with forces between pairs, on the default circle: with equal phases it would only shift them.

use std::sync::Arc;

use symplint::{Circle, PerSample, TimeAdvance};

use crate::truth_set::member::{
    Ellipses, Expected, Member, SYMPLECTIC, Step, Truth, halvings, map_of,
};
use crate::truth_set::methods::{SPLITTINGS, leapfrog, runge_kutta, splitting, tableau};
use crate::truth_set::random::Random;
use crate::truth_set::systems::System;

pub const COUNT: usize = 200;

/// The strength of a pair force along the distance, times the distance.
#[derive(Clone, Copy)]
enum Pair {
    Sine,
    Gaussian,
    SoftCoulomb,
}

impl Pair {
    fn strength(self, squared: f64) -> f64 {
        match self {
            Pair::Sine => {
                let distance = squared.sqrt();
                if distance < 1e-8 {
                    -1.0
                } else {
                    -distance.sin() / distance
                }
            }
            Pair::Gaussian => -(-0.5 * squared).exp(),
            Pair::SoftCoulomb => (1.0 + squared).powf(-1.5),
        }
    }
}

/// The forces, besides the forces of a pair potential.
#[derive(Clone, Copy)]
enum Extra {
    Nothing,
    /// ε times the distance, turned by a right angle, with opposite signs on both particles of a pair.
    Turning(f64),
    /// On a line: ε (−q_j, q_i) on the particles i < j of a pair.
    Curl(f64),
    /// On a line: ε sin(q_i − q_j) cos q_i cos q_j, as forces from a grid are: opposite, and no function of the distance.
    Deposited(f64),
}

fn system(random: &mut Random, axes: usize, extra: Extra) -> System {
    let particles = random.whole(2, 4);
    let dof = particles * axes;
    let masses: Vec<f64> = (0..particles).map(|_| random.between(0.5, 2.0)).collect();
    let pair = random.pick(&[Pair::Sine, Pair::Gaussian, Pair::SoftCoulomb]);
    let k = random.between(0.3, 1.0);
    let lightest = masses.iter().copied().fold(f64::INFINITY, f64::min);
    let force = Arc::new(move |q: &[f64], f: &mut [f64]| {
        f.fill(0.0);
        for i in 0..particles {
            for j in i + 1..particles {
                let mut apart = [0.0; 2];
                for (axis, apart) in apart.iter_mut().enumerate().take(axes) {
                    *apart = q[i * axes + axis] - q[j * axes + axis];
                }
                let strength = k * pair.strength(apart[0] * apart[0] + apart[1] * apart[1]);
                let mut on = |axis: usize, of_i: f64, of_j: f64| {
                    f[i * axes + axis] += of_i;
                    f[j * axes + axis] += of_j;
                };
                for (axis, apart) in apart.into_iter().enumerate().take(axes) {
                    on(axis, strength * apart, -strength * apart);
                }
                match extra {
                    Extra::Nothing => {}
                    Extra::Turning(size) => {
                        on(0, -size * apart[1], size * apart[1]);
                        on(1, size * apart[0], -size * apart[0]);
                    }
                    Extra::Curl(size) => on(0, -size * q[j], size * q[i]),
                    Extra::Deposited(size) => {
                        let along = size * apart[0].sin() * q[i].cos() * q[j].cos();
                        on(0, along, -along);
                    }
                }
            }
        }
    });
    // One radius for all positions and one for all momenta, as users give them.
    let (radius_q, radius_p) = (random.between(0.2, 0.6), random.between(0.2, 0.6));
    let on = Ellipses {
        q0: (0..dof)
            .map(|i| 1.3 * (i / axes) as f64 + random.between(-0.3, 0.3))
            .collect(),
        p0: random.row(dof, -0.3, 0.3),
        radii_q: vec![radius_q; dof],
        radii_p: vec![radius_p; dof],
    };
    System {
        name: "pairs",
        masses: masses.iter().flat_map(|&mass| vec![mass; axes]).collect(),
        force,
        omega: (particles as f64 * k / lightest).sqrt(),
        on,
    }
}

/// Momenta without those of the centre of mass.
fn remove_drift(masses: &[f64], axes: usize, p: &mut [f64]) {
    let total: f64 = masses.iter().step_by(axes).sum();
    for axis in 0..axes {
        let drift = p.iter().skip(axis).step_by(axes).sum::<f64>() / total;
        for (p, mass) in p.iter_mut().zip(masses).skip(axis).step_by(axes) {
            *p -= mass * drift;
        }
    }
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(21, index);
    let axes = match index % 5 {
        1 => 2,
        2 => 1,
        _ => random.whole(1, 2),
    };
    let size = random.sign() * random.log_between(1e-3, 0.3);
    let extra = match index % 5 {
        1 => Extra::Turning(size),
        2 if index.is_multiple_of(2) => Extra::Curl(size),
        2 => Extra::Deposited(size),
        _ => Extra::Nothing,
    };
    let system = system(random, axes, extra);
    let (dof, h) = (system.dof(), random.between(0.4, 1.0) / system.omega);
    let method = random.pick(&["midpoint", "heun", "kutta3"]);
    let of_method = |symplectic: bool| match symplectic {
        true => leapfrog(&system),
        false => runge_kutta(&system, tableau(method)),
    };
    let what = format!("{} on {axes} axes", dof / axes);
    let diagnostic = halvings(h, 8);
    let new = |label: String, map, truth| {
        let on: Circle = system.on.circle();
        Member::new(label, map, on, diagnostic.clone(), truth)
    };
    match index % 5 {
        0 => {
            let (name, weights) = random.pick(&SPLITTINGS);
            let step = splitting(&system, weights, random.chance(0.5));
            let truth = Truth::of(SYMPLECTIC).with_change(|_| 0.0);
            new(format!("{what}, {name}"), map_of(dof, step), truth)
        }
        1 | 2 => {
            let truth = Truth::of(Expected::NotSymplectic);
            let label = format!("{what}, leapfrog, forces without potential of {size:.0e}");
            new(label, map_of(dof, leapfrog(&system)), truth)
        }
        3 => {
            let truth = Truth::of(Expected::NotSymplectic);
            new(
                format!("{what}, {method}"),
                map_of(dof, of_method(false)),
                truth,
            )
        }
        _ => {
            let symplectic = random.chance(0.5);
            let (step, masses) = (of_method(symplectic), system.masses.clone());
            let step: Step = Arc::new(move |h, q, p| {
                step(h, q, p);
                remove_drift(&masses, axes, p);
            });
            let masses = system.masses.clone();
            let advance = step.clone();
            let projected: Arc<dyn TimeAdvance> = Arc::new(
                PerSample::new(dof, move |h, q: &mut [f64], p: &mut [f64]| advance(h, q, p))
                    .with_projection(move |_, p| remove_drift(&masses, axes, p)),
            );
            let names_it = index % 10 == 4;
            // Without the projection the step takes all of phase space to a part of it.
            let expected = match symplectic && names_it {
                true => SYMPLECTIC,
                false => Expected::NotSymplectic,
            };
            let label = format!(
                "{what}, {}, centre of mass removed{}",
                if symplectic { "leapfrog" } else { method },
                if names_it { ", with a projection" } else { "" }
            );
            let map = match names_it {
                true => projected.clone(),
                false => map_of(dof, step),
            };
            new(label, map, Truth::of(expected)).on_manifold(projected)
        }
    }
}

/// On the default circle every defect shows; that none is exactly 0 means that the loop tests the forces.
#[test]
fn no_given_loop_hides_a_defect() {
    use crate::truth_set::outcome::diagnose;
    for index in (0..COUNT).step_by(7) {
        let member = member(index);
        if !matches!(member.truth.expected, Expected::NotSymplectic) {
            continue;
        }
        let found = diagnose(&member.subject).unwrap();
        let steps = &found.evidence.loops[0].steps;
        let largest = steps
            .iter()
            .map(|step| step.defect.magnitude())
            .fold(0.0, f64::max);
        assert!(largest > 1e-12, "{index}, {}: {largest:e}", member.label);
    }
}

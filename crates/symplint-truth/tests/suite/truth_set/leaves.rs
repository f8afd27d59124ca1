//! Lie–Poisson coordinates: spins and tops, whose form is degenerate, on their leaves and off them.
//!
//! A spin m of fixed length has the form of the area, dϑ with ϑ = m_z dφ. A top (Γ, Π) with Γ·Π = 0 and |Γ| fixed has that of
//! the cotangent bundle of the sphere, ϑ = p·dΓ with p = Π×Γ/|Γ|². Rotations by an angle that depends on the component along
//! their axis are exact flows, and so is Π += Γ×c.

use std::sync::Arc;

use symplint::map::{NonCanonical, OneForm};
use symplint::{Block, Circle, PerSample, TimeAdvance};

use crate::truth_set::member::{Expected, Member, SYMPLECTIC, Step, Truth, halvings};
use crate::truth_set::random::Random;

pub const COUNT: usize = 180;

type Vector = [f64; 3];

fn at(z: &[f64], k: usize) -> Vector {
    [z[3 * k], z[3 * k + 1], z[3 * k + 2]]
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn sum(a: Vector, factor: f64, b: Vector) -> Vector {
    [0, 1, 2].map(|i| a[i] + factor * b[i])
}

fn scaled_to(a: Vector, size: f64) -> Vector {
    let factor = size / dot(a, a).sqrt();
    a.map(|x| factor * x)
}

/// Rotated about an axis of size `size`, by an angle.
fn rotated(a: Vector, axis: Vector, angle: f64) -> Vector {
    let axis = scaled_to(axis, 1.0);
    let (sin, cos) = angle.sin_cos();
    let along = dot(a, axis) * (1.0 - cos);
    let turned = cross(axis, a);
    [0, 1, 2].map(|i| cos * a[i] + sin * turned[i] + along * axis[i])
}

fn write(z: &mut [f64], k: usize, a: Vector) {
    z[3 * k..3 * k + 3].copy_from_slice(&a);
}

/// The sizes of all spins, or of Γ of a top.
#[derive(Clone)]
enum Kind {
    Spins(Vec<f64>),
    Top(f64),
}

/// A form of coordinates that are `unit` times as large.
#[derive(Clone)]
struct Form {
    kind: Kind,
    unit: f64,
    /// Whether it keeps to the leaf.
    keeps: bool,
}

impl Form {
    fn vectors(&self) -> usize {
        match &self.kind {
            Kind::Spins(sizes) => sizes.len(),
            Kind::Top(_) => 2,
        }
    }

    fn onto_leaf(&self, z: &mut [f64]) {
        match &self.kind {
            Kind::Spins(sizes) => {
                for (k, &size) in sizes.iter().enumerate() {
                    write(z, k, scaled_to(at(z, k), self.unit * size));
                }
            }
            Kind::Top(size) => {
                let gamma = scaled_to(at(z, 0), self.unit * size);
                let along = dot(gamma, at(z, 1)) / dot(gamma, gamma);
                write(z, 1, sum(at(z, 1), -along, gamma));
                write(z, 0, gamma);
            }
        }
    }

    fn theta(&self, z: &[f64], theta: &mut [f64]) {
        match &self.kind {
            Kind::Spins(sizes) => {
                for k in 0..sizes.len() {
                    let [x, y, along] = at(z, k);
                    let squared = x * x + y * y;
                    write(theta, k, [-along * y / squared, along * x / squared, 0.0]);
                }
            }
            Kind::Top(_) => {
                let gamma = at(z, 0);
                let p = cross(at(z, 1), gamma).map(|x| x / dot(gamma, gamma));
                write(theta, 0, p);
                write(theta, 1, [0.0; 3]);
            }
        }
    }

    fn each(&self, block: &mut Block<'_>, act: impl Fn(&mut [f64], &mut [f64])) {
        let n = self.dimension();
        let (mut z, mut theta) = (vec![0.0; n], vec![0.0; n]);
        for k in 0..block.len() {
            (0..n).for_each(|i| z[i] = block.q.row(i)[k]);
            act(&mut z, &mut theta);
            for i in 0..n {
                block.q.row_mut(i)[k] = z[i];
                block.p.row_mut(i)[k] = theta[i];
            }
        }
    }
}

impl OneForm for Form {
    fn dimension(&self) -> usize {
        3 * self.vectors()
    }

    fn evaluate(&self, block: &mut Block<'_>) {
        self.each(block, |z, theta| self.theta(z, theta));
    }

    fn project(&self, block: &mut Block<'_>) {
        if self.keeps {
            self.each(block, |z, _| self.onto_leaf(z));
        }
    }
}

/// Spins with inertia along the axes, and exchange between neighbours.
#[derive(Clone)]
struct Spins {
    inertia: Vec<Vector>,
    exchange: f64,
}

impl Spins {
    fn flows(&self, h: f64, z: &mut [f64]) {
        for (k, inertia) in self.inertia.iter().enumerate() {
            for (axis, part) in [(0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)] {
                let mut direction = [0.0; 3];
                direction[axis] = 1.0;
                let m = at(z, k);
                write(
                    z,
                    k,
                    rotated(m, direction, -part * h * m[axis] / inertia[axis]),
                );
            }
        }
        for k in 1..self.inertia.len() {
            // Both turn about their sum.
            let (a, b) = (at(z, k - 1), at(z, k));
            let total = sum(a, 1.0, b);
            let angle = h * self.exchange * dot(total, total).sqrt();
            write(z, k - 1, rotated(a, total, angle));
            write(z, k, rotated(b, total, angle));
        }
    }

    /// dm/dt = m × field.
    fn velocity(&self, z: &[f64], k: usize) -> Vector {
        let (m, inertia) = (at(z, k), self.inertia[k]);
        let mut field = [0, 1, 2].map(|i| m[i] / inertia[i]);
        for other in [k.wrapping_sub(1), k + 1] {
            if other < self.inertia.len() {
                field = sum(field, -self.exchange, at(z, other));
            }
        }
        cross(m, field)
    }

    /// The explicit midpoint rule, and back to the lengths before.
    fn midpoint(&self, h: f64, z: &mut [f64]) {
        let (before, count) = (z.to_vec(), self.inertia.len());
        let mut half = z.to_vec();
        for k in 0..count {
            let moved = sum(at(&before, k), 0.5 * h, self.velocity(&before, k));
            write(&mut half, k, moved);
        }
        for k in 0..count {
            let m = at(&before, k);
            let moved = sum(m, h, self.velocity(&half, k));
            write(z, k, scaled_to(moved, dot(m, m).sqrt()));
        }
    }
}

/// Towards an axis, and back to the length before.
fn damp(z: &mut [f64], k: usize, rate: f64) {
    let m = at(z, k);
    write(
        z,
        k,
        scaled_to(sum(m, rate, [0.0, 0.3, 1.0]), dot(m, m).sqrt()),
    );
}

fn top_flows(inertia: Vector, weight: Vector, h: f64, z: &mut [f64]) {
    let kick = |z: &mut [f64], part: f64| {
        let pulled = sum(at(z, 1), part * h, cross(at(z, 0), weight));
        write(z, 1, pulled);
    };
    kick(z, 0.5);
    for (axis, part) in [(0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)] {
        let mut direction = [0.0; 3];
        direction[axis] = 1.0;
        let angle = -part * h * z[3 + axis] / inertia[axis];
        for k in 0..2 {
            let turned = rotated(at(z, k), direction, angle);
            write(z, k, turned);
        }
    }
    kick(z, 0.5);
}

/// A vector away from the axis at which ϑ of a spin is singular.
fn vector(random: &mut Random, size: f64) -> Vector {
    let angle = random.between(0.0, std::f64::consts::TAU);
    let along = random.between(-0.6, 0.6);
    let across = (1.0 - along * along).sqrt();
    [across * angle.cos(), across * angle.sin(), along].map(|x| size * x)
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(22, index);
    let unit = random.log_between(1e-3, 1e3);
    // They differ: a body of equal inertia about all axes does not move.
    let inertia =
        |random: &mut Random| [0.8, 1.4, 2.3].map(|about| about * random.between(0.9, 1.1));
    let symplectic = index.is_multiple_of(2);
    let rate = random.log_between(1e-2, 0.2);
    let (kind, centre, step, what): (Kind, Vec<f64>, Step, String) = match index % 4 {
        3 | 2 if random.chance(0.6) => {
            let (of_top, weight) = (inertia(random), vector(random, random_size(index)));
            let gamma = vector(random, 1.0);
            let pi = vector(random, random_size(index));
            let pi = sum(pi, -dot(pi, gamma), gamma);
            let step: Step = Arc::new(move |h, z, _| {
                top_flows(of_top, weight, h, z);
                if !symplectic {
                    z[3..].iter_mut().for_each(|x| *x *= 1.0 - rate * h);
                }
            });
            let centre = [gamma, pi].concat();
            (Kind::Top(1.0), centre, step, "top".into())
        }
        _ => {
            let count = random.whole(1, 3);
            let sizes = random.row(count, 0.7, 1.5);
            let centre = sizes
                .iter()
                .flat_map(|&size| vector(random, size))
                .collect();
            let spins = Spins {
                inertia: (0..count).map(|_| inertia(random)).collect(),
                exchange: random.between(0.3, 1.0),
            };
            let damped = random.chance(0.5);
            let step: Step = Arc::new(move |h, z, _| match (symplectic, damped) {
                (true, _) => spins.flows(h, z),
                (false, true) => {
                    spins.flows(h, z);
                    (0..count).for_each(|k| damp(z, k, rate * h));
                }
                (false, false) => spins.midpoint(h, z),
            });
            (Kind::Spins(sizes), centre, step, format!("{count} spins"))
        }
    };
    let n = centre.len();
    let step: Step = Arc::new(move |h, z, _| {
        z.iter_mut().for_each(|x| *x /= unit);
        step(h, z, &mut []);
        z.iter_mut().for_each(|x| *x *= unit);
    });
    // One in seven keeps to no leaf, and is undecided until it does.
    let keeps = index % 7 != 3;
    let map = |keeps: bool| {
        let (kind, step) = (kind.clone(), step.clone());
        let form = Form { kind, unit, keeps };
        let map = PerSample::new(n, move |h, z: &mut [f64], _: &mut [f64]| {
            step(h, z, &mut []);
        });
        NonCanonical::of_positions(map, form).unwrap()
    };
    let centre: Vec<f64> = centre.iter().map(|x| unit * x).collect();
    let circle = Circle::new(centre, vec![0.0; n], unit * random.between(0.1, 0.2)).unwrap();
    let expected = match symplectic {
        true => SYMPLECTIC,
        false => Expected::NotSymplectic,
    };
    let label = format!(
        "{what}, {}, unit {unit:.0e}{}",
        if symplectic {
            "flows"
        } else {
            "not symplectic"
        },
        if keeps { ", on a leaf" } else { "" }
    );
    let named = Arc::new(map(keeps));
    let on = OnForm(named.clone(), circle);
    let diagnostic = halvings(random.between(0.3, 0.8), 8);
    let projected: Arc<dyn TimeAdvance> = Arc::new(map(true));
    Member::new(label, named, on, diagnostic, Truth::of(expected)).on_manifold(projected)
}

fn random_size(index: usize) -> f64 {
    0.6 + 0.1 * (index % 7) as f64
}

/// A circle of coordinates as a loop of a map.
struct OnForm<M>(Arc<NonCanonical<M, Form>>, Circle);

impl<M: TimeAdvance> symplint::Loop for OnForm<M> {
    fn dof(&self) -> usize {
        self.1.dof()
    }

    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        self.0.loop_of(&self.1).sample(s, block);
    }
}

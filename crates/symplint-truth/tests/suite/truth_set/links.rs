//! Masses on rigid links in Cartesian coordinates, and steps that keep the links.

use std::f64::consts::TAU;
use std::sync::Arc;

use symplint::{Block, Loop};

use crate::truth_set::member::Step;
use crate::truth_set::random::Random;
use crate::truth_set::systems::MAX_DOF;

type Row = [f64; MAX_DOF];

/// One or two masses, the first linked to the origin, the second to the first, in two or three dimensions.
#[derive(Clone)]
pub struct Links {
    pub dimensions: usize,
    masses: Vec<f64>,
    lengths: Vec<f64>,
    gravity: f64,
    /// Of a spring along x.
    stiffness: f64,
}

impl Links {
    /// A pendulum, a spherical one or a double one.
    pub fn random(random: &mut Random) -> Self {
        let (dimensions, count) = random.pick(&[(2, 1), (3, 1), (2, 2)]);
        Links {
            dimensions,
            masses: random.row(count, 0.5, 1.5),
            lengths: random.row(count, 0.7, 1.3),
            gravity: random.between(0.5, 1.5),
            stiffness: random.between(0.0, 0.5),
        }
    }

    pub fn name(&self) -> &'static str {
        match (self.dimensions, self.masses.len()) {
            (2, 1) => "pendulum",
            (3, 1) => "spherical pendulum",
            _ => "double pendulum",
        }
    }

    /// Cartesian coordinates.
    pub fn dof(&self) -> usize {
        self.dimensions * self.masses.len()
    }

    /// The fastest frequency, about.
    pub fn omega(&self) -> f64 {
        let shortest = self.lengths.iter().copied().fold(f64::INFINITY, f64::min);
        let omega = (self.gravity / shortest + self.stiffness).sqrt();
        if self.masses.len() == 2 {
            2.0 * omega
        } else {
            omega
        }
    }

    fn mass(&self, i: usize) -> f64 {
        self.masses[i / self.dimensions]
    }

    fn force(&self, q: &[f64]) -> Row {
        let mut f = [0.0; MAX_DOF];
        for (i, q) in q.iter().enumerate() {
            f[i] = match i % self.dimensions {
                0 => -self.mass(i) * self.stiffness * q,
                last if last + 1 == self.dimensions => -self.mass(i) * self.gravity,
                _ => 0.0,
            };
        }
        f
    }

    /// From the mass before to mass `j`.
    fn link(&self, x: &[f64], j: usize) -> [f64; 3] {
        let n = self.dimensions;
        let mut d = [0.0; 3];
        for (c, d) in d.iter_mut().enumerate().take(n) {
            *d = x[j * n + c] - if j > 0 { x[(j - 1) * n + c] } else { 0.0 };
        }
        d
    }

    /// |d_j|² − l_j².
    fn constraint(&self, q: &[f64]) -> [f64; 2] {
        let mut g = [0.0; 2];
        for (j, length) in self.lengths.iter().enumerate() {
            g[j] = self.link(q, j).iter().map(|d| d * d).sum::<f64>() - length * length;
        }
        g
    }

    /// Its derivative.
    fn gradient(&self, q: &[f64]) -> [Row; 2] {
        let n = self.dimensions;
        let mut rows = [[0.0; MAX_DOF]; 2];
        for (j, row) in rows.iter_mut().enumerate().take(self.lengths.len()) {
            for (c, d) in self.link(q, j).into_iter().enumerate().take(n) {
                row[j * n + c] = 2.0 * d;
                if j > 0 {
                    row[(j - 1) * n + c] = -2.0 * d;
                }
            }
        }
        rows
    }

    /// G M⁻¹ G'ᵀ, with 1 for a single link.
    fn metric(&self, g: &[Row; 2], other: &[Row; 2]) -> [[f64; 2]; 2] {
        let entry = |j: usize, k: usize| -> f64 {
            (0..self.dof())
                .map(|i| g[j][i] * other[k][i] / self.mass(i))
                .sum()
        };
        let last = if self.masses.len() == 2 {
            entry(1, 1)
        } else {
            1.0
        };
        [[entry(0, 0), entry(0, 1)], [entry(1, 0), last]]
    }

    /// G M⁻¹ v.
    fn rates(&self, g: &[Row; 2], p: &[f64]) -> [f64; 2] {
        let rate = |j: usize| (0..self.dof()).map(|i| g[j][i] * p[i] / self.mass(i)).sum();
        [rate(0), rate(1)]
    }

    /// Momenta without their part across the manifold.
    fn tangent(&self, q: &[f64], p: &mut [f64]) {
        let g = self.gradient(q);
        let mu = solve(self.metric(&g, &g), self.rates(&g, p));
        for (i, p) in p.iter_mut().enumerate() {
            *p -= g[0][i] * mu[0] + g[1][i] * mu[1];
        }
    }

    /// Moves `q` along M⁻¹ of the rows of `along` onto the links; the multipliers.
    fn onto(&self, q: &mut [f64], along: &[Row; 2]) -> [f64; 2] {
        let mut total = [0.0; 2];
        for _ in 0..50 {
            let g = self.constraint(q);
            let lambda = solve(self.metric(&self.gradient(q), along), g);
            for (i, q) in q.iter_mut().enumerate() {
                *q -= (along[0][i] * lambda[0] + along[1][i] * lambda[1]) / self.mass(i);
            }
            (total[0], total[1]) = (total[0] + lambda[0], total[1] + lambda[1]);
            if g[0].abs().max(g[1].abs()) < 1e-15 {
                break;
            }
        }
        total
    }

    /// Puts a state on the manifold.
    pub fn project(&self, q: &mut [f64], p: &mut [f64]) {
        let along = self.gradient(q);
        self.onto(q, &along);
        self.tangent(q, p);
    }

    /// The RATTLE step, HLW section VII.1.4: symplectic on the manifold.
    pub fn rattle(&self) -> Step {
        let links = self.clone();
        Arc::new(move |h, q, p| {
            let (along, force) = (links.gradient(q), links.force(q));
            for i in 0..q.len() {
                p[i] += 0.5 * h * force[i];
                q[i] += h * p[i] / links.mass(i);
            }
            let lambda = links.onto(q, &along);
            let force = links.force(q);
            for (i, p) in p.iter_mut().enumerate() {
                *p -= (along[0][i] * lambda[0] + along[1][i] * lambda[1]) / h;
                *p += 0.5 * h * force[i];
            }
            links.tangent(q, p);
        })
    }

    /// dq/dt and dp/dt with the forces of the links, from the second derivative of the constraint.
    fn flow(&self, q: &[f64], p: &[f64]) -> (Row, Row) {
        let (mut v, mut f, g) = ([0.0; MAX_DOF], self.force(q), self.gradient(q));
        for (i, p) in p.iter().enumerate() {
            v[i] = p / self.mass(i);
        }
        let mut right = self.rates(&g, &f[..q.len()]);
        for (j, right) in right.iter_mut().enumerate().take(self.masses.len()) {
            *right += 2.0
                * self
                    .link(&v[..q.len()], j)
                    .iter()
                    .map(|d| d * d)
                    .sum::<f64>();
        }
        let lambda = solve(self.metric(&g, &g), right);
        for i in 0..q.len() {
            f[i] -= g[0][i] * lambda[0] + g[1][i] * lambda[1];
        }
        (v, f)
    }

    /// A step of Heun's method or of the classical Runge–Kutta method, then back onto the manifold.
    pub fn projected(&self, classical: bool) -> Step {
        let links = self.clone();
        // Part of the step at which each stage stands, and its weight.
        let stages: &[(f64, f64)] = match classical {
            true => &[
                (0.0, 1.0 / 6.0),
                (0.5, 1.0 / 3.0),
                (0.5, 1.0 / 3.0),
                (1.0, 1.0 / 6.0),
            ],
            false => &[(0.0, 0.5), (1.0, 0.5)],
        };
        Arc::new(move |h, q, p| {
            let dof = q.len();
            let (mut v, mut f) = ([0.0; MAX_DOF], [0.0; MAX_DOF]);
            let (mut sum_v, mut sum_f) = (v, f);
            for (at, weight) in stages {
                let (mut x, mut y) = ([0.0; MAX_DOF], [0.0; MAX_DOF]);
                for i in 0..dof {
                    (x[i], y[i]) = (q[i] + at * h * v[i], p[i] + at * h * f[i]);
                }
                (v, f) = links.flow(&x[..dof], &y[..dof]);
                for i in 0..dof {
                    sum_v[i] += weight * v[i];
                    sum_f[i] += weight * f[i];
                }
            }
            for i in 0..dof {
                q[i] += h * sum_v[i];
                p[i] += h * sum_f[i];
            }
            links.project(q, p);
        })
    }
}

/// Of two equations.
fn solve([[a, b], [c, d]]: [[f64; 2]; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    let det = a * d - b * c;
    [(d * x - b * y) / det, (a * y - c * x) / det]
}

/// A closed loop of states on the manifold: angles and their velocities run ellipses.
#[derive(Clone)]
pub struct OnLinks {
    links: Links,
    /// Of each angle: centre, radius, centre and radius of its velocity, phase.
    angles: Vec<[f64; 5]>,
}

impl OnLinks {
    pub fn random(random: &mut Random, links: &Links) -> Self {
        let spherical = links.dimensions == 3;
        let count = if spherical { 2 } else { links.masses.len() };
        let angles = (0..count)
            .map(|k| {
                // A spherical pendulum stays away from its poles.
                let centre = if spherical && k == 0 {
                    1.2
                } else {
                    random.between(-0.6, 0.6)
                };
                let (radius, speed) = (random.between(0.2, 0.5), random.between(0.2, 0.5));
                [
                    centre,
                    radius,
                    random.between(-0.3, 0.3),
                    speed,
                    random.between(0.0, 0.1),
                ]
            })
            .collect();
        OnLinks {
            links: links.clone(),
            angles,
        }
    }

    fn state(&self, s: f64) -> (Row, Row) {
        let of = |k: usize| {
            let [centre, radius, velocity, speed, phase] = self.angles[k];
            let (sin, cos) = (TAU * (s + phase)).sin_cos();
            (centre + radius * sin, velocity + speed * cos)
        };
        let (mut x, mut v) = ([0.0; MAX_DOF], [0.0; MAX_DOF]);
        let l = &self.links;
        if l.dimensions == 3 {
            let ((theta, dtheta), (phi, dphi)) = (of(0), of(1));
            let ((st, ct), (sp, cp)) = (theta.sin_cos(), phi.sin_cos());
            let place = [st * cp, st * sp, -ct];
            let speed = [
                dtheta * ct * cp - dphi * st * sp,
                dtheta * ct * sp + dphi * st * cp,
                dtheta * st,
            ];
            for c in 0..3 {
                (x[c], v[c]) = (l.lengths[0] * place[c], l.lengths[0] * speed[c]);
            }
        } else {
            for j in 0..l.masses.len() {
                let (angle, rate) = of(j);
                let (sin, cos) = angle.sin_cos();
                let (place, speed) = ([sin, -cos], [rate * cos, rate * sin]);
                for c in 0..2 {
                    let before = |row: &Row| if j > 0 { row[c] } else { 0.0 };
                    x[2 * j + c] = before(&x) + l.lengths[j] * place[c];
                    v[2 * j + c] = before(&v) + l.lengths[j] * speed[c];
                }
            }
        }
        for (i, v) in v.iter_mut().enumerate().take(l.dof()) {
            *v *= l.mass(i);
        }
        (x, v)
    }
}

impl Loop for OnLinks {
    fn dof(&self) -> usize {
        self.links.dof()
    }

    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        for (k, &s) in s.iter().enumerate() {
            let (x, p) = self.state(s);
            for i in 0..self.dof() {
                block.q.row_mut(i)[k] = x[i];
                block.p.row_mut(i)[k] = p[i];
            }
        }
    }
}

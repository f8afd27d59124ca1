//! The absolutely continuous loop integral of a map that stops iterating at a tolerance, without the library: between
//! two changes of the number of iterations the map is that many iterations, which is smooth.

use std::f64::consts::{PI, TAU};

use num_dual::{Dual64, DualNum};

use crate::solver_tolerance::midpoint::{Field, iterate, solve};

/// A circle in each degree of freedom.
#[derive(Clone, Debug)]
pub struct Circle {
    pub centre: &'static [f64],
    pub radius: f64,
}

impl Circle {
    fn dof(&self) -> usize {
        self.centre.len() / 2
    }

    fn at<D: DualNum<Primitive = f64> + Copy>(&self, s: D) -> [D; 4] {
        let dof = self.dof();
        let mut z = [D::from(0.0); 4];
        for i in 0..dof {
            z[i] = (s * TAU).sin() * self.radius + self.centre[i];
            z[dof + i] = (s * TAU).cos() * self.radius + self.centre[dof + i];
        }
        z
    }

    /// ∮ p dq.
    pub fn area(&self) -> f64 {
        self.dof() as f64 * PI * self.radius * self.radius
    }

    pub fn of_library(&self) -> symplint::Circle {
        let (q, p) = self.centre.split_at(self.dof());
        let circle = symplint::Circle::new(q.to_vec(), p.to_vec(), self.radius).unwrap();
        circle.with_phases(symplint::Phases::Equal)
    }
}

/// The truth about one step.
#[derive(Clone, Debug)]
pub struct Truth {
    /// I_ac/I(0) − 1.
    pub defect: f64,
    /// The places at which the number of iterations changes.
    pub breaks: Vec<f64>,
    /// The largest change of a coordinate at each.
    pub jumps: Vec<f64>,
}

/// Cells that are searched for changes of the number of iterations.
const SCANNED: usize = 20_000;

pub fn truth<F: Field>(circle: &Circle, h: f64, tolerance: f64) -> Truth {
    let width = 2 * F::DOF;
    let count = |s: f64| solve::<F>(h, tolerance, &mut circle.at(s)[..width]);
    let after = |s: f64, iterations: usize| {
        let start = circle.at(s);
        let mut z = start;
        for _ in 0..iterations {
            iterate::<F, f64>(h, &start[..width], &mut z[..width]);
        }
        z
    };
    let (mut breaks, mut counts, mut jumps) = (Vec::new(), Vec::new(), Vec::new());
    let mut last = count(0.0);
    for k in 0..SCANNED {
        let [mut low, mut high] = [k, k + 1].map(|k| k as f64 / SCANNED as f64);
        let next = count(high);
        if next != last {
            while high - low > 1e-16 && low < 0.5 * (low + high) && 0.5 * (low + high) < high {
                let middle = 0.5 * (low + high);
                if count(middle) == last {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            let sides = [after(high, last), after(high, next)];
            let apart = (0..width).map(|c| (sides[1][c] - sides[0][c]).abs());
            breaks.push(high);
            counts.push(next);
            jumps.push(apart.fold(0.0, f64::max));
            last = next;
        }
    }
    let rule = gauss_legendre();
    let integral = |[from, to]: [f64; 2], iterations: usize| {
        // Pieces so short that twelve nodes give round-off.
        let parts = ((to - from) * 48.0).ceil().max(1.0) as usize;
        let width_of_part = (to - from) / parts as f64;
        let mut sum = 0.0;
        for part in 0..parts {
            for &(x, weight) in &rule {
                let s = from + width_of_part * (part as f64 + 0.5 * (1.0 + x));
                let start = circle.at(Dual64::new(s, 1.0));
                let mut z = start;
                for _ in 0..iterations {
                    iterate::<F, Dual64>(h, &start[..width], &mut z[..width]);
                }
                let terms = (0..F::DOF).map(|i| z[F::DOF + i].re * z[i].eps);
                sum += 0.5 * width_of_part * weight * terms.sum::<f64>();
            }
        }
        sum
    };
    let advanced = match breaks.len() {
        0 => integral([0.0, 1.0], last),
        n => (0..n)
            .map(|k| {
                let to = if k + 1 < n {
                    breaks[k + 1]
                } else {
                    breaks[0] + 1.0
                };
                integral([breaks[k], to], counts[k])
            })
            .sum(),
    };
    Truth {
        defect: advanced / circle.area() - 1.0,
        breaks,
        jumps,
    }
}

/// Nodes and weights of degree 12 on [−1, 1], by Newton's method on the Legendre polynomial.
fn gauss_legendre() -> Vec<(f64, f64)> {
    const N: usize = 12;
    (1..=N)
        .map(|k| {
            let mut x = (PI * (k as f64 - 0.25) / (N as f64 + 0.5)).cos();
            let mut slope = 0.0;
            for _ in 0..100 {
                let (mut before, mut value) = (1.0, x);
                for n in 2..=N {
                    let n = n as f64;
                    (before, value) = (
                        value,
                        ((2.0 * n - 1.0) * x * value - (n - 1.0) * before) / n,
                    );
                }
                slope = N as f64 * (x * value - before) / (x * x - 1.0);
                x -= value / slope;
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

//! Sums whose order depends on the number of rows of a batch, as in matrix products, in single and in double precision.

use symplint::Circle;

use crate::truth_set::batches::map_of_batches;
use crate::truth_set::member::{Expected, Member, Truth, halvings, map_of};
use crate::truth_set::random::Random;
use std::sync::Arc;

pub const COUNT: usize = 200;

/// a · b in lanes, whose number depends on the number of rows.
macro_rules! dot {
    ($float:ident, $rows:expr, $a:expr, $b:expr) => {{
        let lanes = match $rows {
            0..=3 => 1,
            4..=16 => 3,
            17..=64 => 4,
            _ => 8,
        };
        let mut sums = [0.0 as $float; 8];
        for (k, (a, b)) in $a.iter().zip($b).enumerate() {
            sums[k % lanes] += *a * *b;
        }
        sums.iter().sum::<$float>()
    }};
}

/// A kick by a stiffness matrix of a chain of masses, or one that is dense, and a drift.
macro_rules! stiffness {
    ($float:ident, $matrix:expr, $frequency:expr, $damping:expr) => {{
        let matrix: Vec<Vec<$float>> = ($matrix.iter())
            .map(|row: &Vec<f64>| row.iter().map(|x| *x as $float).collect())
            .collect();
        let (frequency, damping) = ($frequency, $damping);
        move |h: f64, count: usize, q: &mut [f64], p: &mut [f64]| {
            // h in units of the fastest motion.
            let h = (h / frequency) as $float;
            let x: Vec<$float> = q.iter().map(|x| *x as $float).collect();
            for i in 0..q.len() {
                let force: $float = dot!($float, count, &matrix[i], &x);
                let kicked = (p[i] as $float - h * force) * (1.0 - damping as $float);
                p[i] = f64::from(kicked);
                q[i] = f64::from(x[i] + h * kicked);
            }
        }
    }};
}

/// A kick by the gradient of two layers of tanh, and a drift.
macro_rules! network {
    ($float:ident, $weights:expr, $damping:expr) => {{
        let [first, second] = $weights.map(|matrix: Vec<Vec<f64>>| -> Vec<Vec<$float>> {
            matrix
                .iter()
                .map(|row| row.iter().map(|x| *x as $float).collect())
                .collect()
        });
        let damping = $damping;
        move |h: f64, count: usize, q: &mut [f64], p: &mut [f64]| {
            let h = h as $float;
            let x: Vec<$float> = q.iter().map(|x| *x as $float).collect();
            let a: Vec<$float> = first
                .iter()
                .map(|row| dot!($float, count, row, &x).tanh())
                .collect();
            let b: Vec<$float> = second
                .iter()
                .map(|row| dot!($float, count, row, &a).tanh())
                .collect();
            // V = Σ b².
            let of_second: Vec<$float> = b.iter().map(|b| b * (1.0 - b * b)).collect();
            let of_first: Vec<$float> = (0..a.len())
                .map(|j| {
                    let column: Vec<$float> = second.iter().map(|row| row[j]).collect();
                    dot!($float, count, &column, &of_second) * (1.0 - a[j] * a[j])
                })
                .collect();
            for i in 0..q.len() {
                let column: Vec<$float> = first.iter().map(|row| row[i]).collect();
                let force = dot!($float, count, &column, &of_first) + x[i];
                let kicked = (p[i] as $float - h * force) * (1.0 - damping as $float);
                p[i] = f64::from(kicked);
                q[i] = f64::from(x[i] + h * kicked);
            }
        }
    }};
}

fn matrix(random: &mut Random, rows: usize, columns: usize) -> Vec<Vec<f64>> {
    let size = 1.0 / (columns as f64).sqrt();
    (0..rows)
        .map(|_| random.row(columns, -size, size))
        .collect()
}

/// A symmetric matrix, and the root of its largest eigenvalue, about.
fn stiff(random: &mut Random, dof: usize) -> (Vec<Vec<f64>>, f64) {
    let scale = random.log_between(1.0, 1e6);
    let factor = matrix(random, dof, dof);
    let chain = random.chance(0.5);
    let at = |i: usize, j: usize| match chain {
        true if i == j => 2.0 * scale,
        true if i.abs_diff(j) == 1 => -scale,
        true => 0.0,
        false => scale * (0..dof).map(|k| factor[i][k] * factor[j][k]).sum::<f64>(),
    };
    let matrix: Vec<Vec<f64>> = (0..dof)
        .map(|i| (0..dof).map(|j| at(i.min(j), i.max(j))).collect())
        .collect();
    let norm = (matrix.iter())
        .map(|row| row.iter().map(|x| x.abs()).sum::<f64>())
        .fold(0.0, f64::max);
    (matrix, norm.sqrt())
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(36, index);
    let single = index.is_multiple_of(2);
    let damping = if random.chance(0.25) {
        random.between(0.02, 0.1)
    } else {
        0.0
    };
    let is_network = random.chance(0.5);
    let dof = random.whole(2, if is_network { 5 } else { 24 });
    macro_rules! maps {
        ($single:expr, $double:expr) => {{
            let double = $double;
            let exact = double.clone();
            let exact = map_of(dof, Arc::new(move |h, q, p| exact(h, 1, q, p)));
            let of_batches = |step: Box<dyn Fn(f64, usize, &mut [f64], &mut [f64]) + Send>| {
                map_of_batches(dof, move |h, rows| {
                    let count = rows.len();
                    rows.iter_mut().for_each(|(q, p)| step(h, count, q, p));
                })
            };
            let map = match single {
                true => of_batches(Box::new($single)),
                false => of_batches(Box::new(double)),
            };
            (map, exact)
        }};
    }
    let (what, (map, exact), frequency) = match is_network {
        true => {
            let width = random.whole(8, 40);
            let weights = [matrix(random, width, dof), matrix(random, width, width)];
            let maps = maps!(
                network!(f32, weights.clone(), damping),
                network!(f64, weights.clone(), damping)
            );
            ("network", maps, 1.0)
        }
        false => {
            let (matrix, frequency) = stiff(random, dof);
            let maps = maps!(
                stiffness!(f32, matrix, frequency, damping),
                stiffness!(f64, matrix, frequency, damping)
            );
            ("stiffness matrix", maps, frequency)
        }
    };
    let radius = random.between(0.2, 0.6);
    let on = Circle::with_radii(
        random.row(dof, -1.0, 1.0),
        random
            .row(dof, -1.0, 1.0)
            .iter()
            .map(|p| p * frequency)
            .collect(),
        vec![radius; dof],
        vec![radius * frequency; dof],
    )
    .unwrap();
    let truth = Truth::of(match damping > 0.0 {
        true => Expected::NotSymplectic,
        false => Expected::Symplectic {
            most_digits: if single { 9.5 } else { f64::INFINITY },
        },
    });
    let label = format!(
        "{what} d = {dof}, {}, damped by {damping:.2}",
        if single { "f32" } else { "f64" }
    );
    Member::new(label, map, on, halvings(random.between(0.4, 1.0), 8), truth)
        .in_full_precision(exact)
}

//! Symplectic steps with noise that differs from call to call: they are symplectic, to the digits that the noise leaves, or draw
//! random numbers.

use std::sync::Arc;

use crate::truth_set::batches::{map_of_batches, small_system};
use crate::truth_set::member::{Expected, Member, Truth, halvings, map_of};
use crate::truth_set::methods::leapfrog;
use crate::truth_set::random::Random;
use crate::truth_set::systems::{MAX_DOF, System};

pub const COUNT: usize = 240;

/// A standard normal number (Box & Muller).
fn normal(random: &mut Random) -> f64 {
    let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
    radius * (std::f64::consts::TAU * random.unit()).cos()
}

/// Noise of all momenta, or of one row in some, in units of a size.
type Source = fn(&mut Random) -> f64;

fn cauchy(random: &mut Random) -> f64 {
    (std::f64::consts::PI * (random.unit() - 0.5)).tan()
}

fn uniform(random: &mut Random) -> f64 {
    random.between(-1.0, 1.0)
}

/// Noise that is added to the momenta, of one state in a number of them.
fn added(random: &mut Random, kind: usize) -> Member {
    let system = small_system(random);
    let (name, source, size, one_in): (_, Source, f64, usize) = match kind {
        0 => ("normal", normal, random.log_between(1e-14, 1e-1), 1),
        1 => ("heavy tails", cauchy, random.log_between(1e-15, 1e-4), 1),
        2 => {
            let one_in = random.whole(20, 600);
            ("rare", uniform, random.log_between(1e-13, 1e-7), one_in)
        }
        _ => ("last bits", uniform, 4.0 * f64::EPSILON, 1),
    };
    let leap = leapfrog(&system);
    let exact = map_of(system.dof(), leap.clone());
    let mut numbers = Random::of(32, random.seed() as usize & 0xFFFF);
    let map = map_of_batches(system.dof(), move |h, rows| {
        for (q, p) in rows {
            leap(h, q, p);
            if numbers.whole(1, one_in) == 1 {
                p.iter_mut().for_each(|p| *p += size * source(&mut numbers));
            }
        }
    });
    let label = format!(
        "{} d = {}, {name} {size:.0e}, one in {one_in}",
        system.name,
        system.dof()
    );
    noisy(label, map, exact, &system, random)
}

fn noisy(
    label: String,
    map: Arc<dyn symplint::TimeAdvance>,
    exact: Arc<dyn symplint::TimeAdvance>,
    system: &System,
    random: &mut Random,
) -> Member {
    let h = random.between(0.4, 1.0) / system.omega;
    let truth = Truth::of(Expected::Noisy {
        most_digits: f64::INFINITY,
    });
    Member::new(label, map, system.on.circle(), halvings(h, 8), truth).in_full_precision(exact)
}

/// Forces that are summed up in parts, in an order that differs from call to call.
fn parallel_sums(random: &mut Random) -> Member {
    let system = small_system(random);
    let single = random.chance(0.4);
    let parts = random.whole(4, 64);
    // Parts that nearly cancel.
    let large = random.log_between(1.0, 1e3);
    let force = system.force.clone();
    let mut numbers = Random::of(33, random.seed() as usize & 0xFFFF);
    let masses = system.masses.clone();
    let map = map_of_batches(system.dof(), move |h, rows| {
        for (q, p) in rows {
            let mut f = [0.0; MAX_DOF];
            force(q, &mut f[..q.len()]);
            for (i, p) in p.iter_mut().enumerate() {
                let first = numbers.whole(0, parts - 1);
                let part = |k: usize| f[i] / parts as f64 + large * (k as f64 * 2.4).sin();
                let terms = (0..parts).map(|k| (first + k) % parts);
                let (sum, offset) = match single {
                    true => {
                        let of = |x: f64| x as f32;
                        let sum: f32 = terms.clone().map(|k| of(part(k))).sum();
                        let offset: f32 =
                            (0..parts).map(|k| of(part(k) - f[i] / parts as f64)).sum();
                        (f64::from(sum), f64::from(offset))
                    }
                    false => (
                        terms.clone().map(part).sum::<f64>(),
                        (0..parts)
                            .map(|k| part(k) - f[i] / parts as f64)
                            .sum::<f64>(),
                    ),
                };
                *p += h * (sum - offset);
            }
            for ((q, p), m) in q.iter_mut().zip(&*p).zip(&masses) {
                *q += h * p / m;
            }
        }
    });
    let exact = map_of(system.dof(), leapfrog(&system));
    let label = format!(
        "{} d = {}, parallel sums of {parts} parts, {}",
        system.name,
        system.dof(),
        if single { "f32" } else { "f64" }
    );
    noisy(label, map, exact, &system, random)
}

/// The implicit midpoint rule, its iteration started at random and stopped at a tolerance.
fn random_start(random: &mut Random) -> Member {
    let system = small_system(random);
    let tolerance = random.log_between(1e-14, 1e-6);
    let dof = system.dof();
    let (force, masses) = (system.force.clone(), system.masses.clone());
    let midpoint = move |h: f64,
                         q: &mut [f64],
                         p: &mut [f64],
                         start: &mut dyn FnMut() -> f64,
                         tolerance: f64| {
        let mut middle: Vec<f64> = q.iter().map(|q| q + start()).collect();
        let mut f = [0.0; MAX_DOF];
        for _ in 0..200 {
            force(&middle, &mut f[..dof]);
            let mut moved = 0.0f64;
            for i in 0..dof {
                let next = q[i] + 0.5 * h * (p[i] + 0.5 * h * f[i]) / masses[i];
                moved = moved.max((next - middle[i]).abs());
                middle[i] = next;
            }
            if moved <= tolerance {
                break;
            }
        }
        for i in 0..dof {
            q[i] = 2.0 * middle[i] - q[i];
            p[i] += h * f[i];
        }
    };
    let mut numbers = Random::of(34, random.seed() as usize & 0xFFFF);
    let solved = midpoint.clone();
    let map = map_of_batches(dof, move |h, rows| {
        for (q, p) in rows {
            midpoint(h, q, p, &mut || numbers.between(-0.1, 0.1), tolerance);
        }
    });
    let exact = map_of(
        dof,
        Arc::new(move |h, q, p| solved(h, q, p, &mut || 0.0, 1e-15)),
    );
    let label = format!(
        "{} d = {dof}, solver to {tolerance:.0e} from a random start",
        system.name
    );
    noisy(label, map, exact, &system, random)
}

pub fn member(index: usize) -> Member {
    let random = &mut Random::of(35, index);
    match index % 8 {
        kind @ 0..=3 => added(random, kind),
        4 => added(random, 0),
        5 => parallel_sums(random),
        6 => random_start(random),
        _ => added(random, 2),
    }
}

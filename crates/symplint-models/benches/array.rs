//! A Strang step of many coupled pendula compared with the time to stream what it must read and write, and
//! with a plain scalar control, in one interleaved run.
//!
//! `cargo bench -p symplint-models --bench array [-- PART OF A NAME]`. Compared with streaming, a ratio of 0.33 or more is
//! a step within three times the time of streaming.

mod interleaved;

use std::hint::black_box;

use interleaved::{heading, report};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use symplint::Ensemble;
use symplint_models::integrators::{Splitting, Variant, splitting_methods};
use symplint_models::systems::PendulumArray;

const PENDULA: usize = 4096;
const SAMPLES: usize = 4096;
const ALPHA: f64 = 1.0;
const K: f64 = 1.0;
/// So small that states stay where they are, however long the bench runs.
const H: f64 = 1e-9;

/// States of the pendula, two numbers each.
const STATES: f64 = (PENDULA * SAMPLES) as f64;

fn main() {
    heading(&format!("{PENDULA} pendula, {SAMPLES} samples, each"));
    let one = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let two = ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let array = PendulumArray::new(PENDULA, ALPHA, K).unwrap();
    let method = splitting_methods::strang(Variant::PositionFirst);
    let step = Splitting::new(method, array);
    let mut ensemble = ensemble();
    let mut advance = |pool: &ThreadPool| pool.install(|| ensemble.advance(&step, H).unwrap());
    let (mut q, mut p) = (numbers(1), numbers(2));

    let mut measure = |name, pool: &ThreadPool| {
        let step = || advance(pool);
        report(name, STATES, STATES, step, || stream(pool, &mut q, &mut p));
    };
    measure("step, 1 thread | streaming", &one);
    measure("step, 2 threads | streaming", &two);
    let mut again = self::ensemble();
    report(
        "step, 2 threads | 1 thread",
        STATES,
        STATES,
        || advance(&two),
        || one.install(|| again.advance(&step, H).unwrap()),
    );
    report(
        "step, 1 thread | plain scalar",
        STATES,
        STATES,
        || advance(&one),
        || plain_step(&mut q, &mut p),
    );
}

/// As many numbers as there are positions, all different.
fn numbers(salt: usize) -> Vec<f64> {
    (0..PENDULA * SAMPLES)
        .map(|i| 6.0 * (0.618_033_988_749_895 * (i + salt) as f64).fract() - 3.0)
        .collect()
}

fn ensemble() -> Ensemble {
    let mut ensemble = Ensemble::zeros(PENDULA, SAMPLES);
    let (q, p) = (numbers(1), numbers(2));
    let mut block = ensemble.block();
    for (i, (q, p)) in q.chunks(SAMPLES).zip(p.chunks(SAMPLES)).enumerate() {
        block.q.row_mut(i).copy_from_slice(q);
        block.p.row_mut(i).copy_from_slice(p);
    }
    ensemble
}

/// Reads and writes all positions and momenta once, in the order in which they lie.
fn stream(pool: &ThreadPool, q: &mut [f64], p: &mut [f64]) {
    let share = q.len() / pool.current_num_threads();
    let factor = black_box(1.0);
    pool.install(|| {
        (q.par_chunks_mut(share).zip(p.par_chunks_mut(share))).for_each(|(q, p)| {
            for (q, p) in q.iter_mut().zip(p) {
                *q *= factor;
                *p *= factor;
            }
        });
    });
}

/// The same step written down plainly: whole rows, one after the other.
fn plain_step(q: &mut [f64], p: &mut [f64]) {
    drift(0.5 * H, p, q);
    let row = |i: usize| (i % PENDULA) * SAMPLES;
    for i in 0..PENDULA {
        let (left, middle, right) = (row(i + PENDULA - 1), row(i), row(i + 1));
        for k in 0..SAMPLES {
            let spring = q[right + k] - 2.0 * q[middle + k] + q[left + k];
            p[middle + k] += H * (ALPHA * q[middle + k].sin() + K * spring);
        }
    }
    drift(0.5 * H, p, q);
}

fn drift(tau: f64, p: &[f64], q: &mut [f64]) {
    for (q, p) in q.iter_mut().zip(p) {
        *q += tau * p;
    }
}

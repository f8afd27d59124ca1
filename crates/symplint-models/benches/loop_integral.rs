//! The loop integral compared with reading its arrays, its transform alone, finite differences, a plain one, and numpy.
//!
//! `cargo bench -p symplint-models --bench loop_integral [-- PART OF A NAME]`. The comparison with numpy
//! runs where `python3` has it.

mod interleaved;
mod plain_integral;

use std::f64::consts::{PI, TAU};
use std::hint::black_box;
use std::process::Command;

use interleaved::{heading, report, wanted};
use plain_integral::PlainIntegral;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use rustfft::FftPlanner;
use rustfft::num_complex::Complex64;
use symplint::rules::Cutoffs;
use symplint::{Ensemble, LoopIntegral, Rule};

/// Degrees of freedom and samples: beyond all caches, and within the last.
const SHAPES: [(usize, usize); 3] = [(4096, 4096), (256, 4096), (4096, 256)];

fn main() {
    let pools = [pool(1), pool(2)];
    for (dof, samples) in SHAPES {
        let ensemble = circles(dof, samples);
        let rows = dof as f64;
        heading(&format!("{dof} x {samples}, a degree of freedom"));
        for (name, rule) in [
            ("auto", Rule::Auto),
            ("pseudospectral", Rule::Pseudospectral),
        ] {
            for pool in &pools {
                report(
                    &format!("{name}, {} | reading", number(pool)),
                    rows,
                    rows,
                    || integrate(pool, &ensemble, &rule),
                    || read(pool, &ensemble),
                );
            }
        }
        report(
            "auto, 1 thread | pseudospectral",
            rows,
            rows,
            || integrate(&pools[0], &ensemble, &Rule::Auto),
            || integrate(&pools[0], &ensemble, &Rule::Pseudospectral),
        );
        report(
            "auto, 2 threads | 1 thread",
            rows,
            rows,
            || integrate(&pools[1], &ensemble, &Rule::Auto),
            || integrate(&pools[0], &ensemble, &Rule::Auto),
        );
        let finite_difference = Rule::FiniteDifference(Cutoffs::none());
        report(
            "finite-difference, 1 thread | reading",
            rows,
            rows,
            || integrate(&pools[0], &ensemble, &finite_difference),
            || read(&pools[0], &ensemble),
        );
        report(
            "pseudospectral, 1 thread | finite-diff.",
            rows,
            rows,
            || integrate(&pools[0], &ensemble, &Rule::Pseudospectral),
            || integrate(&pools[0], &ensemble, &finite_difference),
        );
        let mut transform = transform(samples);
        report(
            "pseudospectral, 1 thread | its transform",
            rows,
            1.0,
            || integrate(&pools[0], &ensemble, &Rule::Pseudospectral),
            &mut transform,
        );
        report(
            "pseudospectral, 2 threads | 1 thread",
            rows,
            rows,
            || integrate(&pools[1], &ensemble, &Rule::Pseudospectral),
            || integrate(&pools[0], &ensemble, &Rule::Pseudospectral),
        );
        let mut plain = PlainIntegral::new(samples);
        assert!((plain.of(&ensemble) / (PI * rows) - 1.0).abs() < 1e-10);
        report(
            "pseudospectral, 1 thread | plain",
            rows,
            rows,
            || integrate(&pools[0], &ensemble, &Rule::Pseudospectral),
            || {
                black_box(plain.of(&ensemble));
            },
        );
        beside_numpy(&pools, &ensemble);
    }
}

fn pool(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap()
}

/// The threads of a pool, as a name has them.
fn number(pool: &ThreadPool) -> &'static str {
    if pool.current_num_threads() == 1 {
        "1 thread"
    } else {
        "2 threads"
    }
}

/// Unit circles with different phases. Angles stay below one turn: the rounding of larger ones is noise that loops do not have.
fn circles(dof: usize, samples: usize) -> Ensemble {
    let mut ensemble = Ensemble::zeros(dof, samples);
    let mut block = ensemble.block();
    for i in 0..dof {
        let at = |k: usize| TAU * ((k + 37 * i) % samples) as f64 / samples as f64;
        for (k, q) in block.q.row_mut(i).iter_mut().enumerate() {
            *q = at(k).sin();
        }
        for (k, p) in block.p.row_mut(i).iter_mut().enumerate() {
            *p = at(k).cos();
        }
    }
    ensemble
}

fn integrate(pool: &ThreadPool, ensemble: &Ensemble, rule: &Rule) {
    black_box(pool.install(|| LoopIntegral::of(ensemble, rule)).unwrap());
}

/// The complex transform of one degree of freedom, in cache.
fn transform(samples: usize) -> impl FnMut() {
    let transform = FftPlanner::new().plan_fft_forward(samples);
    let mut scratch = vec![Complex64::ZERO; transform.get_inplace_scratch_len()];
    let row: Vec<Complex64> = (0..samples)
        .map(|k| Complex64::cis(TAU * k as f64 / samples as f64))
        .collect();
    let mut modes = row.clone();
    move || {
        modes.copy_from_slice(&row);
        transform.process_with_scratch(&mut modes, &mut scratch);
        black_box(&modes);
    }
}

/// Reads every value once: a sum in enough lanes that it waits for memory only.
fn read(pool: &ThreadPool, ensemble: &Ensemble) {
    let (q, p) = (ensemble.q(), ensemble.p());
    let row = |i: usize| {
        let mut lanes = [0.0; 32];
        for row in [q.row(i), p.row(i)] {
            for chunk in row.as_chunks::<32>().0 {
                for (lane, value) in lanes.iter_mut().zip(chunk) {
                    *lane += value;
                }
            }
        }
        lanes.iter().sum::<f64>()
    };
    let sum = || (0..ensemble.dof()).into_par_iter().map(row).sum::<f64>();
    black_box(pool.install(sum));
}

/// numpy runs by itself, between two of our runs, not in turn.
fn beside_numpy(pools: &[ThreadPool], ensemble: &Ensemble) {
    let rows = ensemble.dof() as f64;
    for (of, rule) in [
        ("auto", Rule::Auto),
        ("pseudospectral", Rule::Pseudospectral),
    ] {
        for pool in pools {
            let name = format!("{of}, {} | numpy", number(pool));
            if !wanted(&name) {
                continue;
            }
            match numpy(ensemble.dof(), ensemble.samples()) {
                Some(time) => interleaved::compare(
                    &name,
                    rows,
                    || integrate(pool, ensemble, &rule),
                    time / rows,
                ),
                None => println!("{name}: no python3 with numpy here"),
            }
        }
    }
}

/// ns for the same sum with numpy's real transforms, on one thread.
fn numpy(dof: usize, samples: usize) -> Option<f64> {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/loop_integral.py");
    let shape = [dof.to_string(), samples.to_string()];
    let output = Command::new("python3")
        .arg(script)
        .args(shape)
        .output()
        .ok()?;
    String::from_utf8(output.stdout).ok()?.trim().parse().ok()
}

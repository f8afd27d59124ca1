//! The particle-in-cell force and step compared with a plain scalar control, in one interleaved run.
//!
//! `cargo bench -p symplint-plasma --bench pic [-- PART OF A NAME]`.

#[path = "../../symplint-models/benches/interleaved/mod.rs"]
mod interleaved;
mod pic_control;

use std::hint::black_box;

use interleaved::{heading, report, wanted};
use pic_control::{PlainPic, PlainPlane};
use rayon::ThreadPoolBuilder;
use symplint::state::{Rows, RowsMut};
use symplint::{Block, Circle, Ensemble, TimeAdvance};
use symplint_models::Separable;
use symplint_models::integrators::{Splitting, Variant, splitting_methods};
use symplint_plasma::pic::{ParticleWeights, Pic1d, Pic2d, PicConfig, TwoStream};

const CELLS: usize = 128;
const LENGTH: f64 = 50.0;

fn main() {
    heading(&format!("{CELLS} cells"));
    for degree in 1..=3 {
        for samples in [1, 16] {
            force(degree, 10_000, samples);
        }
    }
    for degree in 1..=3 {
        for samples in [1, 16] {
            force_in_a_plane(degree, 10_000, samples);
        }
    }
    for degree in 1..=3 {
        for particles in [2, 8, 32, 128, 512] {
            strang_step(degree, particles);
        }
    }
    for degree in 1..=3 {
        two_threads(degree, 1000, 256);
    }
    for degree in 1..=3 {
        force_on_two_threads(degree, 1_000_000);
    }
}

fn plasma(degree: usize, particles: usize) -> (Pic1d, PlainPic) {
    let density = 1.0;
    let pic = Pic1d::new(PicConfig {
        weights: ParticleWeights::Equal { particles, density },
        cells: CELLS,
        length: LENGTH,
        degree,
        ..PicConfig::default()
    });
    (
        pic.unwrap(),
        PlainPic::new(degree, CELLS, LENGTH, density * LENGTH / particles as f64),
    )
}

/// One evaluation of the force, per particle and sample.
fn force(degree: usize, particles: usize, samples: usize) {
    let (pic, mut plain) = plasma(degree, particles);
    let (x, _) = TwoStream::default().sample(&pic, 1).unwrap();
    // The same particles in every sample, moved a little from one to the next.
    let q: Vec<f64> = (x.iter())
        .flat_map(|x| (0..samples).map(move |sample| x + 0.01 * sample as f64))
        .collect();
    let mut p = vec![0.0; q.len()];
    let kick = || {
        let q = Rows::new(black_box(&q), particles, samples, samples);
        pic.kick(
            1e-9,
            q,
            &mut RowsMut::new(&mut p, particles, samples, samples),
        );
    };
    let mut v = vec![0.0; particles];
    let control = || plain.kick(1e-9, black_box(&x), &mut v);
    report(
        &format!("force a particle, degree {degree}, {samples} samples"),
        (particles * samples) as f64,
        particles as f64,
        kick,
        control,
    );
}

/// One evaluation of the force in a square of 64 by 64 cells, per particle and sample.
fn force_in_a_plane(degree: usize, particles: usize, samples: usize) {
    const CELLS: usize = 64;
    let name = format!("force in a plane, degree {degree}, {samples} samples");
    if !wanted(&name) {
        return;
    }
    let pic = Pic2d::new(PicConfig {
        weights: ParticleWeights::Each(vec![1.0; particles]),
        cells: CELLS,
        length: LENGTH,
        degree,
        ..PicConfig::default()
    });
    let pic = pic.unwrap();
    let mut plain = PlainPlane::new(degree, CELLS, LENGTH, 1.0);
    let coordinate = |a: usize, step: f64| LENGTH * (a as f64 * step).fract();
    let x: Vec<f64> = (0..particles)
        .flat_map(|a| [coordinate(a, 0.754_877_666), coordinate(a, 0.569_840_291)])
        .collect();
    let q: Vec<f64> = (x.iter())
        .flat_map(|x| (0..samples).map(move |sample| x + 0.01 * sample as f64))
        .collect();
    let (dof, mut p, mut v) = (x.len(), vec![0.0; q.len()], vec![0.0; x.len()]);
    let mut kick = || {
        let q = Rows::new(black_box(&q), dof, samples, samples);
        pic.kick(1.0, q, &mut RowsMut::new(&mut p, dof, samples, samples));
    };
    let mut control = || plain.kick(1.0, black_box(&x), &mut v);
    kick();
    control();
    let scale = v.iter().fold(0.0, |scale: f64, v| scale.max(v.abs()));
    for (row, v) in p.chunks_exact(samples).zip(&v) {
        assert!((row[0] - v).abs() < 1e-10 * scale, "{} for {v}", row[0]);
    }
    let mut kick = || {
        let q = Rows::new(black_box(&q), dof, samples, samples);
        pic.kick(1e-9, q, &mut RowsMut::new(&mut p, dof, samples, samples));
    };
    let control = || plain.kick(1e-9, black_box(&x), &mut v);
    report(
        &name,
        (particles * samples) as f64,
        particles as f64,
        &mut kick,
        control,
    );
}

/// One position-first Strang step of one sample: a force and two drifts.
fn strang_step(degree: usize, particles: usize) {
    const H: f64 = 1e-6;
    let (pic, mut plain) = plasma(degree, particles);
    let (x, v) = TwoStream::default().sample(&pic, 1).unwrap();
    let step = Splitting::new(splitting_methods::strang(Variant::PositionFirst), pic);
    let (mut q, mut p) = (x.clone(), v.clone());
    let advance = || {
        let mut block = Block::new(
            RowsMut::new(&mut q, particles, 1, 1),
            RowsMut::new(&mut p, particles, 1, 1),
        );
        step.advance(H, black_box(&mut block)).unwrap();
    };
    let (mut x, mut v) = (x, v);
    let drift = |x: &mut [f64], v: &[f64]| {
        for (x, v) in x.iter_mut().zip(v) {
            *x += 0.5 * H * v;
        }
    };
    let control = || {
        drift(&mut x, &v);
        plain.kick(H, black_box(&x), &mut v);
        drift(&mut x, &v);
    };
    report(
        &format!("Strang step, degree {degree}, {particles} particles"),
        1.0,
        1.0,
        advance,
        control,
    );
}

/// A Strang step of an ensemble on two threads compared with the same on one.
fn two_threads(degree: usize, particles: usize, samples: usize) {
    let (pic, _) = plasma(degree, particles);
    let (x, v) = TwoStream::default().sample(&pic, 1).unwrap();
    let circle = Circle::new(x, v, 1.0).unwrap();
    let step = Splitting::new(splitting_methods::strang(Variant::PositionFirst), pic);
    let ensemble = Ensemble::sample(&circle, samples).unwrap();
    let on = |threads: usize| {
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let (mut ensemble, step) = (ensemble.clone(), &step);
        move || pool.install(|| ensemble.advance(step, 1e-6)).unwrap()
    };
    report(
        &format!("step, degree {degree}, 2 threads | 1 thread"),
        (particles * samples) as f64,
        (particles * samples) as f64,
        on(2),
        on(1),
    );
}

/// One force of one sample on two threads compared with the same on one.
fn force_on_two_threads(degree: usize, particles: usize) {
    let (pic, _) = plasma(degree, particles);
    let (x, _) = TwoStream::default().sample(&pic, 1).unwrap();
    let on = |threads: usize| {
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let (mut p, x, pic) = (vec![0.0; particles], &x, &pic);
        move || {
            let q = Rows::new(black_box(x), particles, 1, 1);
            let p = &mut RowsMut::new(&mut p, particles, 1, 1);
            pool.install(|| pic.kick(1e-9, q, p));
        }
    };
    report(
        &format!("force, degree {degree}, 1e6, 2 threads | 1 thread"),
        particles as f64,
        particles as f64,
        on(2),
        on(1),
    );
}

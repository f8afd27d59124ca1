//! One kernel, run as often as asked, for counting its instructions.
//!
//! `KERNEL TIMES` runs it, no argument names the kernels with what a run works on.
//! `instructions.py` next to this file runs them under valgrind and writes the table.

use std::f64::consts::TAU;
use std::hint::black_box;

use rayon::ThreadPoolBuilder;
use symplint::rules::{Cutoffs, Piecewise};
use symplint::state::{Rows, RowsMut};
use symplint::{Block, Circle, Ensemble, LoopIntegral, Rule, TimeAdvance};
use symplint_models::Separable;
use symplint_models::integrators::{Splitting, Variant, splitting_methods};
use symplint_models::systems::{AbsoluteValue, PendulumArray};
use symplint_plasma::pic::{ParticleWeights, Pic1d, PicConfig, TwoStream};

/// A kernel: its name, what one run works on, how many of these, and the run.
struct Kernel {
    name: &'static str,
    unit: &'static str,
    units: usize,
    run: fn() -> Box<dyn FnMut() + Send>,
}

const KERNELS: &[Kernel] = &[
    Kernel {
        name: "pseudospectral 16 x 4096",
        unit: "sample and degree of freedom",
        units: 16 * 4096,
        run: || integral(16, 4096, Rule::Pseudospectral),
    },
    Kernel {
        name: "pseudospectral 16 x 1000",
        unit: "sample and degree of freedom",
        units: 16 * 1000,
        run: || integral(16, 1000, Rule::Pseudospectral),
    },
    Kernel {
        name: "finite-difference 16 x 4096",
        unit: "sample and degree of freedom",
        units: 16 * 4096,
        run: || integral(16, 4096, Rule::FiniteDifference(Cutoffs::none())),
    },
    Kernel {
        name: "piecewise |q|",
        unit: "loop",
        units: 1,
        run: piecewise,
    },
    Kernel {
        name: "pic force, degree 1, 1000 x 16",
        unit: "particle and sample",
        units: 16_000,
        run: || force(1),
    },
    Kernel {
        name: "pic force, degree 2, 1000 x 16",
        unit: "particle and sample",
        units: 16_000,
        run: || force(2),
    },
    Kernel {
        name: "pic force, degree 3, 1000 x 16",
        unit: "particle and sample",
        units: 16_000,
        run: || force(3),
    },
    Kernel {
        name: "pic Strang step, degree 3, 128 x 1",
        unit: "particle and sample",
        units: 128,
        run: || strang(plasma(3, 128), 1),
    },
    Kernel {
        name: "array Strang step, 64 x 256",
        unit: "pendulum and sample",
        units: 64 * 256,
        run: || strang(PendulumArray::new(64, 1.0, 1.0).unwrap(), 256),
    },
];

fn main() {
    let mut arguments = std::env::args()
        .skip(1)
        .filter(|argument| argument != "--bench");
    let Some(name) = arguments.next() else {
        for kernel in KERNELS {
            println!("{}\t{}\t{}", kernel.name, kernel.units, kernel.unit);
        }
        return;
    };
    let kernel = KERNELS
        .iter()
        .find(|kernel| kernel.name == name)
        .expect("a kernel's name");
    let times: usize = arguments
        .next()
        .and_then(|times| times.parse().ok())
        .expect("a number");
    let mut run = (kernel.run)();
    // All runs within one task: threads that wait for each other would count, too.
    let pool = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| (0..times).for_each(|_| run()));
}

fn integral(dof: usize, samples: usize, rule: Rule) -> Box<dyn FnMut() + Send> {
    let mut ensemble = Ensemble::zeros(dof, samples);
    let mut block = ensemble.block();
    for i in 0..dof {
        let at = |k: usize| TAU * k as f64 / samples as f64 + i as f64;
        for (k, q) in block.q.row_mut(i).iter_mut().enumerate() {
            *q = at(k).sin();
        }
        for (k, p) in block.p.row_mut(i).iter_mut().enumerate() {
            *p = at(k).cos();
        }
    }
    Box::new(move || {
        black_box(LoopIntegral::of(&ensemble, &rule).unwrap());
    })
}

/// A step that breaks the unit circle twice.
fn piecewise() -> Box<dyn FnMut() + Send> {
    let step = Splitting::new(
        splitting_methods::strang(Variant::PositionFirst),
        AbsoluteValue::new(0.0).unwrap(),
    );
    let circle = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
    Box::new(move || {
        black_box(Piecewise::default().integrate(&step, &circle, 0.5).unwrap());
    })
}

fn plasma(degree: usize, particles: usize) -> Pic1d {
    Pic1d::new(PicConfig {
        weights: ParticleWeights::Equal {
            particles,
            density: 1.0,
        },
        cells: 128,
        length: 50.0,
        degree,
        ..PicConfig::default()
    })
    .unwrap()
}

fn force(degree: usize) -> Box<dyn FnMut() + Send> {
    let (particles, samples) = (1000, 16);
    let pic = plasma(degree, particles);
    let (x, _) = TwoStream::default().sample(&pic, 1).unwrap();
    let q: Vec<f64> = (x.iter())
        .flat_map(|x| (0..samples).map(move |sample| x + 0.01 * sample as f64))
        .collect();
    let mut p = vec![0.0; q.len()];
    Box::new(move || {
        let q = Rows::new(black_box(&q), particles, samples, samples);
        pic.kick(
            1e-9,
            q,
            &mut RowsMut::new(&mut p, particles, samples, samples),
        );
    })
}

/// Small steps, so that every run does about the same.
fn strang<S: Separable + 'static>(system: S, samples: usize) -> Box<dyn FnMut() + Send> {
    let dof = system.dof();
    let step = Splitting::new(splitting_methods::strang(Variant::PositionFirst), system);
    let mut q: Vec<f64> = (0..dof * samples)
        .map(|k| (0.3 * k as f64) % 50.0)
        .collect();
    let mut p = vec![0.1; q.len()];
    Box::new(move || {
        let mut block = Block::new(
            RowsMut::new(&mut q, dof, samples, samples),
            RowsMut::new(&mut p, dof, samples, samples),
        );
        step.advance(1e-9, black_box(&mut block)).unwrap();
    })
}

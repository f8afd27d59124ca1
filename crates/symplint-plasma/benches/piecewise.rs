//! The piecewise rule compared with the bare evaluations that it makes: what finding breaks and integrating pieces
//! costs on top.
//!
//! `cargo bench -p symplint-plasma --bench piecewise [-- PART OF A NAME]`. The control makes and advances as many
//! samples, in full blocks; the ratio is the share of the rule's time that they take.

#[path = "../../symplint-models/benches/interleaved/mod.rs"]
mod interleaved;

use std::hint::black_box;

use interleaved::{heading, report};
use rayon::ThreadPoolBuilder;
use symplint::rules::Piecewise;
use symplint::{Circle, Ensemble, Loop, PerSample, TimeAdvance};
use symplint_models::integrators::{Splitting, Variant, splitting_methods};
use symplint_plasma::pic::{ParticleWeights, Pic1d, PicConfig, TwoStream};

const H: f64 = 0.1;

fn main() {
    let one = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    heading("the piecewise rule, 1 thread, an evaluation");
    one.install(|| {
        beside_evaluations("|q|, 2 breaks", &abs_potential(), &circle(&[0.0], &[0.0]));
        for (particles, degree) in [(2, 1), (16, 1), (128, 1), (2, 2), (128, 3)] {
            let (step, circle) = plasma(particles, degree);
            let name = format!("plasma, {particles} particles, degree {degree}");
            beside_evaluations(&name, &step, &circle);
        }
    });
}

fn beside_evaluations(name: &str, map: &dyn TimeAdvance, phase_loop: &dyn Loop) {
    let rule = Piecewise::default();
    let evaluations = (rule.integrate(map, phase_loop, H).unwrap()).evaluations;
    report(
        name,
        evaluations as f64,
        evaluations as f64,
        || {
            black_box(rule.integrate(map, phase_loop, H).unwrap());
        },
        || {
            let mut ensemble = Ensemble::sample(phase_loop, evaluations).unwrap();
            ensemble.advance(map, H).unwrap();
            black_box(ensemble);
        },
    );
}

fn circle(q: &[f64], p: &[f64]) -> Circle {
    Circle::new(q.to_vec(), p.to_vec(), 1.0).unwrap()
}

/// Position-first Strang splitting of H = p²/2 + |q|.
fn abs_potential() -> impl TimeAdvance {
    PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        q[0] += 0.5 * h * p[0];
        p[0] -= h * q[0].signum();
        q[0] += 0.5 * h * p[0];
    })
}

/// The same of a plasma of the paper, with a unit circle in each particle.
fn plasma(particles: usize, degree: usize) -> (impl TimeAdvance, Circle) {
    let weights = ParticleWeights::Equal {
        particles,
        density: 1.0,
    };
    let config = PicConfig {
        weights,
        degree,
        ..PicConfig::default()
    };
    let pic = Pic1d::new(config).unwrap();
    let (x, v) = TwoStream::default().sample(&pic, 1).unwrap();
    let method = splitting_methods::strang(Variant::PositionFirst);
    (Splitting::new(method, pic), circle(&x, &v))
}

//! The discrete gradient of Gonzalez on a plasma: the energy it conserves, and the step back.

use std::sync::Arc;

use crate::common::{State, distance, stepped};
use symplint::state::Rows;
use symplint_models::Hamiltonian;
use symplint_models::integrators::catalogue::build;
use symplint_plasma::pic::{Landau, ParticleWeights, Pic1d, PicConfig};

const H: f64 = 0.2;

fn plasma() -> (Arc<Pic1d>, State) {
    let pic = Pic1d::new(PicConfig {
        weights: ParticleWeights::Each(vec![0.5, 1.5, 0.8, 1.2]),
        cells: 8,
        length: 6.0,
        degree: 3,
        ..PicConfig::default()
    });
    let start = Landau::default().sample_box::<1>(4, 6.0, 3).unwrap();
    (Arc::new(pic.unwrap()), start)
}

#[test]
fn the_energy_is_conserved_over_many_steps() {
    let (pic, start) = plasma();
    let energy = |(q, p): &State| {
        let mut out = [0.0];
        pic.energy(Rows::new(q, 4, 1, 1), Rows::new(p, 4, 1, 1), &mut out);
        out[0]
    };
    // The largest change in a step, and that in all of them.
    let drift = |integrator: &str| {
        let map = build(integrator, None, Arc::clone(&pic)).unwrap();
        let (mut state, mut worst) = (start.clone(), 0f64);
        for _ in 0..200 {
            let before = energy(&state);
            state = stepped(&*map, H, &state);
            worst = worst.max((energy(&state) - before).abs() / before.abs().max(1.0));
        }
        let overall = (energy(&state) - energy(&start)).abs() / energy(&start).abs().max(1.0);
        (worst, overall)
    };
    let (worst, overall) = drift("discrete-gradient");
    assert!(worst < 1e-14 && overall < 2e-13, "{worst:e}, {overall:e}");
    let (midpoint, _) = drift("implicit-midpoint");
    assert!(midpoint > 1e-8, "{midpoint:e}");
}

#[test]
fn a_step_back_undoes_a_step() {
    let (pic, start) = plasma();
    let map = build("discrete-gradient", None, pic).unwrap();
    let back = stepped(&*map, -H, &stepped(&*map, H, &start));
    let off = distance(&back, &start);
    assert!(off < 2e-14, "{off:e}");
}

//! Loop integrals before and after a step: the rule of Barham & Burby, that forces must be continuous, carries over.

use symplint::loops::FourierLoop;
use symplint::state::Rows;
use symplint::{Defect, Ensemble, LoopIntegral, Rule, TimeAdvance};
use symplint_models::gempic::{Gempic, GempicConfig};
use symplint_models::integrators::{PartSplitting, Variant, splitting_methods};
use symplint_models::pic::ParticleWeights;

use crate::reference::random_state;

const H: f64 = 0.25;
const SAMPLES: usize = 4096;

/// Four electrons on 8 cells of a box of length 2π, and a loop of three Fourier modes round a random state.
fn plasma(degree: usize) -> (PartSplitting<Gempic>, FourierLoop) {
    let gempic = Gempic::new(GempicConfig {
        degree,
        weights: ParticleWeights::Each(vec![1.0, 0.8, 1.2, 0.9]),
        charge: 1.0,
        ..GempicConfig::default()
    });
    let gempic = gempic.unwrap();
    let (q, p) = gempic.state(&random_state(&gempic, 11)).unwrap();
    let radii: Vec<f64> = (0..q.len())
        .map(|i| if i < 8 { 0.5 } else { 0.2 })
        .collect();
    let phase_loop = FourierLoop::random(q, p, &radii, &radii, 5).unwrap();
    let method = splitting_methods::strang(Variant::PositionFirst);
    (PartSplitting::new(&method, gempic), phase_loop)
}

/// The relative loop defect at equispaced samples of what `advance` does.
fn defect(
    map: &dyn TimeAdvance,
    phase_loop: &FourierLoop,
    samples: usize,
    advance: impl FnOnce(&mut Ensemble),
) -> f64 {
    let mut ensemble = Ensemble::sample(phase_loop, samples).unwrap();
    let coordinates = map.coordinates();
    let integral = |ensemble: &Ensemble| {
        LoopIntegral::in_coordinates(ensemble, &Rule::Pseudospectral, &coordinates).unwrap()
    };
    let before = integral(&ensemble);
    advance(&mut ensemble);
    Defect::between(&before, &integral(&ensemble))
        .unwrap()
        .magnitude()
}

/// The defect of a step, at so many samples.
fn step_defect(degree: usize, samples: usize) -> f64 {
    let (step, phase_loop) = plasma(degree);
    defect(&step, &phase_loop, samples, |ensemble| {
        ensemble.advance(&step, H).unwrap()
    })
}

/// Of every substep taken alone.
fn substep_defects(degree: usize) -> Vec<(String, f64)> {
    let (step, phase_loop) = plasma(degree);
    (0..step.substeps())
        .map(|substep| {
            let alone = defect(&step, &phase_loop, SAMPLES, |ensemble| {
                step.advance_substep(substep, H, &mut ensemble.block())
                    .unwrap();
            });
            (step.substep_name(substep), alone)
        })
        .collect()
}

/// A prototype in NumPy, with other random numbers, found 3e-8, 7e-12 and 3e-15 for p = 2, 3 and 4, all of them
/// quadrature errors, as here: they fall with the number of samples.
#[test]
fn continuous_forces_conserve_loop_integrals() {
    for (degree, bound) in [(2, 1e-7), (3, 1e-11), (4, 1e-14), (5, 1e-14)] {
        let [coarse, fine, finest] =
            [SAMPLES / 8, SAMPLES, 8 * SAMPLES].map(|samples| step_defect(degree, samples));
        println!("degree {degree}: {coarse:.1e}, {fine:.1e}, {finest:.1e}");
        assert!(fine < bound, "degree {degree}: {fine:e}");
        assert!(
            finest < (0.1 * bound).max(2e-15),
            "degree {degree}: {finest:e}"
        );
    }
}

/// At p = 1, E1 and B jump at nodes. The prototype found 4.3e-3 for the step, 4.6e-3 for H_p1 and 3e-4 for H_p2.
#[test]
fn discontinuous_forces_break_loops() {
    let [coarse, fine] = [SAMPLES, 8 * SAMPLES].map(|samples| step_defect(1, samples));
    println!("degree 1: {coarse:.2e}, {fine:.2e}");
    assert!(
        fine > 1e-3 && (coarse / fine - 1.0).abs() < 0.05,
        "{coarse:e}, {fine:e}"
    );
    for (name, defect) in substep_defects(1) {
        println!("    {name}: {defect:.1e}");
        // H_E kicks velocities by a field that jumps, and canonical momenta by nothing.
        let is_broken = name.starts_with("H_p1") || name.starts_with("H_p2");
        let as_expected = if is_broken {
            defect > 1e-6
        } else {
            defect < 1e-14
        };
        assert!(as_expected, "{name}: {defect:e}");
    }
}

/// m v in place of m v + q A is not canonical, whatever the degree.
#[test]
fn kinetic_momenta_are_not_canonical() {
    for degree in 2..=4 {
        let (step, phase_loop) = plasma(degree);
        let gempic = step.system();
        let kinetic = |ensemble: &mut Ensemble| {
            let mut block = ensemble.block();
            for sample in 0..block.len() {
                let column = |rows: Rows<'_>| -> Vec<f64> {
                    (0..rows.count()).map(|i| rows.row(i)[sample]).collect()
                };
                let (q, p) = (column(block.q.as_rows()), column(block.p.as_rows()));
                let physical = gempic.physical(&q, &p);
                for (i, v) in physical.v1.iter().chain(&physical.v2).enumerate() {
                    block.p.row_mut(i)[sample] = *v;
                }
            }
        };
        let mut before = Ensemble::sample(&phase_loop, SAMPLES).unwrap();
        let mut after = Ensemble::sample(&phase_loop, SAMPLES).unwrap();
        after.advance(&step, H).unwrap();
        let [before, after] = [&mut before, &mut after].map(|ensemble| {
            kinetic(ensemble);
            let coordinates = step.coordinates();
            LoopIntegral::in_coordinates(ensemble, &Rule::Pseudospectral, &coordinates).unwrap()
        });
        let defect = Defect::between(&before, &after).unwrap().magnitude();
        println!("degree {degree}, kinetic momenta: {defect:.2}");
        assert!(defect > 1e-2, "degree {degree}: {defect:e}");
    }
}

//! Flows and steps in canonical variables against the scheme in physical ones.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use symplint::map::Parts;
use symplint::state::RowsMut;
use symplint::{Block, TimeAdvance};
use symplint_models::integrators::{PartSplitting, Variant, catalogue, splitting_methods};
use symplint_models::{Hamiltonian, Model, PartFlow, SplitHamiltonian};
use symplint_plasma::gempic::Gempic;

use crate::common::State;
use crate::gempic::reference::{Plasma, config, random_state};

/// One state as a block.
pub fn with_block(q: &mut [f64], p: &mut [f64], work: impl FnOnce(&mut Block<'_>)) {
    let dof = q.len();
    let (q, p) = (RowsMut::new(q, dof, 1, 1), RowsMut::new(p, dof, 1, 1));
    work(&mut Block::new(q, p));
}

#[test]
fn states_go_to_and_fro() {
    for degree in 1..=5 {
        for cells in [1, 2, 3, 8] {
            let gempic = Gempic::new(config(degree, cells, 3)).unwrap();
            let plasma = Plasma::new(config(degree, cells, 3));
            let physical = random_state(&gempic, 1);
            let (q, p) = gempic.state(&physical).unwrap();
            let back = gempic.physical(&q, &p);
            let fields = plasma.fields(&physical);
            assert!(
                plasma.distance(&fields, &back) < 1e-13,
                "degree {degree}, {cells} cells"
            );
            // The canonical momenta by their definition.
            for (p, (&x, v1)) in p.iter().zip(physical.x.iter().zip(&physical.v1)) {
                let potential = plasma.one(x).dot(&fields.a1);
                assert!((p - (0.8 * v1 - 1.3 * potential)).abs() < 1e-14);
            }
            let one = -(&plasma.m1 * &fields.e1);
            for j in 0..cells {
                assert!((p[6 + j] - one[j]).abs() < 1e-14);
            }
        }
    }
}

#[test]
fn each_flow_is_that_of_the_paper() {
    for degree in 1..=5 {
        for (cells, particles) in [(1, 2), (2, 1), (3, 2), (8, 4), (11, 5)] {
            let gempic = Gempic::new(config(degree, cells, particles)).unwrap();
            let plasma = Plasma::new(config(degree, cells, particles));
            let physical = random_state(&gempic, degree);
            // Times in which particles stay in a cell, leave it, and go round more than once.
            for h in [0.01, -0.7, 30.0] {
                for part in 0..4 {
                    let (mut q, mut p) = gempic.state(&physical).unwrap();
                    with_block(&mut q, &mut p, |block| gempic.flow(part, h, block));
                    let mut fields = plasma.fields(&physical);
                    plasma.flow(part, h, &mut fields);
                    let distance = plasma.distance(&fields, &gempic.physical(&q, &p));
                    // M0⁻¹ grows as (π/2)^(2p+2) / Δx, and coefficients with it.
                    let growth = FRAC_PI_2.powi(2 * degree as i32 + 2) * cells as f64;
                    assert!(
                        distance < 1e-14 * growth * h.abs().max(1.0),
                        "{} for {h}, degree {degree}, {cells} cells: {distance:e}",
                        gempic.part_name(part)
                    );
                }
            }
        }
    }
}

/// Steps are those of the scheme, as long as rounding errors have not grown.
#[test]
fn a_hundred_steps_are_those_of_the_paper() {
    const H: f64 = 0.05;
    for degree in 1..=5 {
        let gempic = Gempic::new(config(degree, 8, 4)).unwrap();
        let plasma = Plasma::new(config(degree, 8, 4));
        let physical = random_state(&gempic, 3);
        let (mut q, mut p) = gempic.state(&physical).unwrap();
        let mut fields = plasma.fields(&physical);
        let method = splitting_methods::strang(Variant::PositionFirst);
        let step = PartSplitting::new(&method, gempic.clone());
        for _ in 0..100 {
            for flow in step.flows() {
                plasma.flow(flow.part, flow.fraction * H, &mut fields);
            }
            with_block(&mut q, &mut p, |block| step.advance(H, block).unwrap());
        }
        let distance = plasma.distance(&fields, &gempic.physical(&q, &p));
        assert!(distance < 1e-11, "degree {degree}: {distance:e}");
        // H of the state, too, by its definition.
        let (energies, expected) = (gempic.energies(&q, &p), plasma.energy(&fields));
        let sum = energies.kinetic_along
            + energies.kinetic_across
            + energies.electric_along
            + energies.electric_across
            + energies.magnetic;
        assert!((sum - expected).abs() < 1e-11 * expected, "degree {degree}");
    }
}

/// b, advanced by itself with the field e2 of every step, is C a2 after 1,000 steps.
#[test]
fn the_magnetic_field_stays_that_of_the_potential() {
    const H: f64 = 0.05;
    for degree in 1..=5 {
        let gempic = Gempic::new(config(degree, 8, 4)).unwrap();
        let (mut q, mut p) = gempic.state(&random_state(&gempic, 3)).unwrap();
        let curl = |values: &[f64]| -> Vec<f64> {
            let before = values.iter().cycle().skip(values.len() - 1);
            values
                .iter()
                .zip(before)
                .map(|(a, before)| a - before)
                .collect()
        };
        let mut b = curl(&gempic.physical(&q, &p).a2);
        let method = splitting_methods::strang(Variant::PositionFirst);
        let step = PartSplitting::new(&method, gempic.clone());
        for _ in 0..1000 {
            for (substep, flow) in step.flows().iter().enumerate() {
                if gempic.part_name(flow.part) == "H_E" {
                    let e2 = gempic.physical(&q, &p).e2;
                    for (b, change) in b.iter_mut().zip(curl(&e2)) {
                        *b -= flow.fraction * H * change;
                    }
                }
                with_block(&mut q, &mut p, |block| {
                    Parts::of(&step).advance(substep, H, block).unwrap();
                });
            }
        }
        let derived = curl(&gempic.physical(&q, &p).a2);
        let difference = |(b, derived): (&f64, &f64)| (b - derived).abs();
        let largest = b.iter().zip(&derived).map(difference).fold(0.0, f64::max);
        println!("degree {degree}: b less C a2 after 1,000 steps: {largest:.1e}");
        assert!(largest < 1e-14, "degree {degree}: {largest:e}");
    }
}

/// Substeps are the step to the last bit, and a sample does not know its block.
#[test]
fn passes_are_flows_one_after_the_other() {
    const SAMPLES: usize = 19;
    for degree in 1..=5 {
        let gempic = Arc::new(Gempic::new(config(degree, 8, 6)).unwrap());
        let dof = gempic.dof();
        let states: Vec<_> = (0..SAMPLES)
            .map(|seed| gempic.state(&random_state(&gempic, seed)).unwrap())
            .collect();
        let table = |part: fn(&State) -> &Vec<f64>| -> Vec<f64> {
            (0..dof)
                .flat_map(|i| states.iter().map(move |state| part(state)[i]))
                .collect()
        };
        for name in ["lie-trotter", "strang", "mclachlan4", "yoshida4"] {
            for variant in ["position-first", "momentum-first"] {
                let model = Model::Split(Arc::clone(&gempic) as Arc<dyn SplitHamiltonian>);
                let step = catalogue::build(name, Some(variant), model).unwrap();
                let (mut q, mut p) = (table(|state| &state.0), table(|state| &state.1));
                let (q, p) = (
                    RowsMut::new(&mut q, dof, SAMPLES, SAMPLES),
                    RowsMut::new(&mut p, dof, SAMPLES, SAMPLES),
                );
                let mut block = Block::new(q, p);
                step.advance(0.3, &mut block).unwrap();
                for (sample, (q, p)) in states.iter().enumerate() {
                    let (mut q, mut p) = (q.clone(), p.clone());
                    with_block(&mut q, &mut p, |block| {
                        for substep in 0..Parts::of(&step).count() {
                            Parts::of(&step).advance(substep, 0.3, block).unwrap();
                        }
                    });
                    for i in 0..dof {
                        let together = (block.q.row(i)[sample], block.p.row(i)[sample]);
                        assert_eq!(together, (q[i], p[i]), "{name}, {variant}, row {i}");
                    }
                }
            }
        }
    }
}

/// Any sequence of flows is taken, along or across alone, too.
#[test]
fn flows_of_one_kind_follow_one_another() {
    let gempic = Gempic::new(config(3, 8, 4)).unwrap();
    let (q, p) = gempic.state(&random_state(&gempic, 2)).unwrap();
    for part in [2, 3] {
        let halves = [PartFlow {
            part,
            fraction: 0.5,
        }; 2];
        let (mut q2, mut p2) = (q.clone(), p.clone());
        with_block(&mut q2, &mut p2, |block| gempic.flows(0.4, &halves, block));
        let (mut q1, mut p1) = (q.clone(), p.clone());
        with_block(&mut q1, &mut p1, |block| gempic.flow(part, 0.4, block));
        for (two, one) in q2.iter().chain(&p2).zip(q1.iter().chain(&p1)) {
            assert!((two - one).abs() < 1e-14);
        }
    }
}

//! What steps conserve, and the momentum of the fields.

use symplint_models::integrators::{PartSplitting, Variant, splitting_methods};
use symplint_plasma::gempic::Gempic;

use crate::common::stepped;
use crate::gempic::reference::{Plasma, config, gauss, random_state};

#[test]
fn gauss_law_and_canonical_momenta_are_conserved() {
    for degree in 1..=5 {
        let gempic = Gempic::new(config(degree, 8, 4)).unwrap();
        let plasma = Plasma::new(config(degree, 8, 4));
        let mut state = gempic.state(&random_state(&gempic, 9)).unwrap();
        let across = state.1[4..8].to_vec();
        // Of each function of V0, its residual at a state, by the definition.
        let residuals = |(q, p): &(Vec<f64>, Vec<f64>)| -> Vec<f64> {
            let physical = gempic.physical(q, p);
            let fields = plasma.fields(&physical);
            let divergence = -(plasma.c.transpose() * (&plasma.m1 * &fields.e1));
            let weights = plasma.weights.iter();
            let charges = weights
                .zip(&physical.x)
                .fold(divergence * 0.0, |sum, (w, &x)| {
                    sum + plasma.zero(x) * (w * plasma.config.charge)
                });
            let mean = charges.mean();
            let divergence = -(plasma.c.transpose() * (&plasma.m1 * &fields.e1));
            (divergence - charges)
                .iter()
                .map(|residual| residual + mean)
                .collect()
        };
        let before = residuals(&state);
        let largest = before
            .iter()
            .fold(0.0, |largest: f64, r| largest.max(r.abs()));
        let reported = gempic.gauss_residual(&state.0, &state.1);
        assert!(
            (reported - largest).abs() < 1e-13,
            "degree {degree}: {reported} for {largest}"
        );
        let method = splitting_methods::mclachlan4(Variant::MomentumFirst);
        let step = PartSplitting::new(&method, gempic.clone());
        for _ in 0..200 {
            state = stepped(&step, 0.2, &state);
        }
        for (before, after) in before.iter().zip(residuals(&state)) {
            assert!(
                (before - after).abs() < 1e-12,
                "degree {degree}: {before} and {after}"
            );
        }
        assert_eq!(state.1[4..8], across);
    }
}

#[test]
fn momenta_are_sums_and_integrals() {
    for degree in 1..=5 {
        for cells in [1, 2, 3, 8] {
            let gempic = Gempic::new(config(degree, cells, 3)).unwrap();
            let plasma = Plasma::new(config(degree, cells, 3));
            let physical = random_state(&gempic, 2);
            let fields = plasma.fields(&physical);
            let particles = |v: &[f64]| -> f64 {
                v.iter()
                    .zip(&plasma.weights)
                    .map(|(v, w)| w * 0.8 * v)
                    .sum()
            };
            let mut expected = [particles(&physical.v1), particles(&physical.v2)];
            for cell in 0..cells {
                for (node, weight) in gauss() {
                    let x = (cell as f64 + node) * plasma.width();
                    let (zero, one) = (plasma.zero(x), plasma.one(x));
                    let field = weight * plasma.width() * one.dot(&fields.b);
                    expected[0] += zero.dot(&fields.e2) * field;
                    expected[1] -= one.dot(&fields.e1) * field;
                }
            }
            let (q, p) = gempic.state(&physical).unwrap();
            for (got, expected) in gempic.momentum(&q, &p).into_iter().zip(expected) {
                assert!(
                    (got - expected).abs() < 1e-12,
                    "degree {degree}, {cells} cells: {got} for {expected}"
                );
            }
        }
    }
}

/// The energy oscillates with an amplitude that falls as h² and does not drift.
#[test]
fn the_energy_is_bounded() {
    let gempic = Gempic::new(config(3, 8, 4)).unwrap();
    let state = gempic.state(&random_state(&gempic, 3)).unwrap();
    let energy = |(q, p): &(Vec<f64>, Vec<f64>)| {
        let parts = gempic.energies(q, p);
        parts.kinetic_along
            + parts.kinetic_across
            + parts.electric_along
            + parts.electric_across
            + parts.magnetic
    };
    let start = energy(&state);
    let method = splitting_methods::strang(Variant::PositionFirst);
    let step = PartSplitting::new(&method, gempic.clone());
    let largest = |h: f64| {
        let (mut state, mut largest) = (state.clone(), 0.0_f64);
        for _ in 0..(100.0 / h) as usize {
            state = stepped(&step, h, &state);
            largest = largest.max((energy(&state) / start - 1.0).abs());
        }
        largest
    };
    let (coarse, fine) = (largest(0.02), largest(0.01));
    let order = (coarse / fine).log2();
    assert!(
        coarse < 1e-2 && (order - 2.0).abs() < 0.3,
        "{coarse:e}, order {order}"
    );
}

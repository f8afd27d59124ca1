//! Initial states of plasmas, and the first thing a plasma does.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use symplint::state::RowsMut;
use symplint::{Block, TimeAdvance};
use symplint_models::integrators::catalogue::build;
use symplint_plasma::pic::{
    Landau, ParticleWeights, Pic, Pic1d, Pic2d, PicConfig, TwoStream, VelocityConvention,
};

fn plasma<const D: usize>(particles: usize) -> Pic<D> {
    let weights = ParticleWeights::Equal {
        particles,
        density: 1.0,
    };
    Pic::new(PicConfig {
        weights,
        ..PicConfig::default()
    })
    .unwrap()
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

/// Every `D`-th number from the `axis`-th on.
fn along(values: &[f64], dimensions: usize, axis: usize) -> impl ExactSizeIterator<Item = f64> {
    values.iter().skip(axis).step_by(dimensions).copied()
}

#[test]
fn landau_has_its_density_and_its_velocities() {
    const PARTICLES: usize = 40_000;
    // Five standard deviations of a mean of numbers of variance 1.
    let tolerance = 5.0 / (PARTICLES as f64).sqrt();
    for (convention, variance) in [
        (VelocityConvention::Text, 0.5),
        (VelocityConvention::Code, 1.0),
    ] {
        let landau = Landau {
            convention,
            mode: 3,
            ..Landau::default()
        };
        let (x, v) = landau.sample(&plasma::<1>(PARTICLES), 5).unwrap();
        assert!(x.iter().all(|x| (0.0..50.0).contains(x)));
        // ⟨cos kx⟩ = A/2 for the mode itself, 0 for others.
        for mode in 1..=6 {
            let k = TAU * f64::from(mode) / 50.0;
            let cosine = mean(x.iter().map(|x| (k * x).cos()));
            let expected = if mode == 3 { 0.25 } else { 0.0 };
            assert!(
                (cosine - expected).abs() < tolerance,
                "mode {mode}: {cosine}"
            );
            assert!(mean(x.iter().map(|x| (k * x).sin())).abs() < tolerance);
        }
        assert!(mean(v.iter().copied()).abs() < tolerance);
        let square = mean(v.iter().map(|v| v * v));
        assert!(
            (square / variance - 1.0).abs() < 1.5 * tolerance,
            "{convention:?}: {square}"
        );
    }
}

#[test]
fn two_streams_pass_through_each_other() {
    const PARTICLES: usize = 40_000;
    let tolerance = 5.0 / (PARTICLES as f64).sqrt();
    let (x, v) = TwoStream::default()
        .sample(&plasma::<2>(PARTICLES), 9)
        .unwrap();
    for axis in 0..2 {
        let k = TAU / 50.0;
        assert!(mean(along(&x, 2, axis).map(|x| (k * x).cos())).abs() < tolerance);
    }
    // Without the wave: beams at ±3 of variance ½.
    let beams: Vec<f64> = along(&v, 2, 0)
        .zip(along(&x, 2, 0))
        .map(|(v, x)| v / (1.0 + 0.5 * (TAU * x / 50.0).sin()))
        .collect();
    assert!(mean(beams.iter().copied()).abs() < 3.1 * tolerance);
    assert!((mean(beams.iter().map(|v| v.abs())) - 3.0).abs() < tolerance);
    let spread = mean(beams.iter().map(|v| (v.abs() - 3.0).powi(2)));
    assert!((spread - 0.5).abs() < tolerance, "{spread}");
    let across = mean(along(&v, 2, 1).map(|v| v * v));
    assert!((across - 0.5).abs() < tolerance, "{across}");
}

/// Bits that must never change: published figures depend on them.
#[test]
fn a_seed_is_a_state() {
    let pic = plasma::<1>(3);
    let bits = |values: &[f64]| -> Vec<u64> { values.iter().map(|v| v.to_bits()).collect() };
    let (x, v) = Landau::default().sample(&pic, 42).unwrap();
    assert_eq!(
        bits(&x),
        [
            0x402a_ed07_25de_98e4,
            0x4024_e0a8_59dc_b738,
            0x4038_5914_f01b_0241,
        ]
    );
    assert_eq!(
        bits(&v),
        [
            0x3fd3_d7be_83bb_79f9,
            0xbfe3_44b4_8ffb_89a2,
            0xbfd0_db13_6a4b_47d5,
        ]
    );
    let (x, v) = TwoStream::default().sample(&pic, 42).unwrap();
    assert_eq!(
        bits(&x),
        [
            0x4031_69a8_3e16_fe0f,
            0x402c_91e2_2818_d5b2,
            0x4038_ac72_9221_b954,
        ]
    );
    assert_eq!(
        bits(&v),
        [
            0xc011_5f0a_6149_9ea1,
            0x4016_b4ab_418c_5965,
            0xc006_9059_8f3b_05c4,
        ]
    );
    assert_ne!(TwoStream::default().sample(&pic, 43).unwrap().0, x);
}

#[test]
fn parameters_of_initial_states_are_checked() {
    let pic = plasma::<1>(3);
    for amplitude in [1.5, -1.5, f64::NAN] {
        let landau = Landau {
            amplitude,
            ..Landau::default()
        };
        let error = landau.sample(&pic, 1).unwrap_err();
        assert!(error.to_string().contains("amplitude"), "{error}");
    }
    for thermal_velocity in [-1.0, f64::NAN, f64::INFINITY] {
        let landau = Landau {
            thermal_velocity,
            ..Landau::default()
        };
        assert!(landau.sample(&pic, 1).is_err());
        let two_stream = TwoStream {
            thermal_velocity,
            ..TwoStream::default()
        };
        assert!(two_stream.sample(&pic, 1).is_err());
    }
    let landau = Landau {
        mode: 0,
        ..Landau::default()
    };
    assert!(landau.sample(&pic, 1).is_err());
    let beams = TwoStream {
        beam_velocity: f64::NAN,
        ..TwoStream::default()
    };
    assert!(beams.sample(&pic, 1).is_err());
    // Without spread and wave, everything is on the beams.
    let cold = TwoStream {
        thermal_velocity: 0.0,
        amplitude: 0.0,
        ..TwoStream::default()
    };
    let (_, v) = cold.sample(&pic, 1).unwrap();
    assert!(v.iter().all(|v| v.abs() == 3.0));
}

fn advance(map: &dyn TimeAdvance, h: f64, steps: usize, q: &mut [f64], p: &mut [f64]) {
    let dof = q.len();
    for _ in 0..steps {
        let mut block = Block::new(RowsMut::new(q, dof, 1, 1), RowsMut::new(p, dof, 1, 1));
        map.advance(h, &mut block).unwrap();
    }
}

/// A cold plasma of density 1, displaced by a small sine wave, swings at ω_p = 1.
#[test]
fn cold_plasma_oscillates_at_the_plasma_frequency() {
    const SMALL: f64 = 1e-4;
    let k = TAU / 50.0;
    let line: Pic1d = plasma(512);
    let step = build("strang", None, Arc::new(line)).unwrap();
    let rest: Vec<f64> = (0..512)
        .map(|a| (f64::from(a) + 0.5) * 50.0 / 512.0)
        .collect();
    let mut q: Vec<f64> = rest.iter().map(|x| x + SMALL * (k * x).sin()).collect();
    let mut p = vec![0.0; 512];
    advance(&*step, PI / 200.0, 200, &mut q, &mut p);
    for (x, rest) in q.iter().zip(&rest) {
        let displacement = (x - rest) / SMALL;
        assert!(
            (displacement + (k * rest).sin()).abs() < 1e-3,
            "{displacement} at {rest}"
        );
    }

    // The same along a diagonal of a plane.
    let weights = ParticleWeights::Equal {
        particles: 64 * 64,
        density: 1.0,
    };
    let plane = Pic2d::new(PicConfig {
        weights,
        cells: 32,
        ..PicConfig::default()
    })
    .unwrap();
    let step = build("strang", None, Arc::new(plane)).unwrap();
    let at = |i: usize| (i as f64 + 0.5) * 50.0 / 64.0;
    let rest: Vec<f64> = (0..64 * 64)
        .flat_map(|a| [at(a / 64), at(a % 64)])
        .collect();
    let wave = |x: &[f64]| SMALL * (k * (x[0] + x[1])).sin();
    let mut q: Vec<f64> = (rest.chunks_exact(2))
        .flat_map(|x| x.iter().map(move |c| c + wave(x)))
        .collect();
    let mut p = vec![0.0; 2 * 64 * 64];
    advance(&*step, PI / 50.0, 50, &mut q, &mut p);
    for (x, rest) in q.chunks_exact(2).zip(rest.chunks_exact(2)) {
        for axis in 0..2 {
            let off = (x[axis] - rest[axis] + wave(rest)) / SMALL;
            assert!(off.abs() < 5e-3, "{off} at {rest:?}");
        }
    }
}

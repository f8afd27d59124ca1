//! A Strang step of the electromagnetic plasma compared with a plain scalar control, in one interleaved run.
//!
//! `cargo bench -p symplint-plasma --bench gempic [-- PART OF A NAME]`.

mod gempic_control;
#[path = "../../symplint-models/benches/interleaved/mod.rs"]
mod interleaved;

use std::f64::consts::TAU;

use gempic_control::PlainGempic;
use interleaved::{heading, report, wanted};
use symplint::state::RowsMut;
use symplint::{Block, TimeAdvance};
use symplint_models::integrators::{PartSplitting, Variant, splitting_methods};
use symplint_plasma::gempic::{Gempic, GempicConfig, PhysicalState};
use symplint_plasma::pic::ParticleWeights;

const CELLS: usize = 32;
const H: f64 = 0.02;

fn main() {
    heading(&format!("Strang step a particle, {CELLS} cells"));
    for degree in 1..=5 {
        for (particles, samples) in [(100, 1), (100, 16), (10_000, 1), (10_000, 8)] {
            strang_step(degree, particles, samples);
        }
    }
}

/// A thermal plasma with a small wave of the fields.
fn plasma(degree: usize, particles: usize) -> (Gempic, PhysicalState) {
    let gempic = Gempic::new(GempicConfig {
        degree,
        cells: CELLS,
        weights: ParticleWeights::Equal {
            particles,
            density: 1.0,
        },
        ..GempicConfig::default()
    });
    let fraction = |a: usize, step: f64| (a as f64 * step).fract();
    let list = |step: f64, width: f64, shift: f64| -> Vec<f64> {
        (0..particles)
            .map(|a| width * (fraction(a, step) + shift))
            .collect()
    };
    let wave = |size: f64| {
        (0..CELLS)
            .map(|j| size * (TAU * j as f64 / CELLS as f64).sin())
            .collect()
    };
    let state = PhysicalState {
        x: list(0.754_877_666, TAU, 0.0),
        y: vec![0.0; particles],
        v1: list(0.569_840_291, 2.0, -0.5),
        v2: list(0.618_033_989, 2.0, -0.5),
        a1: vec![0.0; CELLS],
        a2: wave(0.1),
        e1: wave(0.02),
        e2: wave(0.05),
    };
    (gempic.unwrap(), state)
}

/// The inverse of a circulant matrix by its columns, from its row 0.
fn inverse(row: &[f64]) -> Vec<f64> {
    let n = row.len();
    let cos = |j: usize, k: usize| (TAU * (j * k % n) as f64 / n as f64).cos();
    let eigenvalue = |k: usize| (0..n).map(|j| row[j] * cos(j, k)).sum::<f64>();
    (0..n)
        .map(|i| (0..n).map(|k| cos(i, k) / eigenvalue(k)).sum::<f64>() / n as f64)
        .collect()
}

/// Row 0 of the mass matrix of splines of `degree` in units of cells, by the midpoint rule on fine cells.
fn mass(degree: usize) -> Vec<f64> {
    const POINTS: usize = 2000;
    let mut row = vec![0.0; CELLS];
    for point in 0..POINTS {
        let weights =
            symplint_models::bspline::weights(degree, (point as f64 + 0.5) / POINTS as f64);
        for i in 0..=degree {
            for j in 0..=degree {
                row[(CELLS + j - i) % CELLS] += weights[i] * weights[j] / POINTS as f64;
            }
        }
    }
    row
}

fn control(degree: usize, gempic: &Gempic, state: &PhysicalState) -> PlainGempic {
    let width = gempic.length() / CELLS as f64;
    let scaled = |row: Vec<f64>, by: f64| -> Vec<f64> { row.iter().map(|v| v * by).collect() };
    let (m0, m1) = (
        scaled(mass(degree), width),
        scaled(mass(degree - 1), 1.0 / width),
    );
    PlainGempic {
        degree,
        cells: CELLS,
        length: gempic.length(),
        charge: -1.0,
        mass: 1.0,
        weight: gempic.weights()[0],
        inverse0: inverse(&m0),
        inverse1: inverse(&m1),
        m1,
        x: state.x.clone(),
        v1: state.v1.clone(),
        v2: state.v2.clone(),
        e1: state.e1.clone(),
        e2: state.e2.clone(),
        b: (0..CELLS)
            .map(|j| state.a2[j] - state.a2[(j + CELLS - 1) % CELLS])
            .collect(),
        current: vec![0.0; CELLS],
        work: vec![0.0; CELLS],
    }
}

fn strang_step(degree: usize, particles: usize, samples: usize) {
    let name = format!("degree {degree}, {particles} particles, {samples} samples");
    if !wanted(&name) {
        return;
    }
    let (gempic, state) = plasma(degree, particles);
    let mut plain = control(degree, &gempic, &state);
    let (q, p) = gempic.state(&state).unwrap();
    let dof = q.len();
    check(&gempic, &q, &p, control(degree, &gempic, &state));
    let spread = |values: &[f64]| -> Vec<f64> {
        values
            .iter()
            .flat_map(|&value| vec![value; samples])
            .collect()
    };
    let (mut q, mut p) = (spread(&q), spread(&p));
    let method = splitting_methods::strang(Variant::PositionFirst);
    let step = PartSplitting::new(&method, gempic.clone());
    let mut advance = || {
        let q = RowsMut::new(&mut q, dof, samples, samples);
        let p = RowsMut::new(&mut p, dof, samples, samples);
        step.advance(H, &mut Block::new(q, p)).unwrap();
    };
    advance();
    plain.step(H);
    report(
        &name,
        (particles * samples) as f64,
        particles as f64,
        advance,
        || plain.step(H),
    );
}

/// Both do the same.
fn check(gempic: &Gempic, q: &[f64], p: &[f64], mut plain: PlainGempic) {
    let (mut q, mut p, dof) = (q.to_vec(), p.to_vec(), q.len());
    let method = splitting_methods::strang(Variant::PositionFirst);
    let step = PartSplitting::new(&method, gempic.clone());
    let (q_rows, p_rows) = (
        RowsMut::new(&mut q, dof, 1, 1),
        RowsMut::new(&mut p, dof, 1, 1),
    );
    step.advance(H, &mut Block::new(q_rows, p_rows)).unwrap();
    plain.step(H);
    let state = gempic.physical(&q, &p);
    for (got, expected) in [
        (&state.x, &plain.x),
        (&state.v1, &plain.v1),
        (&state.v2, &plain.v2),
        (&state.e1, &plain.e1),
        (&state.e2, &plain.e2),
    ] {
        for (got, expected) in got.iter().zip(expected) {
            // The control's mass matrices are those of a midpoint rule.
            assert!((got - expected).abs() < 1e-6, "{got} for {expected}");
        }
    }
}

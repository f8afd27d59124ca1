//! Growth and damping rates of linear theory, with quiet starts.
//!
//! Rates are taken where the field grows as one exponential: after other modes of the initial state have died away, and
//! before the particles of a quiet start are felt as single beams. Both halves of the window have the rate of the whole.

use std::f64::consts::TAU;

use symplint::Block;
use symplint::state::RowsMut;
use symplint_models::Model;
use symplint_models::integrators::StageSolver;
use symplint_plasma::CATALOGUE;
use symplint_plasma::gempic::{Fields, Gempic, GempicConfig, InitialPlasma};
use symplint_plasma::pic::ParticleWeights;

/// A scheme: fields, integrator, and how many particles it has time for.
#[derive(Clone, Copy)]
struct Scheme {
    fields: Fields,
    integrator: &'static str,
    cells: usize,
    particles: usize,
}

const GEOMETRIC: Scheme = Scheme {
    fields: Fields::FiniteElement,
    integrator: "strang",
    cells: 16,
    particles: 18_000,
};

const BORIS_YEE: Scheme = Scheme {
    fields: Fields::Yee,
    integrator: "boris-pic",
    cells: 16,
    particles: 18_000,
};

fn plasma(scheme: Scheme, initial: InitialPlasma, particles: usize) -> Gempic {
    let gempic = Gempic::new(GempicConfig {
        degree: 3,
        fields: scheme.fields,
        cells: scheme.cells,
        length: initial.length(),
        weights: ParticleWeights::Equal {
            particles,
            density: 1.0,
        },
        ..GempicConfig::default()
    });
    gempic.unwrap()
}

/// The square of the first Fourier mode of some rows, after every step of size `h` up to `time`.
fn history(
    (scheme, gempic): (Scheme, &Gempic),
    (mut q, mut p): (Vec<f64>, Vec<f64>),
    (h, time): (f64, f64),
    rows: impl Fn(&[f64], &[f64]) -> Vec<f64>,
) -> Vec<f64> {
    let dof = q.len();
    let (solver, model) = (StageSolver::default(), Model::from(gempic.clone()));
    let step = (CATALOGUE.build(solver, scheme.integrator, None, model)).unwrap();
    (0..(time / h) as usize)
        .map(|_| {
            let q_rows = RowsMut::new(&mut q, dof, 1, 1);
            let p_rows = RowsMut::new(&mut p, dof, 1, 1);
            step.advance(h, &mut Block::new(q_rows, p_rows)).unwrap();
            let (mut cosines, mut sines) = (0.0, 0.0);
            for (j, value) in rows(&q, &p).iter().enumerate() {
                let (sin, cos) = (TAU * j as f64 / scheme.cells as f64).sin_cos();
                cosines += cos * value;
                sines += sin * value;
            }
            cosines * cosines + sines * sines
        })
        .collect()
}

/// The slope of a straight line through equidistant values, by least squares.
fn slope(values: &[f64], distance: f64) -> f64 {
    let middle = 0.5 * (values.len() - 1) as f64;
    let (mut products, mut squares) = (0.0, 0.0);
    for (i, value) in values.iter().enumerate() {
        let x = i as f64 - middle;
        products += x * value;
        squares += x * x;
    }
    products / squares / distance
}

/// The growth rate of the magnetic field between two times.
fn growth_rate(
    scheme: Scheme,
    (initial, amplitude): (InitialPlasma, f64),
    h: f64,
    [from, to]: [f64; 2],
) -> f64 {
    let gempic = plasma(scheme, initial, scheme.particles);
    let state = initial.sample(&gempic, amplitude, 1).unwrap();
    let across = state.0.len() - scheme.cells;
    let squares = history((scheme, &gempic), state, (h, to), |q, _| {
        q[across..].to_vec()
    });
    let logarithms: Vec<f64> = squares.iter().map(|square| 0.5 * square.ln()).collect();
    let window = &logarithms[(from / h) as usize..];
    let rate = slope(window, h);
    for half in window.chunks(window.len() / 2).take(2) {
        let of_half = slope(half, h);
        println!("    {of_half:.5}");
        assert!((of_half / rate - 1.0).abs() < 0.05, "{of_half} and {rate}");
    }
    rate
}

#[test]
fn weibel() {
    for scheme in [GEOMETRIC, BORIS_YEE] {
        let initial = (InitialPlasma::Weibel, 1e-5);
        let rate = growth_rate(scheme, initial, 0.14, [140.0, 220.0]);
        println!("Weibel, {}: {rate:.5} for 0.02784", scheme.integrator);
        assert!((rate / 0.027_837_1 - 1.0).abs() < 0.03, "{rate}");
    }
}

#[test]
fn streaming_weibel() {
    for scheme in [GEOMETRIC, BORIS_YEE] {
        let initial = (InitialPlasma::StreamingWeibel, 1e-6);
        let rate = growth_rate(scheme, initial, 0.1, [50.0, 100.0]);
        println!(
            "streaming Weibel, {}: {rate:.5} for 0.03999",
            scheme.integrator
        );
        assert!((rate / 0.039_987_9 - 1.0).abs() < 0.03, "{rate}");
    }
}

#[test]
fn landau() {
    for scheme in [GEOMETRIC, BORIS_YEE] {
        // Finite differences are of order 2 in the width of a cell, and 3% of the damping needs this many.
        landau_of(Scheme {
            cells: 32,
            ..scheme
        });
    }
}

fn landau_of(scheme: Scheme) {
    const H: f64 = 0.1;
    let initial = InitialPlasma::Landau;
    let gempic = plasma(scheme, initial, 60_000);
    let state = initial.sample(&gempic, 0.05, 1).unwrap();
    let along = 2 * gempic.weights().len();
    let squares = history((scheme, &gempic), state, (H, 20.0), |_, p| {
        p[along..along + scheme.cells].to_vec()
    });
    // Maxima of the energy, by a parabola of its logarithm through three values.
    let maxima: Vec<(f64, f64)> = (1..squares.len() - 1)
        .filter(|&i| squares[i] > squares[i - 1] && squares[i] >= squares[i + 1])
        .map(|i| {
            let [a, b, c] = [i - 1, i, i + 1].map(|i| squares[i].ln());
            let shift = 0.5 * (a - c) / (a - 2.0 * b + c);
            ((i as f64 + 1.0 + shift) * H, b - 0.25 * (a - c) * shift)
        })
        .collect();
    // Two maxima in a period.
    let periods = 0.5 * (maxima.len() - 1) as f64;
    let (first, last) = (maxima[0], maxima[maxima.len() - 1]);
    let frequency = TAU * periods / (last.0 - first.0);
    let damping = 0.5 * (last.1 - first.1) / (last.0 - first.0);
    println!(
        "Landau, {}: {frequency:.4} for 1.4157, {damping:.4} for -0.1534",
        scheme.integrator
    );
    assert!((frequency / 1.415_66 - 1.0).abs() < 0.03, "{frequency}");
    assert!((damping / -0.153_36 - 1.0).abs() < 0.03, "{damping}");
}

//! The schemes, all of them for four particles on eight cells.

use std::f64::consts::TAU;
use std::sync::Arc;

use symplint::TimeAdvance;
use symplint::loops::FourierLoop;
use symplint_models::gempic::{Gempic, GempicConfig, InitialPlasma};
use symplint_models::integrators::catalogue::build;
use symplint_models::pic::{
    Landau, MomentumConservingConfig, MomentumConservingPic, ParticleWeights, Pic1d, PicConfig,
};
use symplint_models::{Hamiltonian, Model};

use super::plasma::Plasma;
use crate::PaperError;

const PARTICLES: usize = 4;
const CELLS: usize = 8;
const LENGTH: f64 = TAU;

/// What distinguishes schemes, whatever the shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Birdsall & Langdon's ES1: momentum-conserving, electrostatic.
    Textbook,
    /// Lewis: variational, electrostatic.
    Lewis,
    /// GEMPIC with an integrator of this name for all of it.
    Geometric(&'static str),
}

impl Family {
    /// Its name in tables and figures.
    pub fn name(self) -> &'static str {
        match self {
            Family::Textbook => "ES1 (momentum-conserving), leapfrog",
            Family::Lewis => "Lewis (variational), leapfrog",
            Family::Geometric("strang") => "GEMPIC, Strang splitting",
            Family::Geometric("averaged-vector-field") => "GEMPIC, averaged vector field",
            Family::Geometric("rk4") => "GEMPIC, classical Runge–Kutta",
            Family::Geometric(_) => "GEMPIC",
        }
    }
}

/// One scheme with one shape, and the loop on which it is judged.
pub struct Scheme {
    /// The scheme.
    pub family: Family,
    /// Degree of the shape of the charge.
    pub degree: usize,
    /// What can be watched.
    pub plasma: Plasma,
    /// One step.
    pub map: Box<dyn TimeAdvance>,
    /// The centre of the loop, positions and momenta.
    pub centre: (Vec<f64>, Vec<f64>),
    /// The loop: three Fourier modes in every coordinate.
    pub phase_loop: FourierLoop,
    /// Cell boundaries that particles pass round the loop.
    pub crossings: usize,
}

/// All schemes.
pub fn all(seed: u64) -> Result<Vec<Scheme>, PaperError> {
    let mut schemes = Vec::new();
    for degree in 0..=3 {
        schemes.push(textbook(degree, seed)?);
    }
    for degree in 1..=3 {
        schemes.push(lewis(degree, seed)?);
    }
    // Implicit equations with a force that jumps need not have a solution.
    for (integrator, lowest) in [("strang", 1), ("rk4", 1), ("averaged-vector-field", 2)] {
        for degree in lowest..=4 {
            schemes.push(geometric(integrator, degree, seed)?);
        }
    }
    Ok(schemes)
}

fn weights() -> ParticleWeights {
    ParticleWeights::Equal {
        particles: PARTICLES,
        density: 1.0,
    }
}

/// Positions from a density wave, and thermal velocities.
fn electrostatic_state(seed: u64) -> Result<(Vec<f64>, Vec<f64>), PaperError> {
    Ok(Landau::default().sample_box::<1>(PARTICLES, LENGTH, seed)?)
}

fn textbook(degree: usize, seed: u64) -> Result<Scheme, PaperError> {
    let pic = MomentumConservingPic::new(MomentumConservingConfig {
        weights: weights(),
        cells: CELLS,
        length: LENGTH,
        degree,
    })?;
    let map = build("leapfrog", None, Model::Forced(Arc::new(pic.clone())))?;
    let plasma = Plasma::MomentumConserving(pic);
    scheme(
        (Family::Textbook, degree),
        plasma,
        map,
        electrostatic_state(seed)?,
        seed,
    )
}

fn lewis(degree: usize, seed: u64) -> Result<Scheme, PaperError> {
    let pic = Pic1d::new(PicConfig {
        weights: weights(),
        cells: CELLS,
        length: LENGTH,
        degree,
        ..PicConfig::default()
    })?;
    let map = build("leapfrog", None, Arc::new(pic.clone()))?;
    let plasma = Plasma::Variational(pic);
    scheme(
        (Family::Lewis, degree),
        plasma,
        map,
        electrostatic_state(seed)?,
        seed,
    )
}

fn geometric(integrator: &'static str, degree: usize, seed: u64) -> Result<Scheme, PaperError> {
    let gempic = Gempic::new(GempicConfig {
        degree,
        cells: CELLS,
        length: LENGTH,
        weights: weights(),
        ..GempicConfig::default()
    })?;
    let centre = InitialPlasma::Random.sample(&gempic, 0.2, seed)?;
    let map = build(integrator, None, Model::Plasma(gempic.clone()))?;
    debug_assert_eq!(centre.0.len(), Hamiltonian::dof(&gempic));
    let plasma = Plasma::Electromagnetic(gempic);
    scheme(
        (Family::Geometric(integrator), degree),
        plasma,
        map,
        centre,
        seed,
    )
}

fn scheme(
    (family, degree): (Family, usize),
    plasma: Plasma,
    map: Box<dyn TimeAdvance>,
    centre: (Vec<f64>, Vec<f64>),
    seed: u64,
) -> Result<Scheme, PaperError> {
    /// Particles pass some boundaries, and stay in a part of the box.
    const OF_PARTICLES: f64 = 0.5;
    /// Fields change by about as much as they are.
    const OF_FIELDS: f64 = 0.2;
    let (q, p) = centre.clone();
    let particles = match plasma {
        Plasma::Electromagnetic(_) => 2 * PARTICLES,
        _ => PARTICLES,
    };
    let radii: Vec<f64> = (0..q.len())
        .map(|i| {
            if i < particles {
                OF_PARTICLES
            } else {
                OF_FIELDS
            }
        })
        .collect();
    let phase_loop = FourierLoop::random(q, p, &radii, &radii, seed)?;
    let crossings = crossings(&phase_loop)?;
    Ok(Scheme {
        family,
        degree,
        plasma,
        map,
        centre,
        phase_loop,
        crossings,
    })
}

/// How often particles pass a boundary between cells on the way round the loop.
fn crossings(phase_loop: &FourierLoop) -> Result<usize, PaperError> {
    const SAMPLES: usize = 1 << 14;
    let mut ensemble = symplint::Ensemble::sample(phase_loop, SAMPLES)?;
    let block = ensemble.block();
    let cell = |x: f64| (x / LENGTH * CELLS as f64).floor();
    Ok((0..PARTICLES)
        .map(|a| {
            let row = block.q.row(a);
            (0..SAMPLES)
                .filter(|&k| cell(row[k]) != cell(row[(k + 1) % SAMPLES]))
                .count()
        })
        .sum())
}

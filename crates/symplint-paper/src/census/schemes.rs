//! The schemes, all of them for four particles on eight cells.

use std::f64::consts::TAU;
use std::sync::Arc;

use symplint::TimeAdvance;
use symplint::loops::FourierLoop;
use symplint_models::Model;
use symplint_models::integrators::catalogue::build;
use symplint_models::integrators::{StageSolver, Stop};
use symplint_plasma::CATALOGUE;
use symplint_plasma::gempic::{Fields, Gempic, GempicConfig, InitialPlasma};
use symplint_plasma::pic::{
    Landau, MomentumConservingConfig, MomentumConservingPic, ParticleWeights, Pic1d, PicConfig,
};

use super::plasma::Plasma;
use crate::error::PaperError;

const PARTICLES: usize = 4;
const CELLS: usize = 8;
const LENGTH: f64 = TAU;

/// A scheme whatever the shape.
#[derive(Debug)]
pub struct Family {
    /// Its name in tables and figures.
    pub name: &'static str,
    /// How it is made.
    kind: SchemeKind,
    /// Degrees of the shape of the charge, from the first to the last.
    degrees: (usize, usize),
}

/// How a scheme is made.
#[derive(Debug)]
enum SchemeKind {
    /// Birdsall & Langdon's ES1.
    Textbook,
    /// Lewis.
    Lewis,
    /// Particles and fields of `pic-1d2v`, and an integrator of the catalogue with a variant.
    Electromagnetic(Fields, &'static str, Option<&'static str>),
    /// The same with a tolerance of the solver.
    Tolerance(Fields, &'static str, f64),
}

use Fields::{FiniteElement, Yee};
use SchemeKind::{Electromagnetic, Lewis, Textbook, Tolerance};

const fn family(name: &'static str, degrees: (usize, usize), kind: SchemeKind) -> Family {
    Family {
        name,
        kind,
        degrees,
    }
}

/// Momentum-conserving, electrostatic.
pub const TEXTBOOK: &str = "ES1, leapfrog";
/// Variational, electrostatic.
pub const LEWIS: &str = "Lewis, leapfrog";
/// The geometric splitting with finite elements.
pub const GEMPIC: &str = "GEMPIC, Strang";
/// The same splitting on Yee's grid.
pub const YEE_SPLITTING: &str = "Yee fields, Strang";
/// What most electromagnetic codes run.
pub const BORIS_YEE: &str = "Boris–Yee";
/// The same with velocities as codes store them.
pub const STAGGERED: &str = "Boris–Yee, staggered v";
/// The same with fields from the nodes.
pub const NODAL: &str = "Boris–Yee, nodal gather";
/// The same with a current that does not follow the charge.
pub const DIRECT: &str = "Boris–Yee, direct current";
/// Chen, Chacón & Barnes.
pub const CRANK_NICOLSON: &str = "Crank–Nicolson";
/// The same with sub-steps of the orbits.
pub const SUB_STEPPED: &str = "Crank–Nicolson, sub-steps";
/// Kormann & Sonnendrücker.
pub const AVERAGED: &str = "Crank–Nicolson, orbit mean";
/// Chen, Chacón & Barnes, as people run it.
pub const LOOSE: &str = "Crank–Nicolson, tol 1e-6";
/// Lapenta.
pub const ECSIM: &str = "ECSIM";

/// The schemes, in the order of the table.
pub const FAMILIES: [Family; 13] = [
    family(TEXTBOOK, (0, 3), Textbook),
    family(LEWIS, (1, 3), Lewis),
    family(
        GEMPIC,
        (1, 4),
        Electromagnetic(FiniteElement, "strang", None),
    ),
    family(YEE_SPLITTING, (1, 4), Electromagnetic(Yee, "strang", None)),
    family(
        BORIS_YEE,
        (1, 4),
        Electromagnetic(Yee, "boris-pic", Some("synchronised")),
    ),
    family(
        STAGGERED,
        (1, 4),
        Electromagnetic(Yee, "boris-pic", Some("staggered")),
    ),
    family(
        NODAL,
        (1, 4),
        Electromagnetic(Yee, "boris-pic", Some("nodal")),
    ),
    family(
        DIRECT,
        (1, 4),
        Electromagnetic(Yee, "boris-pic", Some("direct")),
    ),
    // Implicit equations with fields that jump need not have a solution.
    family(
        CRANK_NICOLSON,
        (2, 4),
        Electromagnetic(FiniteElement, "crank-nicolson", Some("midpoint")),
    ),
    family(
        SUB_STEPPED,
        (2, 4),
        Electromagnetic(FiniteElement, "crank-nicolson", Some("sub-stepped")),
    ),
    family(
        AVERAGED,
        (2, 4),
        Electromagnetic(FiniteElement, "crank-nicolson", Some("orbit-averaged")),
    ),
    family(
        LOOSE,
        (4, 4),
        Tolerance(FiniteElement, "crank-nicolson", 1e-6),
    ),
    family(ECSIM, (1, 4), Electromagnetic(FiniteElement, "ecsim", None)),
];

/// One scheme with one shape, and the loop on which it is judged.
pub struct Scheme {
    /// The scheme.
    pub family: &'static str,
    /// Degree of the shape of the charge.
    pub degree: usize,
    /// The plasma, which has the invariants.
    pub plasma: Plasma,
    /// One step.
    pub map: Box<dyn TimeAdvance>,
    /// The centre of the loop, positions and momenta.
    pub centre: (Vec<f64>, Vec<f64>),
    /// The loop: three Fourier modes in every coordinate.
    pub phase_loop: FourierLoop,
    /// Other loops round the same centre, a quarter of its size.
    pub small_loops: Vec<FourierLoop>,
    /// Cell boundaries that particles pass round the loop.
    pub crossings: usize,
    /// About what an evaluation costs, in those of explicit schemes.
    pub cost: usize,
}

/// All schemes with all shapes.
pub fn all(seed: u64) -> Result<Vec<Scheme>, PaperError> {
    let of_family = |family: &'static Family| {
        (family.degrees.0..=family.degrees.1).map(move |degree| one(family, degree, seed))
    };
    FAMILIES.iter().flat_map(of_family).collect()
}

fn one(family: &Family, degree: usize, seed: u64) -> Result<Scheme, PaperError> {
    let exactly = StageSolver::default();
    let (plasma, map, centre) = match family.kind {
        Textbook => textbook(degree, seed)?,
        Lewis => lewis(degree, seed)?,
        Electromagnetic(fields, integrator, variant) => {
            electromagnetic((fields, degree), (integrator, variant, exactly), seed)?
        }
        Tolerance(fields, integrator, tolerance) => {
            let stop = Stop::Converged {
                tolerance,
                max_iterations: StageSolver::MAX_ITERATIONS,
            };
            let solver = StageSolver { stop, ..exactly };
            electromagnetic((fields, degree), (integrator, None, solver), seed)?
        }
    };
    let is_implicit = match family.kind {
        Textbook | Lewis => false,
        Electromagnetic(_, integrator, _) | Tolerance(_, integrator, _) => {
            CATALOGUE.find(integrator)?.is_implicit()
        }
    };
    let made = scheme((family.name, degree), plasma, map, centre, seed)?;
    Ok(Scheme {
        cost: if is_implicit {
            COST_OF_IMPLICIT_STEP
        } else {
            1
        },
        ..made
    })
}

/// About what an implicit step costs, in explicit ones.
const COST_OF_IMPLICIT_STEP: usize = 5;

/// A plasma, a step of it, and positions and momenta to begin with.
type PlasmaSetup = (Plasma, Box<dyn TimeAdvance>, (Vec<f64>, Vec<f64>));

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

fn textbook(degree: usize, seed: u64) -> Result<PlasmaSetup, PaperError> {
    let pic = MomentumConservingPic::new(MomentumConservingConfig {
        weights: weights(),
        cells: CELLS,
        length: LENGTH,
        degree,
    })?;
    let map = build("leapfrog", None, Model::Forced(Arc::new(pic.clone())))?;
    Ok((
        Plasma::MomentumConserving(pic),
        map,
        electrostatic_state(seed)?,
    ))
}

fn lewis(degree: usize, seed: u64) -> Result<PlasmaSetup, PaperError> {
    let pic = Pic1d::new(PicConfig {
        weights: weights(),
        cells: CELLS,
        length: LENGTH,
        degree,
        ..PicConfig::default()
    })?;
    let pic = Arc::new(pic);
    let map = build("leapfrog", None, Arc::clone(&pic))?;
    Ok((Plasma::Variational(pic), map, electrostatic_state(seed)?))
}

fn electromagnetic(
    (fields, degree): (Fields, usize),
    (integrator, variant, solver): (&str, Option<&str>, StageSolver),
    seed: u64,
) -> Result<PlasmaSetup, PaperError> {
    /// Of random potentials and fields.
    const AMPLITUDE: f64 = 0.2;
    let gempic = Gempic::new(GempicConfig {
        degree,
        fields,
        cells: CELLS,
        length: LENGTH,
        weights: weights(),
        ..GempicConfig::default()
    })?;
    let centre = InitialPlasma::Random.sample(&gempic, AMPLITUDE, seed)?;
    let model = Model::from(gempic.clone());
    let map = CATALOGUE.build(solver, integrator, variant, model)?;
    Ok((Plasma::Electromagnetic(Box::new(gempic)), map, centre))
}

fn scheme(
    (family, degree): (&'static str, usize),
    plasma: Plasma,
    map: Box<dyn TimeAdvance>,
    centre: (Vec<f64>, Vec<f64>),
    seed: u64,
) -> Result<Scheme, PaperError> {
    /// Enough that not all defects pass through 0 at the same step size.
    const SMALL_LOOPS: u64 = 4;
    /// About half a cell: particles pass some boundaries.
    const OF_PARTICLES: f64 = 0.4;
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
    let phase_loop = FourierLoop::random(q.clone(), p.clone(), &radii, &radii, seed)?;
    let small: Vec<f64> = radii.iter().map(|radius| 0.25 * radius).collect();
    let small_loops = (1..=SMALL_LOOPS)
        .map(|k| FourierLoop::random(q.clone(), p.clone(), &small, &small, seed.wrapping_add(k)))
        .collect::<Result<_, _>>()?;
    let crossings = crossings(&phase_loop)?;
    Ok(Scheme {
        family,
        degree,
        plasma,
        map,
        centre,
        phase_loop,
        small_loops,
        crossings,
        cost: 1,
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

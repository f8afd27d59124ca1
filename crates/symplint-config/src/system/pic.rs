//! Electrostatic particle-in-cell.

use std::path::Path;
use std::sync::Arc;

use symplint_models::{Model, ModelError};
use symplint_plasma::pic::{
    Landau, MomentumConservingConfig, MomentumConservingPic, ParticleWeights, Pic, PicConfig,
    ShapeFamily, TwoStream, VelocityConvention,
};

use super::initial::{Initial, initial, refuse_unused};
use super::{MAX_DOF, STRANG, System, SystemInfo};
use crate::ConfigError;
use crate::section::{Key, NumberRange, Section};

pub const PIC_1D: SystemInfo = SystemInfo {
    name: "pic-1d",
    summary: "electrostatic particle-in-cell on a periodic line (section 5)",
    keys: &keys("128"),
    integrator: STRANG,
    budget: None,
    build: |section, folder| pic::<1>("pic-1d", section, folder),
};

pub const PIC_2D: SystemInfo = SystemInfo {
    name: "pic-2d",
    summary: "the same on a doubly periodic square, with tensor-product shapes",
    keys: &keys("16"),
    integrator: STRANG,
    budget: None,
    build: |section, folder| pic::<2>("pic-2d", section, folder),
};

/// Filter passes at most: after as many, nothing is left of the field.
const MAX_PASSES: u64 = 1_000_000;

/// The keys; `cells` is the default number of cells along each axis.
const fn keys(cells: &'static str) -> [Key; 15] {
    let [density, weights, rest @ ..] = PARTICLE_KEYS;
    let [initial, thermal, velocities, beam, amplitude, mode, seed] = rest;
    [
        Key::new(
            "family",
            "\"b-spline\"",
            "\"b-spline\", degree 1 to 5, or \"lagrange\", C⁰, degree 1 to 3",
        )
        .choice(&["b-spline", "lagrange"]),
        Key::new(
            "degree",
            "3",
            "degree of the shapes; the force is discontinuous for b-spline 1 and every lagrange",
        ),
        Key::new(
            "cells",
            cells,
            "number of cells along each axis; on one cell B-splines carry no field",
        ),
        Key::new("length", "50.0", "length of each axis"),
        Key::new("particles", "2", "number of particles"),
        density,
        weights,
        Key::new(
            "filter",
            "0",
            "number of passes of the binomial filter (1/4, 1/2, 1/4), which the paper calls binary",
        ),
        initial,
        thermal,
        velocities,
        beam,
        amplitude,
        mode,
        seed,
    ]
}

/// Keys of the particles and of their initial state.
const PARTICLE_KEYS: [Key; 9] = [
    Key::new(
        "density",
        "1.0",
        "mean density; each particle has the weight density × length^D / particles, in D dimensions",
    ),
    Key::optional(
        "weights",
        "[10.0, 40.0]",
        "one for each particle, instead of particles and density; p = weight × v",
    )
    .numbers(),
    Key::new(
        "initial",
        "\"two-stream\"",
        "\"two-stream\", \"landau\"; or { file = \"state.npy\" } with rows x and v (.csv: columns)",
    )
    .choice_or_file(&["two-stream", "landau"]),
    Key::new("thermal_velocity", "1.0", "thermal velocity v_th"),
    Key::new(
        "velocities",
        "\"text\"",
        "what v_th means: \"text\", exp(-v²/v_th²), or \"code\", variance v_th²",
    )
    .choice(&["text", "code"]),
    Key::new("beam_velocity", "3.0", "v_b of \"two-stream\""),
    Key::new(
        "amplitude",
        "0.5",
        "amplitude of the density or velocity wave",
    ),
    Key::new("mode", "1", "number of its wavelengths in the box"),
    Key::new("seed", "42", "seed of the random initial state"),
];

/// The keys of the textbook scheme.
const ES1_KEYS: [Key; 13] = {
    let [density, weights, rest @ ..] = PARTICLE_KEYS;
    let [initial, thermal, velocities, beam, amplitude, mode, seed] = rest;
    [
        Key::new(
            "degree",
            "1",
            "degree of the shape, 0 (nearest grid point) to 5; the force is discontinuous for 0",
        ),
        Key::new("cells", "8", "number of cells, at least 3"),
        Key::new("length", "10.0", "length of the line"),
        Key::new("particles", "4", "number of particles"),
        density,
        weights,
        initial,
        thermal,
        velocities,
        beam,
        amplitude,
        mode,
        seed,
    ]
};

pub const PIC_ES1: SystemInfo = SystemInfo {
    name: "pic-es1",
    summary: "textbook momentum-conserving particle-in-cell on a periodic line (ES1), whose force has no potential",
    keys: &ES1_KEYS,
    integrator: STRANG,
    budget: None,
    build: es1,
};

fn es1(section: &Section, folder: &Path) -> Result<System, ConfigError> {
    let config = MomentumConservingConfig {
        weights: weights(section)?,
        cells: section.whole("cells", 1)? as usize,
        length: section.number("length", NumberRange::Positive)?,
        degree: section.whole("degree", 0)? as usize,
    };
    let plasma = MomentumConservingPic::new(config)
        .map_err(|error| section.refused_by(key_of(section, &error), &error))?;
    let (q0, p0) = state::<1>((plasma.particles(), plasma.length()), section, folder)?;
    Ok(System {
        name: "pic-es1",
        model: Model::Forced(Arc::new(plasma)),
        q0,
        p0,
        command: None,
    })
}

/// The key that an error of a plasma is of.
fn key_of(section: &Section, error: &ModelError) -> &'static str {
    match error {
        ModelError::Degree { .. } | ModelError::ShapeDegree { .. } => "degree",
        ModelError::TooManyCells { .. }
        | ModelError::TooFewCells { .. }
        | ModelError::NoCentredDifference { .. } => "cells",
        _ if section.written_place("weights").is_some() => "weights",
        ModelError::OutOfRange { what, .. } if what.contains("length") => "length",
        ModelError::OutOfRange { .. } => "density",
        _ => "particles",
    }
}

fn pic<const D: usize>(
    name: &'static str,
    section: &Section,
    folder: &Path,
) -> Result<System, ConfigError> {
    let config = PicConfig {
        weights: weights(section)?,
        cells: section.whole("cells", 1)? as usize,
        length: section.number("length", NumberRange::Positive)?,
        family: match section.choice("family", &["b-spline", "lagrange"])? {
            "lagrange" => ShapeFamily::Lagrange,
            _ => ShapeFamily::BSpline,
        },
        degree: section.whole("degree", 0)? as usize,
        filter_passes: section.whole_between("filter", 0, MAX_PASSES)? as u32,
    };
    let pic = Pic::<D>::new(config)
        .map_err(|error| section.refused_by(key_of(section, &error), &error))?;
    let (q0, p0) = state::<D>((pic.particles(), pic.length()), section, folder)?;
    Ok(System {
        name,
        model: Model::Separable(Arc::new(pic)),
        q0,
        p0,
        command: None,
    })
}

fn weights(section: &Section) -> Result<ParticleWeights, ConfigError> {
    let particles = section.whole_between("particles", 1, MAX_DOF)? as usize;
    let density = section.number("density", NumberRange::Positive)?;
    let Some(weights) = section.optional_numbers("weights", NumberRange::Finite)? else {
        return Ok(ParticleWeights::Equal { particles, density });
    };
    for other in ["particles", "density"] {
        if section.written_place(other).is_some() {
            return Err(section.error(
                other,
                "cannot be combined with weights",
                format!("leave out either weights or {other}"),
            ));
        }
    }
    Ok(ParticleWeights::Each(weights))
}

/// The initial state of `particles` particles in a box of `D` axes of this length.
fn state<const D: usize>(
    (particles, length): (usize, f64),
    section: &Section,
    folder: &Path,
) -> Result<(Vec<f64>, Vec<f64>), ConfigError> {
    let of_named = [
        "thermal_velocity",
        "velocities",
        "beam_velocity",
        "amplitude",
        "mode",
        "seed",
    ];
    let kinds = (&["two-stream", "landau"][..], &of_named[..]);
    let name = match initial(section, folder, kinds, D * particles)? {
        Initial::State(x, v) => return Ok((x, v)),
        Initial::Named(name) => name,
    };
    let thermal_velocity = section.number("thermal_velocity", NumberRange::NotNegative)?;
    let amplitude = section.number("amplitude", NumberRange::Finite)?;
    let mode = section.whole_between("mode", 1, u64::from(u32::MAX))? as u32;
    let seed = section.whole("seed", 0)?;
    let convention = match section.choice("velocities", &["text", "code"])? {
        "code" => VelocityConvention::Code,
        _ => VelocityConvention::Text,
    };
    let drawn = if name == "landau" {
        refuse_unused(section, &["beam_velocity"], "initial = \"two-stream\"")?;
        let landau = Landau {
            amplitude,
            mode,
            thermal_velocity,
            convention,
        };
        landau.sample_box::<D>(particles, length, seed)
    } else {
        let two_stream = TwoStream {
            beam_velocity: section.number("beam_velocity", NumberRange::Finite)?,
            thermal_velocity,
            amplitude,
            mode,
            convention,
        };
        two_stream.sample_box::<D>(particles, length, seed)
    };
    drawn.map_err(|error| section.refused_by("amplitude", &error))
}

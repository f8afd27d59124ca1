//! Electromagnetic particle-in-cell.

use std::path::Path;

use symplint_models::{Hamiltonian, Model, ModelError};
use symplint_plasma::gempic::{Fields, Gempic, GempicConfig, InitialPlasma};
use symplint_plasma::pic::ParticleWeights;

use super::initial::{Initial, initial};
use super::{MAX_DOF, STRANG, System, SystemInfo};
use crate::ConfigError;
use crate::section::{Key, NumberRange, Section};

pub const PIC_1D2V: SystemInfo = SystemInfo {
    name: "pic-1d2v",
    summary: "electromagnetic particle-in-cell (GEMPIC or Yee fields) on a periodic line, two velocities, \
              in canonical variables",
    keys: &[
        Key::new(
            "degree",
            "3",
            "degree of the B-splines of the potential, 1 to 5; forces are discontinuous for 1",
        ),
        Key::new(
            "fields",
            "\"finite-element\"",
            "\"finite-element\", with mass matrices of splines, or \"yee\", by finite differences",
        ).choice(&["finite-element", "yee"]),
        Key::new("cells", "8", "number of cells"),
        Key::optional(
            "length",
            "5.0",
            "length of the box; by default 2π/1.25 for \"weibel\", 2π/0.2 for \"streaming-weibel\", 2π/0.5 for \"landau\", 2π for others",
        ),
        Key::new("particles", "4", "number of electrons, of density 1"),
        Key::new(
            "initial",
            "\"random\"",
            "\"weibel\", \"streaming-weibel\", \"landau\", \"random\"; or { file = \"state.npy\" } with rows \
             positions and momenta (.csv: columns)",
        ).choice_or_file(&["random", "weibel", "streaming-weibel", "landau"]),
        Key::new("seed", "42", "seed of the initial state"),
        Key::optional(
            "amplitude",
            "0.01",
            "amplitude of the wave or of random potentials; by default -1e-4 for \"weibel\", -1e-3 for \"streaming-weibel\", 0.5 for others",
        ),
    ],
    integrator: STRANG,
    budget: None,
    build,
};

fn build(section: &Section, folder: &Path) -> Result<System, ConfigError> {
    let names = InitialPlasma::ALL.map(|(name, _)| name);
    let degree = section.whole("degree", 0)? as usize;
    let fields = Fields::ALL.map(|(name, _)| name);
    let chosen = section.choice("fields", &fields)?;
    let fields = Fields::ALL.iter().find(|(name, _)| *name == chosen);
    let cells = section.whole("cells", 1)? as usize;
    let particles = section.whole_between("particles", 1, MAX_DOF)? as usize;
    let length = section.optional_number("length", NumberRange::Positive)?;
    // A state from a file must have this length, so the file is read before the box is known.
    let dof = 2 * (particles + cells);
    let (plasma, state) = match initial(section, folder, (&names, &["seed", "amplitude"]), dof)? {
        Initial::State(q, p) => (InitialPlasma::Random, Some((q, p))),
        Initial::Named(name) => {
            let known = InitialPlasma::ALL.iter().find(|(known, _)| *known == name);
            (
                known.map_or(InitialPlasma::Random, |(_, plasma)| *plasma),
                None,
            )
        }
    };
    let length = length.unwrap_or(plasma.length());
    section.record("length", length);
    let config = GempicConfig {
        degree,
        fields: fields.map_or(Fields::default(), |(_, fields)| *fields),
        cells,
        length,
        weights: ParticleWeights::Equal {
            particles,
            density: 1.0,
        },
        ..GempicConfig::default()
    };
    let key_of = |error: &ModelError| match error {
        ModelError::Degree { .. } => "degree",
        ModelError::TooManyCells { .. } => "cells",
        ModelError::OutOfRange { .. } => "length",
        _ => "particles",
    };
    let gempic = Gempic::new(config).map_err(|error| section.refused_by(key_of(&error), &error))?;
    let (q0, p0) = match state {
        Some(state) => state,
        None => {
            let seed = section.whole("seed", 0)?;
            let amplitude = section.optional_number("amplitude", NumberRange::Finite)?;
            let amplitude = amplitude.unwrap_or(plasma.amplitude());
            section.record("amplitude", amplitude);
            let drawn = plasma.sample(&gempic, amplitude, seed);
            drawn.map_err(|error| section.refused_by("amplitude", &error))?
        }
    };
    debug_assert_eq!(q0.len(), Hamiltonian::dof(&gempic));
    Ok(System {
        name: "pic-1d2v",
        model: Model::from(gempic),
        q0,
        p0,
        command: None,
    })
}

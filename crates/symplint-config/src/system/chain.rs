//! Chains of masses and springs.

use std::path::Path;
use std::sync::Arc;

use symplint_models::Model;
use symplint_models::systems::{Bond, Chain, Ends, FputBond, TodaBond};

use super::initial::{Initial, initial};
use super::{MAX_DOF, STRANG, System, SystemInfo};
use crate::ConfigError;
use crate::section::{Key, NumberRange, Section};

const MASSES: Key = Key::new("masses", "32", "number of masses, the degrees of freedom");
const ENDS: Key = Key::new("ends", "\"fixed\"", "\"fixed\" to walls or \"periodic\"")
    .choice(&["fixed", "periodic"]);
const INITIAL: Key = Key::new(
    "initial",
    "\"mode\"",
    "at rest in a normal mode; or { file = \"state.npy\" } with rows q and p (.csv: columns)",
)
.choice_or_file(&["mode"]);
const MODE: Key = Key::new(
    "mode",
    "1",
    "number of half waves between walls, or of waves around a ring",
);
const AMPLITUDE: Key = Key::new("amplitude", "1.0", "largest displacement in the mode");

pub const FPUT: SystemInfo = SystemInfo {
    name: "fput",
    summary: "the chain of Fermi, Pasta, Ulam and Tsingou: springs r²/2 + α r³/3 + β r⁴/4",
    keys: &[
        Key::new("alpha", "0.25", "cubic term of the springs"),
        Key::new("beta", "0.0", "quartic term of the springs"),
        MASSES,
        ENDS,
        INITIAL,
        MODE,
        AMPLITUDE,
    ],
    integrator: STRANG,
    budget: None,
    build: |section, folder| {
        let alpha = section.number("alpha", NumberRange::Finite)?;
        let beta = section.number("beta", NumberRange::Finite)?;
        let bond = FputBond::new(alpha, beta).map_err(|e| section.refused_by("alpha", &e))?;
        chain("fput", bond, section, folder)
    },
};

pub const TODA: SystemInfo = SystemInfo {
    name: "toda",
    summary: "the Toda lattice: springs e^{−r} + r − 1, integrable as a ring",
    keys: &[MASSES, ENDS, INITIAL, MODE, AMPLITUDE],
    integrator: STRANG,
    budget: None,
    build: |section, folder| chain("toda", TodaBond, section, folder),
};

fn chain(
    name: &'static str,
    bond: impl Bond + 'static,
    section: &Section,
    folder: &Path,
) -> Result<System, ConfigError> {
    let masses = section.whole_between("masses", 1, MAX_DOF)? as usize;
    let ends = match section.choice("ends", &["fixed", "periodic"])? {
        "periodic" => Ends::Periodic,
        _ => Ends::Fixed,
    };
    let chain = Chain::new(bond, masses, ends).map_err(|e| section.refused_by("masses", &e))?;
    let kinds = (&["mode"][..], &["mode", "amplitude"][..]);
    let (q0, p0) = match initial(section, folder, kinds, masses)? {
        Initial::Named(_) => {
            let mode = section.whole_between("mode", 1, MAX_DOF)? as usize;
            let amplitude = section.number("amplitude", NumberRange::Finite)?;
            (chain.mode_shape(mode, amplitude), vec![0.0; masses])
        }
        Initial::State(q, p) => (q, p),
    };
    Ok(System {
        name,
        model: Model::Separable(Arc::new(chain)),
        q0,
        p0,
        command: None,
    })
}

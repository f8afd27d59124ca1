//! The pendulum array.

use std::path::Path;
use std::sync::Arc;

use symplint_models::Model;
use symplint_models::systems::PendulumArray;

use super::initial::{Initial, initial};
use super::{MAX_DOF, STRANG, System, SystemInfo};
use crate::ConfigError;
use crate::section::{Key, NumberRange, Section};

pub const PENDULUM_ARRAY: SystemInfo = SystemInfo {
    name: "pendulum-array",
    summary: "a ring of pendula coupled by springs (section 4.4)",
    keys: &[
        Key::new(
            "pendula",
            "1024",
            "number of pendula, the degrees of freedom",
        ),
        Key::new("alpha", "1.0", "strength of the pendula"),
        Key::new("k", "1.0", "strength of the springs"),
        Key::new(
            "initial",
            "\"uniform\"",
            "random in [0, 1); or { file = \"state.npy\" } with rows q and p (.csv: columns)",
        )
        .choice_or_file(&["uniform"]),
        Key::new("seed", "1", "seed of the random initial state"),
    ],
    integrator: STRANG,
    budget: None,
    build: pendulum_array,
};

fn pendulum_array(section: &Section, folder: &Path) -> Result<System, ConfigError> {
    let pendula = section.whole_between("pendula", 1, MAX_DOF)? as usize;
    let alpha = section.number("alpha", NumberRange::Finite)?;
    let k = section.number("k", NumberRange::Finite)?;
    let array =
        PendulumArray::new(pendula, alpha, k).map_err(|e| section.refused_by("pendula", &e))?;
    let kinds = (&["uniform"][..], &["seed"][..]);
    let (q0, p0) = match initial(section, folder, kinds, pendula)? {
        Initial::Named(_) => array.uniform_state(section.whole("seed", 0)?),
        Initial::State(q, p) => (q, p),
    };
    Ok(System {
        name: "pendulum-array",
        model: Model::Separable(Arc::new(array)),
        q0,
        p0,
        command: None,
    })
}

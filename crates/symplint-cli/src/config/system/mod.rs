//! `[system]`: the Hamiltonian and the state that loops go round.

mod array;
mod initial;
mod low_dimensional;
mod pic;

use std::path::Path;
use std::sync::Arc;

use symplint_models::{ModelError, Separable};

use super::document::{Node, Value};
use super::error::ConfigError;
use super::section::{Key, Section, suggestion};

/// A Hamiltonian with an initial state.
pub struct System {
    /// Its name in configurations.
    pub name: &'static str,
    /// H.
    pub hamiltonian: Arc<dyn Separable>,
    /// Initial positions: the centre of loops.
    pub q0: Vec<f64>,
    /// Initial momenta.
    pub p0: Vec<f64>,
}

/// A system that configurations may name.
pub struct SystemInfo {
    /// Name.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// Its keys besides `name`.
    pub keys: &'static [Key],
    build: fn(&Section, &Path) -> Result<System, ConfigError>,
}

/// Degrees of freedom at most.
pub const MOST_DOF: u64 = 1 << 28;

/// Every system.
pub const SYSTEMS: &[SystemInfo] = &[
    low_dimensional::PENDULUM,
    low_dimensional::ABSOLUTE_VALUE,
    low_dimensional::INTERPOLATED_PENDULUM,
    low_dimensional::HARMONIC_OSCILLATOR,
    low_dimensional::HENON_HEILES,
    low_dimensional::TWO_CELL,
    array::PENDULUM_ARRAY,
    pic::PIC_1D,
    pic::PIC_2D,
];

/// Reads `[system]`.
pub fn read(node: Option<&Node>, folder: &Path) -> Result<(System, Section), ConfigError> {
    const NAME: Key = Key::optional("name", "\"pendulum\"", "which system");
    // The name says which keys there are, so it is read before they are judged.
    let names = || SYSTEMS.iter().map(|info| info.name);
    let bare = Section::new("system", None, vec![NAME])?;
    let written = match node.map(|node| &node.value) {
        Some(Value::Table(table)) => table.entries.get("name").map(|(_, node)| node),
        _ => None,
    };
    let Some(written) = written else {
        let all = names().collect::<Vec<_>>().join(", ");
        return Err(bare.error(
            "name",
            "missing",
            format!("add [system] with name = one of {all}"),
        ));
    };
    let Value::Text(name) = &written.value else {
        return Err(bare
            .error(
                "name",
                format!("{}, not a text", written.value.kind()),
                "put it in quotes",
            )
            .at(&written.place, "must be a text"));
    };
    let Some(info) = SYSTEMS.iter().find(|info| info.name == name) else {
        return Err(bare
            .error(
                "name",
                format!("there is no \"{name}\""),
                suggestion(name, names()),
            )
            .at(&written.place, "unknown"));
    };
    let keys = info.keys.iter().copied().chain([NAME]).collect();
    let section = Section::new("system", node, keys)?;
    section.text("name")?;
    let system = (info.build)(&section, folder)?;
    Ok((system, section))
}

/// A model's own complaint, at the key that caused it.
fn refused(section: &Section, key: &str, error: ModelError) -> ConfigError {
    let text = error.to_string();
    match text.split_once("; ") {
        Some((message, remedy)) => section.error(key, message, remedy),
        None => section.error(key, text, "change this key"),
    }
}

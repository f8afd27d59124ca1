//! `[system]`: the Hamiltonian and the initial state, the centre of loops.

mod array;
mod chain;
mod command;
mod given_map;
mod initial;
mod low_dimensional;
mod mechanics;
mod pic;
mod pic_1d2v;

use std::path::Path;
use std::sync::Arc;

use symplint_models::Model;
use symplint_run::CommandMap;

pub use given_map::NOTHING;

use super::document::{Node, Value};
use super::error::ConfigError;
use super::section::{Key, Section, suggestion};

/// A system with an initial state.
pub struct System {
    /// Its name in configurations.
    pub name: &'static str,
    /// The equations, or the map.
    pub model: Model,
    /// Initial positions: the centre of loops.
    pub q0: Vec<f64>,
    /// Initial momenta.
    pub p0: Vec<f64>,
    /// The same map where it is a program.
    pub command: Option<Arc<CommandMap>>,
}

/// A system that configurations may name.
pub struct SystemInfo {
    /// Name.
    pub name: &'static str,
    /// One line of documentation.
    pub summary: &'static str,
    /// Its keys other than `name`.
    pub keys: &'static [Key],
    /// The default integrator, as TOML.
    pub integrator: &'static str,
    /// Evaluations of a diagnosis where none are given, if not those of [`symplint::Diagnostic`].
    pub(crate) budget: Option<usize>,
    build: fn(&Section, &Path) -> Result<System, ConfigError>,
}

/// The default integrator of most systems.
const STRANG: &str = "\"strang\"";

/// Degrees of freedom at most.
pub const MAX_DOF: u64 = 1 << 28;

/// Every system.
pub const SYSTEMS: &[SystemInfo] = &[
    low_dimensional::PENDULUM,
    low_dimensional::ABSOLUTE_VALUE,
    low_dimensional::INTERPOLATED_PENDULUM,
    low_dimensional::HARMONIC_OSCILLATOR,
    low_dimensional::HENON_HEILES,
    mechanics::KEPLER,
    mechanics::DOUBLE_PENDULUM,
    mechanics::CHARGED_PARTICLE,
    mechanics::ROTATIONAL_FORCE,
    chain::FPUT,
    chain::TODA,
    given_map::HENON_MAP,
    given_map::STANDARD_MAP,
    given_map::PENDULUM_RATTLE,
    low_dimensional::TWO_CELL,
    array::PENDULUM_ARRAY,
    pic::PIC_1D,
    pic::PIC_2D,
    pic::PIC_ES1,
    pic_1d2v::PIC_1D2V,
    command::COMMAND,
];

/// Reads `[system]`.
///
/// Comes with the entry of the system in the table.
pub fn read(
    node: Option<&Node>,
    folder: &Path,
) -> Result<(&'static SystemInfo, System, Section), ConfigError> {
    const NAME: Key = Key::optional("name", "\"pendulum\"", "which system");
    // The name determines which keys are accepted, so it is read first.
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
            format!("add [system] with name = \"…\". Available: {all}"),
        ));
    };
    let Value::Text(name) = &written.value else {
        return Err(bare
            .error(
                "name",
                format!("{}, not a string", written.plain().kind()),
                "put it in quotes",
            )
            .at(&written.place, "must be a string"));
    };
    let Some(info) = SYSTEMS.iter().find(|info| info.name == name) else {
        return Err(bare
            .error(
                "name",
                format!("unknown system \"{name}\""),
                suggestion(name, names()),
            )
            .at(&written.place, "unknown"));
    };
    let keys = info.keys.iter().copied().chain([NAME]).collect();
    let section = Section::new("system", node, keys)?;
    section.text("name")?;
    let system = (info.build)(&section, folder)?;
    Ok((info, system, section))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Kind;

    #[test]
    fn texts_of_a_key_are_its_default_and_those_that_its_help_names() {
        for key in SYSTEMS.iter().flat_map(|info| info.keys) {
            let default = key
                .value
                .strip_prefix('"')
                .and_then(|text| text.strip_suffix('"'));
            let texts = match key.kind {
                Kind::Choice(texts) | Kind::ChoiceOrFile(texts) => texts,
                Kind::Numbers | Kind::Plain => continue,
            };
            assert!(texts.contains(&default.unwrap()), "{}", key.name);
            let is_named =
                |text: &&str| Some(*text) == default || key.help.contains(&format!("\"{text}\""));
            assert!(texts.iter().all(is_named), "{}", key.name);
            let has_file = key.help.contains("{ file = ");
            assert_eq!(
                has_file,
                matches!(key.kind, Kind::ChoiceOrFile(_)),
                "{}",
                key.name
            );
        }
    }
}

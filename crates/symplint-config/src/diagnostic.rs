//! `[diagnostic]`: what `check` measures.

use std::collections::BTreeMap;

use symplint::Diagnostic;
use symplint::request::{RequestError, SETTINGS};

use super::document::Node;
use super::error::ConfigError;
use super::section::{Key, Kind, Section};

/// The keys of `[diagnostic]`: the settings of a diagnosis.
pub fn keys() -> Vec<Key> {
    (SETTINGS.iter())
        .map(|setting| Key {
            name: setting.name,
            value: setting.value,
            optional: setting.is_optional,
            required: false,
            kind: Kind::Plain,
            help: setting.help,
        })
        .collect()
}

/// Reads `[diagnostic]`.
pub fn read(node: Option<&Node>) -> Result<(Diagnostic, Section), ConfigError> {
    let section = Section::new("diagnostic", node, keys())?;
    let mut given = BTreeMap::new();
    for setting in SETTINGS {
        // With its default, it is in the configuration that is written to a run folder.
        let node = section.node(setting.name)?;
        if let Some(node) = node.filter(|_| section.written_place(setting.name).is_some()) {
            section.check_subsection(setting.name, setting.keys)?;
            given.insert(setting.name.to_owned(), node.plain());
        }
    }
    if given.contains_key("step_size") {
        section.record("step_sizes", "auto");
    }
    match Diagnostic::from_settings(&given) {
        Ok(diagnostic) => Ok((diagnostic, section)),
        Err(RequestError::Refused { name, refused }) => Err(section.refused(name, refused)),
        Err(error) => Err(ConfigError::new(error.to_string(), "correct its name")),
    }
}

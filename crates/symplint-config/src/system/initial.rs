//! `initial`: a named kind of initial state, or a state from a file.

use std::path::Path;

use super::super::document::Value;
use super::super::state_file::read_state;
use crate::ConfigError;
use crate::section::{Key, Section};

/// The value of `initial`.
pub enum Initial {
    /// One of the accepted names.
    Named(&'static str),
    /// Positions and momenta from a file.
    State(Vec<f64>, Vec<f64>),
}

/// Reads `initial`: one of `names`, or a file with the state of `dof` degrees of freedom, its path
/// relative to `folder` and recorded as an absolute one. The keys `of_named` describe named states, and are refused together with a
/// file.
pub fn initial(
    section: &Section,
    folder: &Path,
    (names, of_named): (&[&'static str], &[&'static str]),
    dof: usize,
) -> Result<Initial, ConfigError> {
    let node = section.node("initial")?;
    let keys = [Key::optional(
        "file",
        "\"state.npy\"",
        "two rows (.npy) or columns (.csv): positions and momenta",
    )];
    match node.as_ref().map(|node| &node.value) {
        Some(Value::Text(_)) => Ok(Initial::Named(section.choice("initial", names)?)),
        Some(Value::Table(_)) => {
            let inner = section.subsection("initial", &keys)?;
            let named = match &inner {
                Some(inner) => inner.optional_text("file")?,
                None => None,
            };
            let (Some(inner), Some(file)) = (inner, named) else {
                let help = "write { file = \"state.npy\" }";
                return Err(section.error("initial", "`file` is missing", help));
            };
            let file = folder.join(file);
            let (q, p) = read_state(&file, dof)
                .map_err(|error| section.error("initial", error.message, error.remedy))?;
            // The resolved configuration may be read from a run folder, so it needs an absolute path. One that is
            // not Unicode cannot be written in TOML and stays unchanged.
            let absolute = std::path::absolute(&file).ok();
            if let Some(absolute) = absolute.as_deref().and_then(Path::to_str) {
                inner.record("file", absolute);
            }
            section.adopt("initial", inner);
            let names = names.join("\" or \"");
            refuse_unused(section, of_named, &format!("initial = \"{names}\""))?;
            Ok(Initial::State(q, p))
        }
        _ => {
            let names = names.join("\", \"");
            Err(section.error(
                "initial",
                "not a name or a file",
                format!("must be \"{names}\" or {{ file = \"state.npy\" }}"),
            ))
        }
    }
}

/// Refuses keys that were written and describe another kind of initial state, `of`. Those in a file are passed over where
/// `--set` says which state to begin with.
pub fn refuse_unused(section: &Section, keys: &[&str], of: &str) -> Result<(), ConfigError> {
    let is_unused =
        |key: &&&str| section.written_place(key).is_some() && !section.is_overruled(key, "initial");
    match keys.iter().find(is_unused) {
        None => Ok(()),
        Some(key) => Err(section.error(key, format!("applies to {of} only"), "leave the key out")),
    }
}

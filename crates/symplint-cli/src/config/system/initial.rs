//! `initial`: a kind of state by name, or a state from a file.

use std::path::Path;

use super::super::document::Value;
use super::super::state_file::read_state;
use crate::config::ConfigError;
use crate::config::section::{Key, Section};

/// What `initial` says.
pub enum Initial {
    /// One of the names.
    Named(&'static str),
    /// Positions and momenta from a file.
    State(Vec<f64>, Vec<f64>),
}

/// Reads `initial`: one of `names`, or a file with the state of `dof` degrees of freedom, its path
/// relative to `folder` and recorded as an absolute one.
pub fn initial(
    section: &Section,
    folder: &Path,
    names: &[&'static str],
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
                return Err(section.error("initial", "no file named", help));
            };
            let file = folder.join(file);
            let (q, p) = read_state(&file, dof)
                .map_err(|error| section.error("initial", error.message, error.remedy))?;
            // What was resolved is read again from a run folder, where the path as written leads elsewhere. A
            // path that is no text cannot be said in TOML and stays as it was written.
            let absolute = std::path::absolute(&file).ok();
            if let Some(absolute) = absolute.as_deref().and_then(Path::to_str) {
                inner.record("file", absolute);
            }
            section.adopt("initial", inner);
            Ok(Initial::State(q, p))
        }
        _ => {
            let names = names.join("\" or \"");
            Err(section.error(
                "initial",
                format!("neither \"{names}\" nor a file"),
                "write a name in quotes, or { file = \"state.npy\" }",
            ))
        }
    }
}

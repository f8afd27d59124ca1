//! Configurations: a file and `--set` settings give a map, a loop and a diagnostic.

mod diagnostic;
pub mod document;
mod error;
mod integrator;
mod parts;
mod phase_loop;
pub mod section;
mod state_file;
mod system;
mod template;
mod trace;

use std::path::Path;
use std::sync::Arc;

use symplint::{Diagnostic, Loop, TimeAdvance};

pub use error::{ConfigError, Place, Source};
pub use parts::{Integrator, read_integrator, read_system};
pub use section::suggestion;
pub use symplint::request::parse_number;
pub use system::{SYSTEMS, System, SystemInfo};
pub use template::template;
pub use trace::TraceSettings;

use document::Table;

const SECTIONS: [&str; 5] = ["system", "integrator", "loop", "diagnostic", "trace"];

/// A configuration with all defaults filled in.
pub struct Config {
    /// The system under test.
    pub system: System,
    /// The integrator, its variant and faults, for headings.
    pub integrator: String,
    /// One step of it.
    pub map: Arc<dyn TimeAdvance>,
    /// The loop.
    pub phase_loop: Box<dyn Loop>,
    /// Its radii in words, if the map chose them.
    pub radii: Option<String>,
    /// Settings of `check`.
    pub diagnostic: Diagnostic,
    /// Settings of `trace`.
    pub trace: TraceSettings,
    /// Every key with its value, defaults included.
    pub resolved: toml::Table,
}

impl Config {
    /// Reads a file, or standard input if `path` is `-`, or takes the defaults of the system of that name; applies `--set` settings
    /// and builds the map and the loop.
    ///
    /// # Errors
    /// The first error, with its position and the remedy.
    pub fn load(path: &Path, settings: &[String]) -> Result<Self, ConfigError> {
        Self::load_with(path, settings, |_, _| Ok(()))
    }

    /// The same. `before_calls` is given the system and every key with its value before the map is called for the first time,
    /// as it is where it suggests the radii of the loop.
    ///
    /// # Errors
    /// The first error, also of `before_calls`.
    pub fn load_with<E: From<ConfigError>>(
        path: &Path,
        settings: &[String],
        before_calls: impl FnOnce(&System, &toml::Table) -> Result<(), E>,
    ) -> Result<Self, E> {
        let folder = path.parent().unwrap_or(Path::new(""));
        // The name of a system stands for its configuration, unless a file has this name.
        let system = SYSTEMS.iter().find(|of| Path::new(of.name) == path);
        let source = match system.filter(|_| !path.exists()) {
            Some(system) => {
                let name = system.name;
                (name.to_owned(), format!("[system]\nname = \"{name}\"\n"))
            }
            None => document::read(path)?,
        };
        Self::build(document::load(source, settings)?, folder, before_calls)
    }

    /// Relative paths of initial states start at `folder`.
    fn build<E: From<ConfigError>>(
        table: Table,
        folder: &Path,
        before_calls: impl FnOnce(&System, &toml::Table) -> Result<(), E>,
    ) -> Result<Self, E> {
        section::check_keys("", &table, SECTIONS.into_iter())?;
        let node = |name: &str| table.entries.get(name).map(|(_, node)| node);
        let mut resolved = toml::Table::new();

        let (info, system, section) = system::read(node("system"), folder)?;
        resolved.insert("system".into(), section.resolved().into());
        let (integrator, map, section) =
            integrator::read(node("integrator"), info.integrator, &system.model)?;
        resolved.insert("integrator".into(), section.resolved().into());
        let map: Arc<dyn TimeAdvance> = Arc::from(map);
        let (mut diagnostic, section) = diagnostic::read(node("diagnostic"))?;
        diagnostic.budget = diagnostic.budget.or(info.budget);
        resolved.insert("diagnostic".into(), section.resolved().into());
        let typical = || diagnostic.typical_step.unwrap_or(0.0);
        let largest = (diagnostic.step_sizes.iter().copied()).reduce(f64::max);
        let step_size = largest.unwrap_or_else(typical);
        let settings = phase_loop::read(node("loop"), system.q0.len())?;
        resolved.insert("loop".into(), settings.resolved().into());
        let (trace, section) = trace::read(node("trace"))?;
        resolved.insert("trace".into(), section.resolved().into());
        before_calls(&system, &resolved)?;
        let read = settings.build(&system, &map, step_size)?;
        resolved.insert("loop".into(), settings.resolved().into());
        Ok(Config {
            system,
            integrator,
            map,
            phase_loop: read.phase_loop,
            radii: read.radii,
            diagnostic,
            trace,
            resolved,
        })
    }
}

//! Configurations: a file and `--set` settings give a map, a loop and a diagnostic.

mod collect;
mod diagnostic;
pub mod document;
mod energy;
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
use symplint_report::table::degrees_of_freedom;

pub use error::{ConfigError, Place, Source};
pub use parts::{Integrator, read_integrator, read_system};
pub use section::{Kind, suggestion};
pub use symplint::request::parse_number;
pub use system::{SYSTEMS, System, SystemInfo};
pub use template::{setting, template};
pub use trace::TraceSettings;

use document::Table;
use energy::StepWithEnergy;

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
    /// All errors in the sections, with their positions and remedies; or else the first one when the loop is built.
    pub fn load(path: &Path, settings: &[String]) -> Result<Self, ConfigError> {
        Self::load_with(path, settings, |_, _| Ok(()))
    }

    /// The same. `before_calls` is given the system and every key with its value before the map is called for the first time,
    /// as it is where it suggests the radii of the loop.
    ///
    /// # Errors
    /// The same, and the errors of `before_calls`.
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
            None => match path
                .to_str()
                .filter(|name| may_be_system(name) && !path.exists())
            {
                Some(name) => return Err(unknown_system(name).into()),
                None => document::read(path)?,
            },
        };
        Self::build(document::load(source, settings)?, folder, before_calls)
    }

    /// Reads the text of a configuration. `name` is the source in messages, and relative paths start at the working folder.
    ///
    /// # Errors
    /// All errors in the sections.
    pub fn parse(name: &str, text: &str) -> Result<Self, ConfigError> {
        let source = (name.to_owned(), text.to_owned());
        Self::build(document::load(source, &[])?, Path::new(""), |_, _| Ok(()))
    }

    /// The system and, if it is not a map itself, the integrator: `pendulum, strang`.
    pub fn title(&self) -> String {
        self.names().join(", ")
    }

    /// The names of the system and of the integrator, if it has one.
    fn names(&self) -> Vec<String> {
        let mut names = vec![self.system.name.to_string()];
        if self.integrator != system::NOTHING {
            names.push(self.integrator.clone());
        }
        names
    }

    /// The same with the degrees of freedom, and the radii if they were searched for, for a line of text.
    pub fn heading(&self) -> String {
        let dof = degrees_of_freedom(self.map.dof());
        let mut heading = format!("{} · {dof}", self.names().join(" · "));
        if let Some(radii) = &self.radii {
            heading += &format!(" · {radii}");
        }
        heading
    }

    /// Relative paths of initial states start at `folder`.
    fn build<E: From<ConfigError>>(
        table: Table,
        folder: &Path,
        before_calls: impl FnOnce(&System, &toml::Table) -> Result<(), E>,
    ) -> Result<Self, E> {
        let read = match Sections::read(&table, folder) {
            Ok(read) => read,
            Err(first) => return Err(collect::errors(table, folder).unwrap_or(first).into()),
        };
        let Sections {
            system,
            integrator,
            map,
            settings,
            diagnostic,
            trace,
            mut resolved,
        } = read;
        let typical = || diagnostic.typical_step.unwrap_or(0.0);
        let largest = (diagnostic.step_sizes.iter().copied()).reduce(f64::max);
        let step_size = largest.unwrap_or_else(typical);
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

/// A configuration as it is written, before the map is called.
struct Sections {
    system: System,
    integrator: String,
    map: Arc<dyn TimeAdvance>,
    settings: phase_loop::LoopSettings,
    diagnostic: Diagnostic,
    trace: TraceSettings,
    /// Every key with its value.
    resolved: toml::Table,
}

impl Sections {
    /// Reads all sections.
    ///
    /// # Errors
    /// The first error.
    fn read(table: &Table, folder: &Path) -> Result<Self, ConfigError> {
        section::check_keys("", table, section::NAMES.into_iter())?;
        let node = |name: &str| table.entries.get(name).map(|(_, node)| node);
        let mut resolved = toml::Table::new();
        let (info, system, section) = system::read(node("system"), folder)?;
        resolved.insert("system".into(), section.resolved().into());
        let (integrator, map, section) =
            integrator::read(node("integrator"), info.integrator, &system.model)?;
        resolved.insert("integrator".into(), section.resolved().into());
        let (mut diagnostic, section) = diagnostic::read(node("diagnostic"))?;
        diagnostic.budget = diagnostic.budget.or(info.budget);
        resolved.insert("diagnostic".into(), section.resolved().into());
        let settings = phase_loop::read(node("loop"), system.q0.len())?;
        resolved.insert("loop".into(), settings.resolved().into());
        let (trace, section) = trace::read(node("trace"))?;
        resolved.insert("trace".into(), section.resolved().into());
        let map: Arc<dyn TimeAdvance> = match diagnostic.long_time {
            0 => Arc::from(map),
            _ => Arc::new(StepWithEnergy {
                map,
                model: system.model.clone(),
            }),
        };
        Ok(Sections {
            system,
            integrator,
            map,
            settings,
            diagnostic,
            trace,
            resolved,
        })
    }
}

/// Whether an argument looks like the name of a system, not like a path.
fn may_be_system(name: &str) -> bool {
    let of_name = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    name != "-" && name.chars().all(of_name)
}

fn unknown_system(name: &str) -> ConfigError {
    let systems = suggestion(name, SYSTEMS.iter().map(|info| info.name));
    ConfigError::new(
        format!("\"{name}\" is neither a file nor a system"),
        format!("{systems}. `symplint init SYSTEM` prints a configuration to start from"),
    )
}

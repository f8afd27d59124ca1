//! Systems and integrators by themselves, for bindings: without a loop and a diagnostic.

use std::path::Path;
use std::sync::Arc;

use symplint::TimeAdvance;

use crate::document::{Node, Table, Value};
use crate::{ConfigError, Place, Source, System, integrator, system};

/// One step of a method for a system.
pub struct Integrator {
    /// Its name, with variant and faults, for headings.
    pub name: String,
    /// The step.
    pub map: Arc<dyn TimeAdvance>,
    /// Every key with its value, defaults included.
    pub resolved: toml::Table,
}

/// The system that the keys of a `[system]` section describe, `name` among them, and all its keys, defaults included.
/// Relative paths of initial states start at `folder`.
///
/// # Errors
/// As those of a configuration.
pub fn read_system(keys: Table, folder: &Path) -> Result<(System, toml::Table), ConfigError> {
    let (_, system, section) = system::read(Some(&section("system", keys)), folder)?;
    Ok((system, section.resolved()))
}

/// The step that the keys of an `[integrator]` section describe, for a system.
///
/// # Errors
/// As those of a configuration.
pub fn read_integrator(keys: Table, system: &System) -> Result<Integrator, ConfigError> {
    let default = (system::SYSTEMS.iter())
        .find(|info| info.name == system.name)
        .map_or("\"strang\"", |info| info.integrator);
    let node = section("integrator", keys);
    let (name, map, section) = integrator::read(Some(&node), default, &system.model)?;
    Ok(Integrator {
        name,
        map: Arc::from(map),
        resolved: section.resolved(),
    })
}

/// Keys as the section that they would be in a file.
fn section(name: &str, keys: Table) -> Node {
    let place = (keys.entries.values().next()).map_or_else(
        || Place {
            source: Arc::new(Source {
                name: name.to_owned(),
                text: String::new(),
            }),
            span: 0..0,
        },
        |(place, _)| place.clone(),
    );
    Node {
        value: Value::Table(keys),
        place,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document;

    fn keys(text: &str) -> Table {
        document::parse("keys", text.to_owned()).unwrap()
    }

    #[test]
    fn a_system_and_its_step_are_those_of_a_configuration() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("c.toml");
        let text = "[system]\nname = \"pendulum\"\np0 = 0.25\n[integrator]\nname = \"yoshida4\"\n";
        std::fs::write(&path, text).unwrap();
        let config = crate::Config::load(&path, &[]).unwrap();
        let (system, resolved) =
            read_system(keys("name = \"pendulum\"\np0 = 0.25"), Path::new("")).unwrap();
        assert_eq!(toml::Value::from(resolved), config.resolved["system"]);
        assert_eq!((system.q0, system.p0), (config.system.q0, config.system.p0));
        let (system, _) = read_system(keys("name = \"pendulum\""), Path::new("")).unwrap();
        let integrator = read_integrator(keys("name = \"yoshida4\""), &system).unwrap();
        assert_eq!(integrator.name, config.integrator);
        let resolved = toml::Value::from(integrator.resolved);
        assert_eq!(resolved, config.resolved["integrator"]);
    }

    #[test]
    fn without_keys_the_integrator_is_that_of_the_system() {
        for (name, expected) in [("pendulum", "strang"), ("henon-map", "none")] {
            let text = format!("name = \"{name}\"");
            let (system, _) = read_system(keys(&text), Path::new("")).unwrap();
            let integrator = read_integrator(Table::default(), &system).unwrap();
            assert_eq!(integrator.name, expected);
        }
    }

    #[test]
    fn wrong_keys_are_named() {
        let error = |text| {
            let error = read_system(keys(text), Path::new("")).err().unwrap();
            (error.message, error.remedy.unwrap_or_default())
        };
        let (message, _) = error("name = \"pendulum\"\nomega = 2.0");
        assert!(message.contains("omega"), "{message}");
        let (message, remedy) = error("name = \"pendulm\"");
        assert!(message.contains("pendulm") && remedy.contains("pendulum"));
        let (system, _) = read_system(keys("name = \"toda\""), Path::new("")).unwrap();
        let refused = read_integrator(keys("name = \"boris\""), &system).err();
        assert!(refused.unwrap().message.contains("boris"));
    }
}

//! All errors of a configuration, not the first one alone.
//!
//! A reader stops at its first error. To find the next one, the key that caused the error is removed, so that its default
//! applies, and the section is read again.

use std::path::Path;

use super::document::{Node, Table, Value};
use super::error::{ConfigError, Place};
use super::{diagnostic, integrator, phase_loop, section, system, trace};

/// More errors of a section are not listed. Conventional.
const MAX_ERRORS: usize = 20;

/// The errors of a configuration that cannot be read, in their order in the file.
pub fn errors(mut table: Table, folder: &Path) -> Option<ConfigError> {
    let mut errors = all_of(&mut table, |table| {
        section::check_keys("", table, section::NAMES.into_iter())
    })
    .1;
    let mut of_section = |name: &str| Reader {
        node: table.entries.remove(name).map(|(_, node)| node),
    };
    let (mut of_system, mut of_integrator) = (of_section("system"), of_section("integrator"));
    let (mut of_loop, mut of_diagnostic) = (of_section("loop"), of_section("diagnostic"));
    let mut of_trace = of_section("trace");
    let read = of_system.read(&mut errors, |node| system::read(node, folder));
    if let Some((info, system, _)) = read {
        of_integrator.read(&mut errors, |node| {
            integrator::read(node, info.integrator, &system.model)
        });
        of_loop.read(&mut errors, |node| phase_loop::read(node, system.q0.len()));
    }
    of_diagnostic.read(&mut errors, diagnostic::read);
    of_trace.read(&mut errors, trace::read);
    errors.sort_by_key(|error| {
        let place = error.position.as_ref().map(|(place, _)| place);
        place.map(|place| (place.source.name.clone(), place.span.start))
    });
    ConfigError::joined(errors)
}

/// A section as it was written, less the keys with errors.
struct Reader {
    node: Option<Node>,
}

impl Reader {
    /// What `read` makes of the section, and its errors. Nothing if an error has no key.
    fn read<T>(
        &mut self,
        errors: &mut Vec<ConfigError>,
        read: impl Fn(Option<&Node>) -> Result<T, ConfigError>,
    ) -> Option<T> {
        let Some(Node {
            value: Value::Table(_),
            ..
        }) = &self.node
        else {
            return read(self.node.as_ref())
                .map_err(|error| errors.push(error))
                .ok();
        };
        let Some(node) = &mut self.node else {
            return None;
        };
        let place = node.place.clone();
        let Value::Table(table) = &mut node.value else {
            return None;
        };
        let (value, found) = all_of(table, |table| {
            let value = Value::Table(table.clone());
            let place = place.clone();
            read(Some(&Node { value, place }))
        });
        errors.extend(found);
        value
    }
}

/// What `read` makes of a table without the keys that it refuses, and these errors. An error that a removed key causes, such as a
/// key that must be given, is not one of the file.
fn all_of<T>(
    table: &mut Table,
    read: impl Fn(&Table) -> Result<T, ConfigError>,
) -> (Option<T>, Vec<ConfigError>) {
    let mut errors: Vec<ConfigError> = Vec::new();
    while errors.len() < MAX_ERRORS {
        let error = match read(table) {
            Ok(value) => return (Some(value), errors),
            Err(error) => error,
        };
        let place = error.position.as_ref().map(|(place, _)| place.clone());
        let is_removed = place.is_some_and(|place| remove(table, &place));
        if is_removed || errors.is_empty() {
            errors.push(error);
        }
        if !is_removed {
            break;
        }
    }
    (None, errors)
}

/// Removes the innermost key whose name or value has this place.
fn remove(table: &mut Table, place: &Place) -> bool {
    let has = |of: &Place| {
        of.source.name == place.source.name
            && of.source.text == place.source.text
            && of.span.start <= place.span.start
            && place.span.end <= of.span.end
    };
    let found = (table.entries.iter()).find(|(_, (key, node))| has(key) || has(&node.place));
    let Some(name) = found.map(|(name, _)| name.clone()) else {
        return false;
    };
    if let Some((key, node)) = table.entries.get_mut(&name)
        && !has(key)
        && let Value::Table(inner) = &mut node.value
        && remove(inner, place)
    {
        return true;
    }
    table.entries.remove(&name);
    true
}

#[cfg(test)]
mod tests {
    use crate::Config;

    /// The messages about a configuration.
    fn messages(text: &str) -> Vec<String> {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("run.toml");
        std::fs::write(&path, text).unwrap();
        let first = Config::load(&path, &[]).err().expect("it has errors");
        let others = first.others.iter().map(|error| error.message.clone());
        std::iter::once(first.message.clone())
            .chain(others)
            .collect()
    }

    #[test]
    fn errors_of_all_sections_are_listed_in_their_order() {
        let found = messages(
            "[system]\nname = \"pendulum\"\nomega = 2\npotential = \"tan\"\n[integrator]\nname = \"strong\"\n\
             [loop]\nradius = { q = 1, p = \"x\" }\nsize = 3\n[diagnostic]\nbudget = -4\nrule = \"exact\"\n[tracing]\nsteps = 5\n",
        );
        let expected = [
            "omega",
            "potential",
            "strong",
            "radius.p",
            "size",
            "budget",
            "rule",
            "[tracing]",
        ];
        assert_eq!(found.len(), expected.len(), "{found:#?}");
        for (message, word) in found.iter().zip(expected) {
            assert!(message.contains(word), "{word}: {message}");
        }
    }

    #[test]
    fn removed_keys_cause_no_errors() {
        let found = messages("[system]\nname = \"pendulm\"\np0 = 3\n[diagnostic]\nloops = \"x\"\n");
        assert_eq!(found.len(), 2, "{found:#?}");
        assert!(found[0].contains("pendulm") && found[1].contains("loops"));
        // One error stays one.
        let found = messages("[system]\nname = \"pendulum\"\nq0 = [1, 2]\n");
        assert_eq!(found.len(), 1, "{found:#?}");
    }
}

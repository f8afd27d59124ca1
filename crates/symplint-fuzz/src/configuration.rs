//! Configurations: systems, integrators, loops and diagnostics are built, and not run.

use symplint_config::document::{self, Node, Table, Value};
use symplint_config::{Config, ConfigError, parse_number};

use crate::files::with_file;

/// Keys that say how large something is, or how often it is done.
const SIZES: [&str; 10] = [
    "pendula",
    "masses",
    "dof",
    "particles",
    "cells",
    "filter",
    "mode",
    "degree",
    "iterations",
    "max_iterations",
];

/// Sizes from here on take time or memory that a user asked for, and are not tried.
const LARGE: f64 = 256.0;

/// Sizes from here on must be refused at once.
const ABSURD: f64 = 1e12;

/// Reads the bytes as a configuration. What follows a byte 0 is a `--set` setting.
pub fn configuration(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    let mut parts = text.split('\0');
    let file = parts.next().unwrap_or("");
    let settings: Vec<String> = parts.map(str::to_owned).collect();
    let Ok(config) = load(file, &settings) else {
        return;
    };
    // That of a run folder, from which a run continues.
    let resolved = config.resolved.to_string();
    if let Err(error) = load(&resolved, &[]) {
        panic!(
            "the resolved configuration is refused: {}\n{resolved}",
            error.message
        );
    }
}

fn load(text: &str, settings: &[String]) -> Result<Config, ConfigError> {
    with_file("fuzz.toml", text.as_bytes(), |path| {
        let table = document::load(document::read(path)?, settings)?;
        if !is_harmless(&table) {
            return Err(ConfigError::new("not tried", ""));
        }
        let config = Config::load(path, settings);
        if let Err(error) = &config {
            let _ = (error.message.len(), error.remedy.as_ref().map(String::len));
        }
        config
    })
}

/// Whether it builds nothing large, and calls no program: the search for radii evaluates the map.
fn is_harmless(table: &Table) -> bool {
    let section = |name: &str| match table.entries.get(name) {
        Some((
            _,
            Node {
                value: Value::Table(section),
                ..
            },
        )) => Some(section),
        _ => None,
    };
    let text = |name: &str, key: &str| {
        let (_, node) = section(name)?.entries.get(key)?;
        match &node.value {
            Value::Text(text) => Some(text.as_str()),
            _ => None,
        }
    };
    let calls = text("system", "name") == Some("command") && text("loop", "radius") == Some("auto");
    let is_large = |node: &Node| {
        let size = match &node.value {
            Value::Integer(number) => *number as f64,
            Value::Float(number) => *number,
            Value::Text(text) => parse_number(text).unwrap_or(0.0),
            _ => 0.0,
        };
        (LARGE..ABSURD).contains(&size)
    };
    let mut sizes = (["system", "integrator"].into_iter().filter_map(section))
        .flat_map(|section| SIZES.iter().filter_map(|key| section.entries.get(*key)));
    !calls && !sizes.any(|(_, node)| is_large(node))
}

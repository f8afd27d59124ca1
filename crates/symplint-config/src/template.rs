//! Starter configurations.

use std::fmt::Write;

use symplint_report::wrap::wrapped;

use super::section::Key;
use super::system::{SYSTEMS, SystemInfo};
use super::{diagnostic, integrator, phase_loop, trace};

/// Characters of a line at most.
const WIDTH: usize = 80;

/// Where comments begin.
const COLUMN: usize = 28;

/// Keys of a system that a short configuration has, in addition to those that must be given.
const FEW: usize = 4;

/// Keys of the other sections that a short configuration has.
const SHORT: [(&str, &[&str]); 3] = [
    ("integrator", &["name"]),
    ("loop", &["radius"]),
    ("diagnostic", &["step_sizes", "budget"]),
];

/// A commented configuration of `system`: with the keys that are changed most, or with `all`. Keys without a default are commented
/// out, with an example.
pub fn template(system: &SystemInfo, all: bool) -> String {
    let title = format!("{}: {}", system.name, system.summary);
    let mut text = format!(
        "{}\n# Run it with: symplint check THIS_FILE\n\n[system]\nname = \"{}\"\n",
        wrapped("# ", "# ", &title, Some(WIDTH)),
        system.name
    );
    let of_system = (system.keys.iter().enumerate())
        .filter(|(k, key)| all || key.required || (*k < FEW && !key.optional))
        .map(|(_, key)| key);
    write_keys(&mut text, of_system);
    for (name, keys) in sections(system) {
        let short = SHORT.iter().find(|(section, _)| *section == name);
        let short = short.map_or(&[][..], |(_, keys)| keys);
        if all || !short.is_empty() {
            let _ = write!(text, "\n[{name}]\n");
            write_keys(
                &mut text,
                keys.iter().filter(|key| all || short.contains(&key.name)),
            );
        }
    }
    if !all {
        let _ = write!(text, "\n# Every key: symplint init {} --all\n", system.name);
    }
    text
}

/// The sections but `[system]`, with their keys.
fn sections(system: &SystemInfo) -> [(&'static str, Vec<Key>); 4] {
    [
        ("integrator", integrator::keys(system.integrator).to_vec()),
        ("loop", phase_loop::KEYS.to_vec()),
        ("diagnostic", diagnostic::keys()),
        ("trace", trace::KEYS.to_vec()),
    ]
}

/// The full name of a setting: `diagnostic.budget` for `budget`, and `integrator.name` for `integrator`. `None` for an unknown key.
///
/// If several sections have the key, the section named as the command comes first, then `[diagnostic]`. `[system]` comes last; if no
/// system is called `system`, the keys of every system count.
pub fn setting(command: &str, system: &str, key: &str) -> Option<String> {
    if key == "integrator" {
        return Some("integrator.name".into());
    }
    let is_known = SYSTEMS.iter().any(|info| info.name == system);
    let systems = SYSTEMS
        .iter()
        .filter(|info| !is_known || info.name == system);
    let mut names = Vec::new();
    for info in systems {
        let of_section = |(section, keys): (&'static str, Vec<Key>)| {
            keys.into_iter().map(move |key| (section, key.name))
        };
        // Only `trace` has the settings of a trace.
        let is_of_command =
            |(section, _): &(&str, Vec<Key>)| *section != "trace" || command == "trace";
        names.extend(
            sections(info)
                .into_iter()
                .filter(is_of_command)
                .flat_map(of_section),
        );
        names.extend(info.keys.iter().map(|key| ("system", key.name)));
    }
    let rank = |section: &str| match section {
        of_command if of_command == command => 0,
        "diagnostic" => 1,
        "system" => 3,
        _ => 2,
    };
    names.sort_by_key(|(section, _)| rank(section));
    let (section, name) = names.into_iter().find(|(_, name)| *name == key)?;
    Some(format!("{section}.{name}"))
}

fn write_keys<'a>(text: &mut String, keys: impl Iterator<Item = &'a Key>) {
    for key in keys {
        let mark = if key.optional { "# " } else { "" };
        let mut line = format!("{mark}{} = {}", key.name, key.value);
        if line.chars().count() >= COLUMN {
            line.push('\n');
            line += &" ".repeat(COLUMN);
        }
        let indent = " ".repeat(COLUMN) + "# ";
        let first = format!("{line:<COLUMN$}# ");
        let _ = writeln!(text, "{}", wrapped(&first, &indent, key.help, Some(WIDTH)));
    }
}

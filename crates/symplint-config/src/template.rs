//! Starter configurations.

use std::fmt::Write;

use symplint_report::wrap::wrapped;

use super::section::Key;
use super::system::SystemInfo;
use super::{diagnostic, integrator, phase_loop, trace};

/// Characters of a line at most.
const WIDTH: usize = 80;

/// Where comments begin.
const COLUMN: usize = 28;

/// A commented configuration of `system` with every key. Those without a default are commented out, with an
/// example.
pub fn template(system: &SystemInfo) -> String {
    let title = format!("{}: {}", system.name, system.summary);
    let mut text = format!(
        "{}\n# Run it with: symplint check THIS_FILE\n\n[system]\nname = \"{}\"\n",
        wrapped("# ", "# ", &title, Some(WIDTH)),
        system.name
    );
    write_keys(&mut text, system.keys);
    for (name, keys) in [
        ("integrator", &integrator::keys(system.integrator)[..]),
        ("loop", phase_loop::KEYS),
        ("diagnostic", &diagnostic::keys()),
        ("trace", trace::KEYS),
    ] {
        let _ = write!(text, "\n[{name}]\n");
        write_keys(&mut text, keys);
    }
    text
}

fn write_keys(text: &mut String, keys: &[Key]) {
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

//! Starter configurations.

use std::fmt::Write;

use super::section::Key;
use super::system::SystemInfo;
use super::{diagnostic, integrator, phase_loop, trace};

/// A commented configuration of `system` with every key. Those without a default are commented out, with an
/// example.
pub fn template(system: &SystemInfo) -> String {
    let mut text = format!(
        "# {}: {}\n# Run it with: symplint check THIS_FILE\n\n[system]\nname = \"{}\"\n",
        system.name, system.summary, system.name
    );
    write_keys(&mut text, system.keys);
    for (name, keys) in [
        ("integrator", &integrator::keys(system.integrator)[..]),
        ("loop", phase_loop::KEYS),
        ("diagnostic", diagnostic::KEYS),
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
        let line = format!("{mark}{} = {}", key.name, key.value);
        let _ = writeln!(text, "{line:<34} # {}", key.help);
    }
}

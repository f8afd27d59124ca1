//! `symplint init SYSTEM`.

use symplint_config::{SYSTEMS, suggestion, template};

use crate::failure::Failure;
use crate::output::say;
use crate::status::{SUCCESS, Status};

/// Prints a starter configuration, with all keys or a few.
pub fn init(name: &str, all: bool) -> Result<Status, Failure> {
    let info = (SYSTEMS.iter().find(|info| info.name == name)).ok_or_else(|| Failure::Unknown {
        what: "system",
        name: name.to_owned(),
        suggestion: suggestion(name, SYSTEMS.iter().map(|info| info.name)),
    })?;
    say(template(info, all).trim_end())?;
    Ok(SUCCESS)
}

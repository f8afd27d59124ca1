//! Printing on standard output.

use std::io::{ErrorKind, Write};
use std::path::PathBuf;

use crate::commands::Failure;

/// Prints a text and a line break. A closed pipe is not an error.
pub fn say(text: impl std::fmt::Display) -> Result<(), Failure> {
    let mut out = anstream::stdout().lock();
    match writeln!(out, "{text}").and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::Write {
            path: PathBuf::from("standard output"),
            reason: error.to_string(),
        }),
        _ => Ok(()),
    }
}

//! Printing on standard output and standard error.

use std::io::{ErrorKind, Write};
use std::path::PathBuf;

use crate::failure::Failure;

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

/// Prints a text and a line break on standard error. If it cannot be written, the user cannot be informed, and the program
/// continues: its exit status does not depend on it.
pub fn tell(text: impl std::fmt::Display) {
    let mut error = anstream::stderr().lock();
    let _ = writeln!(error, "{text}").and_then(|()| error.flush());
}

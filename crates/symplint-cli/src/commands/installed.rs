//! `symplint completions SHELL` and `symplint man DIR`: files that an installation adds for shells and `man`.

use std::fs;
use std::path::Path;

use clap::CommandFactory;
use clap_complete::Shell;

use crate::cli::Cli;
use crate::failure::Failure;
use crate::output::say;
use crate::status::{SUCCESS, Status};

/// Prints a completion script.
pub fn completions(shell: Shell) -> Result<Status, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "symplint", &mut script);
    say(String::from_utf8_lossy(&script).trim_end())?;
    Ok(SUCCESS)
}

/// Writes the manual pages.
pub fn man(folder: &Path) -> Result<Status, Failure> {
    let write = || {
        fs::create_dir_all(folder)?;
        clap_mangen::generate_to(Cli::command(), folder)
    };
    write().map_err(|error| Failure::Write {
        path: folder.to_owned(),
        reason: error.to_string(),
    })?;
    Ok(SUCCESS)
}

//! `symplint resume DIR`.

use std::fs;
use std::path::{Path, PathBuf};

use symplint_run::command_of;

use super::check::{Calls, diagnose};
use crate::cli::{ResumeArgs, Run};
use crate::failure::Failure;
use crate::provenance;
use crate::status::{SUCCESS, Status};

/// Goes on with a run of `check` that was stopped. Evaluations that its journal has are not made again.
pub fn resume(arguments: &ResumeArgs) -> Result<Status, Failure> {
    let started = provenance::start();
    let config = config_of_run(&arguments.folder)?;
    let run = Run {
        out: Some(arguments.folder.clone()),
        force: false,
        shown: arguments.shown.clone(),
    };
    let status = diagnose(&started, (&config, &[]), &run, Calls::Here)?;
    Ok(status.unwrap_or(SUCCESS))
}

/// The file with the configuration of a run of `check` in a folder.
///
/// # Errors
/// If the folder has no such file.
pub(super) fn config_of_run(folder: &Path) -> Result<PathBuf, Failure> {
    let path = folder.join("config.toml");
    let no_run = |reason: String| Failure::NoRun {
        folder: folder.to_owned(),
        reason,
    };
    let text = fs::read_to_string(&path)
        .map_err(|error| no_run(format!("config.toml cannot be read ({error})")))?;
    match command_of(&text) {
        Some("check") => {}
        Some(other) => return Err(no_run(format!("it is one of `symplint {other}`"))),
        None => return Err(no_run("config.toml is not that of a run".into())),
    }
    Ok(path)
}

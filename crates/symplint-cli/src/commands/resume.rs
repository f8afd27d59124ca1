//! `symplint resume DIR`.

use std::fs;
use std::process::ExitCode;

use symplint_config::Config;

use super::Failure;
use super::check::diagnose;
use super::earlier_run::command_of;
use crate::cli::{ResumeArgs, Run};
use crate::provenance;

/// Goes on with a run of `check` that was stopped. Evaluations that its journal has are not made again.
pub fn resume(arguments: &ResumeArgs) -> Result<ExitCode, Failure> {
    let started = provenance::start();
    let folder = &arguments.folder;
    let path = folder.join("config.toml");
    let no_run = |reason: String| Failure::NoRun {
        folder: folder.clone(),
        reason,
    };
    let text = fs::read_to_string(&path)
        .map_err(|error| no_run(format!("config.toml cannot be read ({error})")))?;
    match command_of(&text) {
        Some("check") => {}
        Some(other) => return Err(no_run(format!("it is one of `symplint {other}`"))),
        None => return Err(no_run("config.toml is not that of a run".into())),
    }
    let run = Run {
        out: Some(folder.clone()),
        force: false,
        shown: arguments.shown.clone(),
    };
    diagnose(&started, Config::load(&path, &[])?, &run)
}

//! `symplint plan CONFIG.toml --out DIR` and `symplint collect DIR`: runs whose calls the jobs of a scheduler make.

use std::path::Path;

use symplint_run::Request;

use super::check::{Calls, diagnose};
use super::resume::config_of_run;
use crate::cli::{OutputArgs, PlanArgs, ResumeArgs, Run};
use crate::failure::Failure;
use crate::output::{go_on, say, tell};
use crate::provenance;
use crate::status::Status;

/// The exit status where a round of calls is to be made.
const ROUND_TO_MAKE: u8 = 4;

/// Writes the first calls of a run, or the next ones.
pub fn plan(arguments: &PlanArgs) -> Result<Status, Failure> {
    let started = provenance::start();
    let run = Run {
        out: Some(arguments.out.clone()),
        force: arguments.force,
        shown: arguments.shown.clone(),
    };
    let source = (&*arguments.config, &*arguments.settings.set);
    let status = diagnose(&started, source, &run, Calls::ByJobs)?;
    Ok(status.unwrap_or(ROUND_TO_MAKE))
}

/// Takes in what jobs made, and plans on or judges.
pub fn collect(arguments: &ResumeArgs) -> Result<Status, Failure> {
    let started = provenance::start();
    let config = config_of_run(&arguments.folder)?;
    let run = Run {
        out: Some(arguments.folder.clone()),
        force: false,
        shown: arguments.shown.clone(),
    };
    let status = diagnose(&started, (&config, &[]), &run, Calls::ByJobs)?;
    Ok(status.unwrap_or(ROUND_TO_MAKE))
}

/// Says what is to be done.
pub(super) fn say_round(
    requests: &[Request],
    folder: &Path,
    shown: &OutputArgs,
) -> Result<(), Failure> {
    let states: usize = requests
        .iter()
        .map(|request| request.states.samples())
        .sum();
    let mut sizes: Vec<f64> = requests.iter().map(|request| request.h).collect();
    sizes.dedup();
    let calls = match requests.len() {
        1 => "1 call".to_owned(),
        count => format!("{count} calls"),
    };
    let of = match sizes.len() {
        1 => format!("h = {:?}", sizes[0]),
        count => format!("{count} step sizes"),
    };
    let round = format!("next round: {calls} with {states} states in all, {of}");
    if shown.json {
        // Standard output is for the report.
        tell(round);
        return Ok(());
    }
    say(round)?;
    if !shown.quiet {
        let count = requests.len();
        let (advance, collect) = (go_on("advance", folder), go_on("collect", folder));
        say(format!(
            "make them by `{advance} --part K/N` for K = 1 … N, N up to {count}, then `{collect}`"
        ))?;
    }
    Ok(())
}

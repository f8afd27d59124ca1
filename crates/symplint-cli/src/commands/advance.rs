//! `symplint advance DIR --part K/N`: one job's part of a round of calls.

use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};

use symplint::StepFailure;
use symplint_config::Config;
use symplint_journal::Request;

use super::resume::config_of_run;
use super::round::Round;
use super::run_output::run_of_config;
use crate::cli::AdvanceArgs;
use crate::failure::Failure;
use crate::output::{Progress, say, tell};
use crate::signals;

/// Makes the calls of a part, each once: those that an earlier job of the round made are not made again.
pub fn advance(arguments: &AdvanceArgs) -> Result<ExitCode, Failure> {
    let (k, n) = arguments.part;
    let path = config_of_run(&arguments.folder)?;
    // A run whose configuration makes calls of its own has no round.
    let config = Config::load_with(&path, &[], |_, _| Round::check_there(&arguments.folder))?;
    let Some(map) = &config.system.command else {
        return Err(Failure::Usage {
            message: format!("{} is not the run of a command", arguments.folder.display()),
            remedy: "only calls of programs (system.name = \"command\") are made by jobs".into(),
        });
    };
    let round = Round::of_run(&arguments.folder, &run_of_config(map, &config.resolved)?);
    let requests = round.read()?;
    // Calls of one step size, which take about as long, go to different parts.
    let part: Vec<&Request> = requests.iter().skip(k - 1).step_by(n).collect();
    let journal = round.part(k, n)?;
    signals::note_part(&arguments.folder, arguments.part);
    // Also those of an earlier job for a part that was cut in another way.
    let made = round.made()?;
    let needed: Vec<&Request> = (part.iter().copied())
        .filter(|request| !made.contains(&request.call))
        .collect();
    let progress = Progress::new("calls", arguments.quiet);
    progress.plan(needed.len());
    let failed: Mutex<Vec<(usize, StepFailure)>> = Mutex::default();
    let place = |request: &Request| part.iter().position(|other| other.call == request.call);
    let made = map.make(&needed, &journal, &|request, result| {
        progress.step();
        if let (Err(failure), Some(place)) = (result, place(request)) {
            let mut failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
            failed.push((place, failure));
        }
    });
    progress.finish();
    let mut failed = failed.into_inner().unwrap_or_else(PoisonError::into_inner);
    failed.sort_by_key(|(place, _)| *place);
    let failed: Vec<(&Request, StepFailure)> = (failed.into_iter())
        .map(|(place, failure)| (part[place], failure))
        .collect();
    // Those that failed also where what came then ends the job.
    let noted = round.note_failed((k, n), &journal, &failed);
    made?;
    noted?;
    journal.finish()?;
    for (request, failure) in &failed {
        tell(format!(
            "error: a call with {} states and h = {:?} failed: {}",
            request.states.samples(),
            request.h,
            failure.reason
        ));
    }
    if !arguments.quiet {
        let made = part.len() - failed.len();
        say(format!(
            "part {k} of {n}: {made} of {} calls made",
            part.len()
        ))?;
    }
    Ok(ExitCode::from(if failed.is_empty() { 0 } else { 2 }))
}

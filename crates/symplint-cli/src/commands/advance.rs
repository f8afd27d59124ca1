//! `symplint advance DIR --part K/N`: one job's part of a round of calls.

use symplint_config::{Config, parse_number};
use symplint_run::{Request, Round, RunError};

use super::resume::config_of_run;
use crate::cli::AdvanceArgs;
use crate::failure::Failure;
use crate::output::{Progress, say, tell};
use crate::signals;
use crate::status::{FAILED, SUCCESS, Status};

/// Makes the calls of a part, each once: those that an earlier job of the round made are not made again.
pub fn advance(arguments: &AdvanceArgs) -> Result<Status, Failure> {
    let (k, n) = arguments.part;
    let path = config_of_run(&arguments.folder)?;
    // Until this job ends, no other run has the folder. A configuration that makes calls itself has no round.
    let mut _shared = None;
    let config = Config::load_with(&path, &[], |_, _| {
        _shared = Some(Round::share(&arguments.folder)?);
        Ok::<(), Failure>(())
    })?;
    let Some(map) = &config.system.command else {
        return Err(Failure::Usage {
            message: format!("{} is not the run of a command", arguments.folder.display()),
            remedy: "only calls of programs (system.name = \"command\") are made by jobs".into(),
        });
    };
    let round = Round::of_config(&arguments.folder, map, &config.resolved, parse_number)?;
    let requests = round.read()?;
    // Calls of one step size, which take about as long, go to different parts.
    let part: Vec<&Request> = requests.iter().skip(k - 1).step_by(n).collect();
    let journal = round.part((k, n))?;
    signals::note_part(&arguments.folder, arguments.part);
    // Also those of an earlier job for a part that was cut in another way.
    let made = round.made()?;
    let needed: Vec<&Request> = (part.iter().copied())
        .filter(|request| !made.contains(&request.call))
        .collect();
    let progress = Progress::steady("calls", arguments.quiet);
    progress.plan(needed.len());
    let (failed, made) = map.make(&needed, &journal, &|| progress.step());
    progress.finish();
    // Also if another call ends the job.
    round.store_failed(arguments.part, &journal, &failed)?;
    made.map_err(RunError::from)?;
    journal.finish().map_err(RunError::from)?;
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
    Ok(if failed.is_empty() { SUCCESS } else { FAILED })
}

//! The `symplint` program: is a time-advance map symplectic?
//!
//! A library, so that the Python package has the program, too.

mod cli;
mod commands;
mod failure;
mod output;
mod provenance;
mod signals;
mod status;

use std::ffi::OsString;

use clap::Parser;

use cli::{Cli, Command};
use failure::Failure;
use status::{FAILED, Status};

/// Runs a command line, the name of the program first, and returns the exit status of the program.
///
/// From here on Ctrl-C ends the process.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> Status {
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(said) => {
            // Help is not a failure. If it cannot be printed, no other message can be printed either.
            let _ = said.print();
            return Status::try_from(said.exit_code()).unwrap_or(FAILED);
        }
    };
    signals::handle();
    match execute(&cli) {
        Ok(status) => status,
        Err(failure) => {
            output::tell(output::failure_message(&failure));
            FAILED
        }
    }
}

/// The threads to start: one for each processor if no number is given (0), and never more, which would only take time.
fn threads(wanted: Option<usize>) -> usize {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    match wanted {
        Some(count) if count > processors => {
            let s = if processors == 1 { "" } else { "s" };
            output::tell(format!(
                "note: --threads {count} exceeds the number of processors; {processors} thread{s} will be used"
            ));
            processors
        }
        wanted => wanted.unwrap_or(0),
    }
}

fn execute(cli: &Cli) -> Result<Status, Failure> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads(cli.command.threads()))
        .build()
        .map_err(|error| Failure::Threads {
            reason: error.to_string(),
        })?;
    pool.install(|| match &cli.command {
        Command::Check(arguments) => commands::check(arguments),
        Command::Loop(arguments) => commands::write_loop(arguments),
        Command::Measure(arguments) => commands::measure(arguments),
        Command::Judge(arguments) => commands::judge(arguments),
        Command::Resume(arguments) => commands::resume(arguments),
        Command::Plan(arguments) => commands::plan(arguments),
        Command::Advance(arguments) => commands::advance(arguments),
        Command::Collect(arguments) => commands::collect(arguments),
        Command::Trace(arguments) => commands::trace(arguments),
        Command::Reproduce(arguments) => commands::reproduce(arguments),
        Command::List { what } => commands::list(*what),
        Command::Init { system, all } => commands::init(system, *all),
        Command::Completions { shell } => commands::completions(*shell),
        Command::Man { folder } => commands::man(folder),
    })
}

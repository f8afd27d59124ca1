//! The `symplint` program: is a time-advance map symplectic?

mod cli;
mod commands;
mod output;
mod provenance;
mod signals;

use std::process::ExitCode;

use clap::Parser;

use cli::{Cli, Command};
use commands::Failure;

fn main() -> ExitCode {
    let cli = Cli::parse();
    signals::handle();
    match run(&cli) {
        Ok(status) => status,
        Err(failure) => {
            output::tell(output::failure_message(&failure));
            ExitCode::from(2)
        }
    }
}

/// Threads at most. More than a machine has cores cost memory and gain nothing.
const MOST_THREADS: usize = 1024;

fn run(cli: &Cli) -> Result<ExitCode, Failure> {
    let threads = cli.command.threads();
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.map_or(0, |count| count.min(MOST_THREADS)))
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
        Command::Init { system } => commands::init(system),
    })
}

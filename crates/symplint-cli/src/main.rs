//! The `symplint` program: is a time-advance map symplectic?

mod cli;
mod commands;
mod config;
mod output;
mod provenance;

use std::process::ExitCode;

use clap::Parser;

use cli::{Cli, Command};
use commands::Failure;

fn main() -> ExitCode {
    let cli = Cli::parse();
    match run(&cli) {
        Ok(status) => status,
        Err(failure) => {
            anstream::eprintln!("{:?}", miette::Report::from(failure));
            ExitCode::from(2)
        }
    }
}

/// More threads than any machine has cores only cost memory.
const MOST_THREADS: usize = 1024;

fn run(cli: &Cli) -> Result<ExitCode, Failure> {
    let common = &cli.common;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(
            common
                .threads
                .map_or(0, |n| usize::from(n).min(MOST_THREADS)),
        )
        .build()
        .map_err(|error| Failure::Threads {
            reason: error.to_string(),
        })?;
    pool.install(|| match &cli.command {
        Command::Check { config, steps } => commands::check(config, *steps, common),
        Command::Loop {
            config,
            samples,
            output,
        } => commands::write_loop(config, *samples, output.as_deref(), common),
        Command::Measure {
            before,
            after,
            h,
            period,
            weight,
        } => {
            let stated = commands::Stated {
                step_sizes: h,
                period,
                weight,
            };
            commands::measure(before, after, &stated, common)
        }
        Command::Trace { config } => commands::trace(config, common),
        Command::Reproduce { ids, list } => commands::reproduce(ids, *list, common),
        Command::List { what } => commands::list(*what, common),
        Command::Init { system } => commands::init(system, common),
    })
}

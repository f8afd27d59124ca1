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

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Parser};
use symplint_config::setting;

use cli::{Cli, Command};
use failure::Failure;
use status::{FAILED, Status};

/// Runs a command line, the name of the program first, and returns the exit status of the program.
///
/// From here on Ctrl-C ends the process.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> Status {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let cli = match Cli::try_parse_from(&arguments) {
        Ok(cli) => cli,
        Err(mut said) => {
            name_setting(&mut said, &arguments);
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

/// Suggests `--set diagnostic.budget=VALUE` for the unknown option `--budget` of a command that has settings.
fn name_setting(error: &mut clap::Error, arguments: &[OsString]) {
    let text = |k: usize| {
        arguments
            .get(k)
            .and_then(|text| text.to_str())
            .unwrap_or_default()
    };
    let (command, system) = (text(1), text(2));
    let cli = Cli::command();
    let of_command = cli.find_subcommand(command);
    let has_settings =
        of_command.is_some_and(|of| of.get_arguments().any(|of| of.get_id() == "set"));
    if has_settings
        && let Some(ContextValue::String(option)) = error.get(ContextKind::InvalidArg)
        && error.kind() == ErrorKind::UnknownArgument
        && let key = option.trim_start_matches('-').replace('-', "_")
        && let Some(setting) = setting(command, system, &key)
    {
        let tip = format!("this is a setting: --set {setting}=VALUE");
        error.remove(ContextKind::SuggestedArg);
        error.insert(
            ContextKind::Suggested,
            ContextValue::StyledStrs(vec![tip.into()]),
        );
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

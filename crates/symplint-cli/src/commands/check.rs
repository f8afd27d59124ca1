//! `symplint check CONFIG.toml`.

use std::path::Path;

use symplint::{Diagnosis, VerdictKind};
use symplint_config::{Config, System};
use symplint_report::figures::figures;
use symplint_report::page::Repeat;
use symplint_report::report::Report;
use symplint_report::run_folder::PointLog;
use symplint_run::{Round, RunError, RunOutput};

use super::plan::say_round;
use super::run_output;
use crate::cli::{CheckArgs, OutputArgs, Run};
use crate::failure::Failure;
use crate::output::{Progress, diagnosis_text, go_on, say, tell};
use crate::status::{SUCCESS, Status};
use crate::{provenance, signals};

/// Diagnoses a configuration.
///
/// `--steps` stands for the key diagnostic.steps.
pub fn check(arguments: &CheckArgs) -> Result<Status, Failure> {
    let started = provenance::start();
    let run = &arguments.run;
    let mut settings = arguments.settings.set.clone();
    settings.extend(
        arguments
            .steps
            .map(|steps| format!("diagnostic.steps={steps}")),
    );
    if let Some(keep) = &arguments.keep {
        settings.push(format!("system.keep={}", quoted(keep)?));
    }
    let source = (&*arguments.config, &*settings);
    let status = diagnose(&started, source, run, Calls::Here)?;
    Ok(status.unwrap_or(SUCCESS))
}

/// Who calls a program.
pub(super) enum Calls {
    /// This process.
    Here,
    /// The jobs of a scheduler.
    ByJobs,
}

/// Diagnoses a configuration, a file and settings, or continues where a run of it was stopped. No exit status if calls are to be
/// made by jobs before it can continue.
pub(super) fn diagnose(
    started: &provenance::Run,
    (path, settings): (&Path, &[String]),
    run: &Run,
    calls: Calls,
) -> Result<Option<Status>, Failure> {
    let (mut output, mut round, mut command) = (None, None, None);
    let by_jobs = matches!(calls, Calls::ByJobs);
    // Before the run, which may take hours, and before its first call.
    let loaded = Config::load_with(path, settings, |system, resolved| {
        command = system.command.clone();
        output = run_output("check", resolved, run)?;
        round = prepare(&mut output, system, resolved, calls)?;
        Ok::<(), Failure>(())
    });
    // If the system could not make a call, this is not a failure of the map for which radii are determined.
    let failure = || {
        command
            .as_ref()
            .and_then(|command| command.failure().cloned())
    };
    if let (Err(_), Some(failure)) = (&loaded, failure()) {
        return Err(RunError::from(failure).into());
    }
    let config = loaded?;
    let journal = output.as_ref().and_then(|output| output.journal.clone());
    let log = (output.as_ref()).map(|output| PointLog::new(&output.folder, &output.config));
    let progress = Progress::new("evaluations", run.shown.quiet || run.shown.json);
    let outcome = config
        .diagnostic
        .run_watched(&*config.map, &*config.phase_loop, &|event| {
            if let Some(log) = &log {
                log.diagnosis(event);
            }
            progress.diagnosis(event);
        });
    progress.finish();
    if let Some(failure) = failure() {
        return Err(RunError::from(failure).into());
    }
    if let Some(journal) = &journal {
        journal.finish().map_err(RunError::from)?;
    }
    if let (Some(round), Some(output)) = (&round, &output) {
        let missing = (config.system.command.as_ref()).map_or(Vec::new(), |map| map.missing());
        if !missing.is_empty() {
            round.write(&missing)?;
            say_round(&missing, output.folder.path(), &run.shown)?;
            return Ok(None);
        }
        if outcome.is_err() {
            round.remove()?;
        }
    }
    let kept = log.as_ref().and_then(PointLog::measured);
    if let (Err(_), Some(kept)) = (&outcome, kept) {
        tell(format!(
            "note: the points measured before are in {}",
            kept.display()
        ));
    }
    let diagnosis = outcome?;
    // All files from here on can be written again from the calls in the journal.
    let written = |result: Result<(), Failure>| match (result, &journal, &output) {
        (Err(failure), Some(_), Some(output)) => Err(Failure::AfterCalls {
            failure: Box::new(failure),
            goes_on: go_on(
                if by_jobs { "collect" } else { "resume" },
                output.folder.path(),
            ),
        }),
        (result, ..) => result,
    };
    if let Some(log) = log {
        written(log.finish().map_err(Failure::from))?;
    }

    let mut provenance = provenance::of(started, &config.resolved);
    provenance.replayed = (journal.as_ref()).map_or(0, |journal| journal.replayed());
    let report = Report::new(&config.resolved, &diagnosis, provenance);
    if let Some(output) = &output {
        written(write_report(&config, &diagnosis, &report, output))?;
    }
    if let Some(round) = &round {
        round.end()?;
    }
    match run.shown.json {
        true => say(report.to_json())?,
        false => show(&config, &diagnosis, &run.shown, output.as_ref())?,
    }
    Ok(Some(exit_status(diagnosis.verdict.kind)))
}

/// Writes the report, its page and the figures to the folder of the run.
fn write_report(
    config: &Config,
    diagnosis: &Diagnosis,
    report: &Report<'_, toml::Table>,
    output: &RunOutput,
) -> Result<(), Failure> {
    output.folder.write_json("report.json", report)?;
    let figures = figures(&config.title(), diagnosis);
    let again = go_on("check", &output.folder.path().join("config.toml"));
    let repeat = Repeat::Command(&again);
    output.write_page(&config.heading(), diagnosis, report, &figures, repeat)?;
    output.write_figures(figures, &[])?;
    if diagnosis.picture.is_none() {
        // On standard error: standard output may be JSON.
        tell("note: figures/loop is left out: no samples of the loop stayed in memory");
    }
    Ok(())
}

/// Prints the verdict, and names the folder of the run or the option for one.
fn show(
    config: &Config,
    diagnosis: &Diagnosis,
    shown: &OutputArgs,
    output: Option<&RunOutput>,
) -> Result<(), Failure> {
    let title = config.heading();
    say(diagnosis_text(&title, diagnosis, (shown.quiet, shown.all)))?;
    match output {
        _ if shown.quiet => Ok(()),
        Some(output) => say(format!("  Written to {}.", output.folder.path().display())),
        None => say("  Figures and the whole report: -o DIR"),
    }
}

/// Opens the journal of a program; a round of calls where jobs make them.
fn prepare(
    output: &mut Option<RunOutput>,
    system: &System,
    resolved: &toml::Table,
    calls: Calls,
) -> Result<Option<Round>, Failure> {
    let refused = |message: &str, remedy: &str| {
        let (message, remedy) = (message.into(), remedy.into());
        Err(Failure::Usage { message, remedy })
    };
    match (calls, output, &system.command) {
        (Calls::Here, Some(output), Some(command)) => {
            output.keep_journal(command)?;
            signals::note_folder(output.folder.path());
            Ok(None)
        }
        (Calls::Here, None, Some(command)) => {
            (command.check_keeps_no_earlier_calls()).map_err(RunError::from)?;
            signals::note_nothing();
            Ok(None)
        }
        (Calls::Here, Some(output), None) => {
            signals::note_points(output.folder.path());
            Ok(None)
        }
        (Calls::Here, None, None) => {
            signals::note_nothing();
            Ok(None)
        }
        (Calls::ByJobs, Some(output), Some(command)) => {
            if resolved["loop"]["radius"].as_str() == Some("auto") {
                return refused(
                    "loop.radius = \"auto\" makes calls before they can be planned",
                    "give radii as numbers",
                );
            }
            Ok(Some(output.plan_calls(command)?))
        }
        (Calls::ByJobs, ..) => refused(
            "only calls of programs are made by jobs",
            "set system.name = \"command\"",
        ),
    }
}

/// A path of the command line as a value of a configuration, whose relative paths begin elsewhere.
fn quoted(path: &Path) -> Result<toml::Value, Failure> {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    match absolute.to_str() {
        Some(text) => Ok(text.into()),
        None => Err(Failure::Usage {
            message: format!("--keep: {} is not Unicode", path.display()),
            remedy: "name another folder".into(),
        }),
    }
}

/// The exit status of a verdict.
pub fn exit_status(kind: VerdictKind) -> Status {
    match kind {
        VerdictKind::Symplectic => SUCCESS,
        VerdictKind::NotSymplectic | VerdictKind::BrokenLoops => 1,
        VerdictKind::Undecided => 3,
    }
}

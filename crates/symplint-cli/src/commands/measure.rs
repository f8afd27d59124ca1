//! `symplint measure BEFORE AFTER…`.

use std::path::{Path, PathBuf};

use symplint::{Coordinates, Snapshot, measure as compare};
use symplint_files::loop_file::{LoopFile, is_partner};
use symplint_report::figures::figures;
use symplint_report::page::Repeat;
use symplint_report::provenance::Provenance;
use symplint_report::report::Report;
use symplint_report::table::degrees_of_freedom;

use super::check::exit_status;
use super::per_dof::{per_dof, spread};
use super::run_output;
use crate::cli::MeasureArgs;
use crate::failure::Failure;
use crate::output::{diagnosis_text, say};
use crate::provenance;
use crate::status::Status;

/// Compares a loop before and after a step of another code.
pub fn measure(arguments: &MeasureArgs) -> Result<Status, Failure> {
    let started = provenance::start();
    let run = &arguments.run;
    let names = loops_of(&arguments.before, &arguments.after);
    if names.len() < 2 {
        return Err(usage(
            "there is a loop before the step, but none after it",
            "name the files before and after the step: symplint measure before_q.npy after_q.npy",
        ));
    }
    let mut files = (names.iter())
        .map(|name| LoopFile::read(name))
        .collect::<Result<Vec<LoopFile>, _>>()?;
    for file in &files[1..] {
        file.check_same_loop(&files[0])?;
    }
    let hashes = (files.iter().map(LoopFile::hashes)).collect::<Result<Vec<_>, _>>()?;
    set_step_sizes(&mut files[1..], &arguments.step_sizes)?;
    check_step_sizes(&files[1..])?;
    let (coordinates, settings) = coordinates(arguments, &files)?;
    let resolved = resolved(&files, settings);
    let output = run_output("measure", &resolved, run)?;

    let mut snapshots: Vec<Snapshot> = files
        .into_iter()
        .map(|file| Snapshot {
            states: file.states,
            unit_roundoff: file.unit_roundoff,
            step_size: file.step_size,
        })
        .collect();
    let after = snapshots.split_off(1);
    let before = &snapshots[0];
    let diagnosis = compare(before, &after, &coordinates)?;

    let title = names[0]
        .file_stem()
        .map_or("".into(), |stem| stem.to_string_lossy());
    let report = Report::new(
        &resolved,
        &diagnosis,
        Provenance {
            files: hashes.concat(),
            ..provenance::of(&started, &resolved)
        },
    );
    if let Some(output) = &output {
        let folder = &output.folder;
        folder.write_config(&output.config)?;
        folder.write_json("report.json", &report)?;
        folder.write_csv("points.csv", &diagnosis.points())?;
        let figures = figures(&title, &diagnosis);
        output.write_page(&title, &diagnosis, &report, &figures, Repeat::Files)?;
        output.write_figures(figures, &[])?;
    }
    if run.shown.json {
        say(report.to_json())?;
    } else {
        let heading = format!("{title} · {}", degrees_of_freedom(before.states.dof()));
        let shown = (run.shown.quiet, run.shown.all);
        say(diagnosis_text(&heading, &diagnosis, shown))?;
        if let Some(output) = output.as_ref().filter(|_| !run.shown.quiet) {
            say(format!("\nWritten to {}", output.folder.path().display()))?;
        }
    }
    Ok(exit_status(diagnosis.verdict.kind))
}

/// Settings of the coordinates, by their keys.
type CoordinateSettings = [(&'static str, Option<Vec<f64>>); 3];

/// Periods and weights from the command line, or else from the files.
fn coordinates(
    arguments: &MeasureArgs,
    files: &[LoopFile],
) -> Result<(Coordinates, CoordinateSettings), Failure> {
    let dof = files[0].states.dof();
    let (period, weight) = (&arguments.period, &arguments.weight);
    let period = setting("period", period, files, dof, |file| file.period.as_ref())?;
    let momentum_period = setting(
        "momentum-period",
        &arguments.momentum_period,
        files,
        dof,
        |file| file.momentum_period.as_ref(),
    )?;
    let weight = setting("weight", weight, files, dof, |file| file.weight.as_ref())?;
    let mut coordinates = Coordinates::plain(dof);
    if let Some(period) = &period {
        coordinates = coordinates
            .with_periods(period.clone())
            .map_err(Failure::Option)?;
    }
    if let Some(period) = &momentum_period {
        coordinates = coordinates
            .with_momentum_periods(period.clone())
            .map_err(Failure::Option)?;
    }
    if let Some(weight) = &weight {
        coordinates = coordinates
            .with_weights(weight.clone())
            .map_err(Failure::Option)?;
    }
    Ok((
        coordinates,
        [
            ("period", period),
            ("momentum_period", momentum_period),
            ("weight", weight),
        ],
    ))
}

fn usage(message: impl Into<String>, remedy: impl Into<String>) -> Failure {
    Failure::Usage {
        message: message.into(),
        remedy: remedy.into(),
    }
}

/// One name for each loop: a shell expands `before_{q,p}.npy` to two names.
fn loops_of(before: &Path, after: &[PathBuf]) -> Vec<PathBuf> {
    let mut names: Vec<PathBuf> = Vec::new();
    for name in std::iter::once(before).chain(after.iter().map(PathBuf::as_path)) {
        if names.last().is_none_or(|last| !is_partner(last, name)) {
            names.push(name.to_owned());
        }
    }
    names
}

/// Returns an error that names the file of an invalid step size, or both files of the same one.
fn check_step_sizes(after: &[LoopFile]) -> Result<(), Failure> {
    for (k, file) in after.iter().enumerate() {
        let same = |of: &&LoopFile| of.step_size.is_some() && of.step_size == file.step_size;
        if let Some(other) = after[..k].iter().find(same) {
            return Err(usage(
                format!(
                    "{} and {} have the same step size",
                    other.path.display(),
                    file.path.display()
                ),
                "give one file for each step size, or correct the step sizes by --h",
            ));
        }
    }
    for file in after {
        if let Some(h) = file.step_size.filter(|h| *h == 0.0 || !h.is_finite()) {
            return Err(usage(
                format!("{}: the step size is {h}", file.path.display()),
                "store as `h` the step size that made the states, or give it by --h",
            ));
        }
    }
    Ok(())
}

/// Sets the step sizes from the command line: one for each file after the step, or one for each of those
/// that do not hold a step size.
fn set_step_sizes(after: &mut [LoopFile], sizes: &[f64]) -> Result<(), Failure> {
    if sizes.is_empty() {
        return Ok(());
    }
    let missing = after.iter().filter(|file| file.step_size.is_none()).count();
    let of_all = after.len();
    if sizes.len() != of_all && sizes.len() != missing {
        let wanted = if missing == 0 || missing == of_all {
            format!("{of_all}, one for each file after the step, in their order")
        } else {
            format!(
                "{missing}, one for each file without `h`, or {of_all}, one for each file after the step"
            )
        };
        return Err(usage(
            format!(
                "--h has {} for {of_all} {} after the step",
                match sizes.len() {
                    1 => "1 step size".to_owned(),
                    more => format!("{more} step sizes"),
                },
                if of_all == 1 { "file" } else { "files" },
            ),
            format!("give {wanted}"),
        ));
    }
    let takes = |file: &&mut LoopFile| sizes.len() == of_all || file.step_size.is_none();
    for (file, &h) in after.iter_mut().filter(takes).zip(sizes) {
        file.step_size = Some(h);
    }
    Ok(())
}

/// The periods or weight of every degree of freedom: from the command line, else from the files, which
/// must agree.
fn setting<'a>(
    what: &str,
    given: &[f64],
    files: &'a [LoopFile],
    dof: usize,
    of: impl Fn(&'a LoopFile) -> Option<&'a Vec<f64>>,
) -> Result<Option<Vec<f64>>, Failure> {
    if let Some(values) = per_dof(&format!("--{what}"), given, dof)? {
        return Ok(Some(values));
    }
    let mut found = files
        .iter()
        .filter_map(|file| of(file).map(|values| (file, spread(values, dof))));
    let Some((first, values)) = found.next() else {
        return Ok(None);
    };
    match found.find(|(_, others)| *others != values) {
        None => Ok(Some(values)),
        Some((other, _)) => Err(usage(
            format!(
                "{} and {} have different values of {what}",
                first.path.display(),
                other.path.display()
            ),
            format!("make them equal, or give the right value by --{what}"),
        )),
    }
}

/// The files and their coordinates, as the configuration of the report.
fn resolved(files: &[LoopFile], settings: CoordinateSettings) -> toml::Table {
    let name = |file: &LoopFile| toml::Value::from(file.path.display().to_string());
    let mut section = toml::Table::new();
    section.insert("before".into(), name(&files[0]));
    let after: Vec<toml::Value> = files[1..].iter().map(name).collect();
    section.insert("after".into(), after.into());
    // TOML has no null, so step sizes are listed only if all are known.
    let sizes: Option<Vec<f64>> = files[1..].iter().map(|file| file.step_size).collect();
    for (key, values) in [("h", sizes)].into_iter().chain(settings) {
        if let Some(values) = values {
            section.insert(key.into(), values.into());
        }
    }
    let mut table = toml::Table::new();
    table.insert("measure".into(), section.into());
    table
}

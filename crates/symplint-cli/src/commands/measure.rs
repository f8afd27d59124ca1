//! `symplint measure BEFORE AFTER…`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use symplint::{Coordinates, Snapshot, measure as compare};
use symplint_report::figures::measure_figures;
use symplint_report::loop_file::{LoopFile, is_partner};
use symplint_report::provenance::Provenance;
use symplint_report::report::Report;
use symplint_report::run_folder::RunFolder;
use symplint_report::table::{degrees_of_freedom, points_table};

use super::Failure;
use super::check::exit_status;
use crate::cli::Common;
use crate::config::parse_number;
use crate::output;
use crate::provenance;

/// What the command line says of the files.
pub struct Stated<'a> {
    /// Step sizes.
    pub step_sizes: &'a [String],
    /// Periods of the positions.
    pub period: &'a [String],
    /// Weights of the momenta.
    pub weight: &'a [String],
}

/// Measures what a step of another code did to a loop.
pub fn measure(
    before: &Path,
    after: &[PathBuf],
    stated: &Stated<'_>,
    common: &Common,
) -> Result<ExitCode, Failure> {
    let run = provenance::start();
    if !common.set.is_empty() {
        return Err(usage(
            "--set changes a configuration, and measure has none",
            "use --h, --period and --weight",
        ));
    }
    let names = loops_of(before, after);
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
    let hashes = (files.iter().flat_map(LoopFile::parts))
        .map(|part| LoopFile::hash(&part))
        .collect::<Result<Vec<_>, _>>()?;
    let folder = common.out.as_deref().map(RunFolder::create).transpose()?;

    state_step_sizes(&mut files[1..], &numbers("--h", stated.step_sizes)?)?;
    let dof = files[0].states.dof();
    let period = numbers("--period", stated.period)?;
    let weight = numbers("--weight", stated.weight)?;
    let period = setting("period", &period, &files, dof, |file| file.period.as_ref())?;
    let weight = setting("weight", &weight, &files, dof, |file| file.weight.as_ref())?;
    let mut coordinates = Coordinates::plain(dof);
    if let Some(period) = &period {
        coordinates = coordinates.with_periods(period.clone())?;
    }
    if let Some(weight) = &weight {
        coordinates = coordinates.with_weights(weight.clone())?;
    }
    let resolved = resolved(&files, period, weight);

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
            files: hashes,
            ..provenance::provenance(&run, &resolved)
        },
    );
    if let Some(folder) = &folder {
        folder.write_config(&resolved.to_string())?;
        folder.write_json("report.json", &report)?;
        folder.write_csv("points.csv", &diagnosis.points)?;
        let size = |snapshot: &Snapshot| snapshot.step_size.unwrap_or(0.0).abs();
        let largest = (after.iter()).reduce(|a, b| if size(b) > size(a) { b } else { a });
        if let Some(largest) = largest {
            let (states, h) = (&largest.states, largest.step_size);
            for (name, figure) in measure_figures(&title, &diagnosis, &before.states, states, h) {
                figure.save(&folder.figures(), name)?;
            }
        }
    }
    if common.json {
        output::say(report.to_json())?;
    } else {
        if !common.quiet {
            let heading = format!("{title} · {}", degrees_of_freedom(dof));
            output::say(points_table(&heading, &diagnosis))?;
        }
        output::say(output::verdict_text(&diagnosis.verdict, common.quiet))?;
        if let Some(folder) = folder.as_ref().filter(|_| !common.quiet) {
            output::say(format!("\nWritten to {}", folder.path().display()))?;
        }
    }
    Ok(exit_status(diagnosis.verdict.kind))
}

fn usage(message: impl Into<String>, remedy: impl Into<String>) -> Failure {
    Failure::Usage {
        message: message.into(),
        remedy: remedy.into(),
    }
}

/// One name for each loop: a shell makes two of `before_{q,p}.npy`.
fn loops_of(before: &Path, after: &[PathBuf]) -> Vec<PathBuf> {
    let mut names: Vec<PathBuf> = Vec::new();
    for name in std::iter::once(before).chain(after.iter().map(PathBuf::as_path)) {
        if names.last().is_none_or(|last| !is_partner(last, name)) {
            names.push(name.to_owned());
        }
    }
    names
}

fn numbers(option: &str, texts: &[String]) -> Result<Vec<f64>, Failure> {
    let read = |text: &String| {
        parse_number(text).ok_or_else(|| {
            usage(
                format!("{option} says \"{text}\", which is no number"),
                "write numbers such as 0.1, 2^-3 or 2*pi, separated by commas",
            )
        })
    };
    texts.iter().map(read).collect()
}

/// Gives the files after the step the sizes from the command line, one for each that states none
/// itself, or one for each.
fn state_step_sizes(after: &mut [LoopFile], sizes: &[f64]) -> Result<(), Failure> {
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
                "{missing}, one for each file after the step that has none, or {of_all} for all"
            )
        };
        return Err(usage(
            format!(
                "--h gives {} step sizes for {of_all} files after the step",
                sizes.len()
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

/// The period or weight of every degree of freedom: from the command line, else from the files, which
/// must agree.
fn setting<'a>(
    what: &str,
    stated: &[f64],
    files: &'a [LoopFile],
    dof: usize,
    of: impl Fn(&'a LoopFile) -> Option<&'a Vec<f64>>,
) -> Result<Option<Vec<f64>>, Failure> {
    let spread = |values: &[f64]| match values {
        [one] => vec![*one; dof],
        _ => values.to_vec(),
    };
    if !stated.is_empty() {
        if stated.len() != 1 && stated.len() != dof {
            return Err(usage(
                format!(
                    "--{what} gives {} numbers for {dof} degrees of freedom",
                    stated.len()
                ),
                "give one for all, or one for each",
            ));
        }
        return Ok(Some(spread(stated)));
    }
    let mut said = files
        .iter()
        .filter_map(|file| of(file).map(|v| (file, spread(v))));
    let Some((first, values)) = said.next() else {
        return Ok(None);
    };
    match said.find(|(_, others)| *others != values) {
        None => Ok(Some(values)),
        Some((other, _)) => Err(usage(
            format!(
                "{} and {} state different values of {what}",
                first.path.display(),
                other.path.display()
            ),
            format!("make them agree, or say which holds by --{what}"),
        )),
    }
}

/// What was compared, as the report's configuration.
fn resolved(files: &[LoopFile], period: Option<Vec<f64>>, weight: Option<Vec<f64>>) -> toml::Table {
    let name = |file: &LoopFile| toml::Value::from(file.path.display().to_string());
    let mut section = toml::Table::new();
    section.insert("before".into(), name(&files[0]));
    let after: Vec<toml::Value> = files[1..].iter().map(name).collect();
    section.insert("after".into(), after.into());
    // TOML has no null: sizes are listed if all are known.
    let sizes: Option<Vec<f64>> = files[1..].iter().map(|file| file.step_size).collect();
    for (key, values) in [("h", sizes), ("period", period), ("weight", weight)] {
        if let Some(values) = values {
            section.insert(key.into(), values.into());
        }
    }
    let mut table = toml::Table::new();
    table.insert("measure".into(), section.into());
    table
}

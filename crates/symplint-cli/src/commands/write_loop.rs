//! `symplint loop`.

use std::fs;
use std::path::PathBuf;

use serde::Serialize;
use symplint::diagnosis::SampleCount;
use symplint::{Coordinates, Ensemble, Loop, Snapshot};
use symplint_config::Config;
use symplint_files::LoopFile;
use symplint_report::report::to_json;
use symplint_report::table::degrees_of_freedom;

use super::loop_shape;
use crate::cli::LoopArgs;
use crate::failure::Failure;
use crate::output::say;
use crate::status::{SUCCESS, Status};

/// The default number of samples. Smooth loops need no more.
const SAMPLES: usize = 256;

/// The files that were written, for `--json`.
#[derive(Serialize)]
struct WrittenFiles {
    files: Vec<PathBuf>,
    samples: usize,
    dof: usize,
    period: Option<Vec<f64>>,
    momentum_period: Option<Vec<f64>>,
    weight: Option<Vec<f64>>,
}

/// Writes the samples of a loop.
pub fn write_loop(arguments: &LoopArgs) -> Result<Status, Failure> {
    let (phase_loop, coordinates, samples) = sampled_loop(arguments)?;
    let dof = coordinates.dof();
    // Default values are left out.
    let of_each = |value: &dyn Fn(usize) -> f64, default: f64| {
        let values: Vec<f64> = (0..dof).map(value).collect();
        values.iter().any(|&v| v != default).then_some(values)
    };
    let folder = arguments.out.clone().unwrap_or_default();
    let file = LoopFile {
        path: folder.join(&arguments.output),
        states: Ensemble::sample(&*phase_loop, samples).map_err(Failure::Option)?,
        unit_roundoff: Snapshot::DOUBLE,
        step_size: None,
        period: of_each(&|i| coordinates.period(i), 0.0),
        momentum_period: of_each(&|i| coordinates.momentum_period(i), 0.0),
        weight: of_each(&|i| coordinates.weight(i), 1.0),
    };
    check_replaceable(&file, arguments.force)?;
    fs::create_dir_all(&folder).map_err(|error| Failure::Write {
        path: folder.clone(),
        reason: error.to_string(),
    })?;
    let files = file.write()?;
    if arguments.json {
        say(to_json(&WrittenFiles {
            files,
            samples,
            dof,
            period: file.period,
            momentum_period: file.momentum_period,
            weight: file.weight,
        }))?;
        return Ok(SUCCESS);
    }
    let names: Vec<String> = files
        .iter()
        .map(|file| file.display().to_string())
        .collect();
    say(format!(
        "{}: {samples} samples of {}",
        names.join(", "),
        degrees_of_freedom(dof)
    ))?;
    if !arguments.quiet {
        say(
            "Advance every row of q and p by one step, store them in the same way, and run\n  symplint \
             measure BEFORE AFTER",
        )?;
        if !file.carries_settings() {
            for (option, values) in [
                ("period", &file.period),
                ("momentum-period", &file.momentum_period),
                ("weight", &file.weight),
            ] {
                if let Some(values) = values {
                    say(format!("  with --{option} {}", listed(values)))?;
                }
            }
        }
    }
    Ok(SUCCESS)
}

/// The loop, the meaning of its coordinates, and the number of samples.
fn sampled_loop(arguments: &LoopArgs) -> Result<(Box<dyn Loop>, Coordinates, usize), Failure> {
    let Some(path) = &arguments.config else {
        if !arguments.settings.set.is_empty() {
            return Err(Failure::Usage {
                message: "--set changes a configuration, and no configuration is given".into(),
                remedy: "name a configuration, or describe the loop by --dof, --q0, --p0, --radius"
                    .into(),
            });
        }
        let (phase_loop, coordinates) = loop_shape::build(&arguments.shape)?;
        return Ok((
            phase_loop,
            coordinates,
            arguments.samples.unwrap_or(SAMPLES),
        ));
    };
    loop_shape::refuse_with_configuration(&arguments.shape)?;
    let config = Config::load(path, &arguments.settings.set)?;
    let samples = arguments
        .samples
        .unwrap_or(match config.diagnostic.samples {
            SampleCount::Fixed(count) => count,
            SampleCount::Auto => SAMPLES,
        });
    let coordinates = config.map.capabilities().coordinates;
    Ok((config.phase_loop, coordinates, samples))
}

/// Checks that writing the loop replaces nothing but the same loop or, with `force`, another loop before a
/// step. Other codes store step sizes in their files; `symplint loop` does not.
fn check_replaceable(file: &LoopFile, force: bool) -> Result<(), Failure> {
    let Some(there) = file.paths()?.into_iter().find(|path| path.exists()) else {
        return Ok(());
    };
    let there = there.display();
    match LoopFile::read(&file.path) {
        Ok(found) if same_loop(&found, file) => Ok(()),
        Ok(found) if found.step_size.is_none() => {
            if force {
                return Ok(());
            }
            Err(Failure::Usage {
                message: format!(
                    "{there} holds another loop, with {} samples of {}",
                    found.states.samples(),
                    degrees_of_freedom(found.states.dof())
                ),
                remedy: "give --output another file, or add --force to replace that loop".into(),
            })
        }
        _ => Err(Failure::Usage {
            message: format!("{there} exists, and is not a loop that symplint wrote"),
            remedy: "give --output another file; --force does not replace this one".into(),
        }),
    }
}

fn same_loop(found: &LoopFile, file: &LoopFile) -> bool {
    let (one, other) = (&found.states, &file.states);
    one.dof() == other.dof()
        && one.samples() == other.samples()
        && (0..one.dof()).all(|i| one.q().row(i) == other.q().row(i))
        && (0..one.dof()).all(|i| one.p().row(i) == other.p().row(i))
        && (!file.carries_settings()
            || (found.period == file.period
                && found.momentum_period == file.momentum_period
                && found.weight == file.weight))
}

/// Numbers as the options of `measure` take them: one where all are the same.
fn listed(values: &[f64]) -> String {
    match values {
        [first, rest @ ..] if rest.iter().all(|value| value == first) => format!("{first:?}"),
        _ => {
            let texts: Vec<String> = values.iter().map(|value| format!("{value:?}")).collect();
            texts.join(",")
        }
    }
}

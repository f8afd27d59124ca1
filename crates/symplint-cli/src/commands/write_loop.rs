//! `symplint loop CONFIG.toml`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde::Serialize;
use symplint::{Ensemble, SampleCount, Snapshot};
use symplint_report::loop_file::LoopFile;
use symplint_report::report::to_json;
use symplint_report::run_folder::RunFolder;
use symplint_report::table::degrees_of_freedom;

use super::Failure;
use crate::cli::Common;
use crate::config::Config;
use crate::output;

/// Samples unless someone asks for another number: smooth loops need no more.
const SAMPLES: usize = 256;

/// What was written, for `--json`.
#[derive(Serialize)]
struct Written {
    files: Vec<PathBuf>,
    samples: usize,
    dof: usize,
    period: Option<Vec<f64>>,
    weight: Option<Vec<f64>>,
}

/// Writes the samples of a configured loop.
pub fn write_loop(
    path: &Path,
    samples: Option<usize>,
    output: Option<&Path>,
    common: &Common,
) -> Result<ExitCode, Failure> {
    let config = Config::load(path, &common.set)?;
    let samples = samples.unwrap_or(match config.diagnostic.samples {
        SampleCount::Fixed(count) => count,
        SampleCount::Auto => SAMPLES,
    });
    let name = output.unwrap_or(Path::new("loop.npz"));
    let target = match &common.out {
        Some(folder) => RunFolder::without_figures(folder)?.path().join(name),
        None => name.to_owned(),
    };
    let coordinates = config.map.coordinates();
    let dof = coordinates.dof();
    // What says nothing is left out.
    let of_each = |value: &dyn Fn(usize) -> f64, nothing: f64| {
        let values: Vec<f64> = (0..dof).map(value).collect();
        values.iter().any(|&v| v != nothing).then_some(values)
    };
    let file = LoopFile {
        path: target,
        states: Ensemble::sample(&*config.phase_loop, samples)?,
        unit_roundoff: Snapshot::DOUBLE,
        step_size: None,
        period: of_each(&|i| coordinates.period(i), 0.0),
        weight: of_each(&|i| coordinates.weight(i), 1.0),
    };
    let files = file.write()?;
    if common.json {
        output::say(to_json(&Written {
            files,
            samples,
            dof,
            period: file.period,
            weight: file.weight,
        }))?;
        return Ok(ExitCode::SUCCESS);
    }
    let names: Vec<String> = files
        .iter()
        .map(|file| file.display().to_string())
        .collect();
    output::say(format!(
        "{}: {samples} samples of {}",
        names.join(", "),
        degrees_of_freedom(dof)
    ))?;
    if !common.quiet {
        output::say(
            "Advance every row of q and p by one step, store them in the same way, and run\n  symplint \
             measure BEFORE AFTER",
        )?;
        if !file.carries_settings() {
            for (option, values) in [("period", &file.period), ("weight", &file.weight)] {
                if let Some(values) = values {
                    output::say(format!("  with --{option} {}", listed(values)))?;
                }
            }
        }
    }
    Ok(ExitCode::SUCCESS)
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

//! `symplint check CONFIG.toml`.

use std::path::Path;
use std::process::ExitCode;

use symplint::VerdictKind;
use symplint_report::figures::check_figures;
use symplint_report::report::Report;
use symplint_report::run_folder::{PointLog, RunFolder};
use symplint_report::table::{degrees_of_freedom, points_table};

use super::Failure;
use crate::cli::Common;
use crate::config::Config;
use crate::output::{self, Progress};
use crate::provenance;

/// Diagnoses a configuration.
///
/// `steps` is short for the key diagnostic.steps.
pub fn check(path: &Path, steps: Option<usize>, common: &Common) -> Result<ExitCode, Failure> {
    let run = provenance::start();
    let mut set = common.set.clone();
    set.extend(steps.map(|steps| format!("diagnostic.steps={steps}")));
    let config = Config::load(path, &set)?;
    // Before hours of work, not after.
    let folder = common.out.as_deref().map(RunFolder::create).transpose()?;
    let resolved = config.resolved.to_string();
    let log = (folder.as_ref()).map(|folder| PointLog::new(folder, &resolved));
    let progress = Progress::new("points", common.quiet || common.json);
    let outcome = config
        .diagnostic
        .run(&*config.map, &*config.phase_loop, &|event| {
            if let Some(log) = &log {
                log.diagnosis(event);
            }
            progress.diagnosis(event);
        });
    progress.finish();
    let kept = log.as_ref().and_then(PointLog::measured);
    if let (Err(_), Some(kept)) = (&outcome, kept) {
        anstream::eprintln!("note: the points until then are in {}", kept.display());
    }
    let diagnosis = outcome?;
    if let Some(log) = log {
        log.finish()?;
    }

    let report = Report::new(
        &config.resolved,
        &diagnosis,
        provenance::provenance(&run, &config.resolved),
    );
    if let Some(folder) = &folder {
        folder.write_json("report.json", &report)?;
        let title = format!("{}, {}", config.system.name, config.integrator);
        let largest = (config.diagnostic.step_sizes.iter().copied()).fold(0.0, f64::max);
        let (figures, note) = check_figures(
            &title,
            &diagnosis,
            &*config.map,
            &*config.phase_loop,
            largest,
        );
        for (name, figure) in figures {
            figure.save(&folder.figures(), name)?;
        }
        // On standard error: standard output may be JSON.
        if let Some(note) = note {
            anstream::eprintln!("note: {note}");
        }
    }
    if common.json {
        output::say(report.to_json())?;
    } else {
        if !common.quiet {
            let heading = format!(
                "{} · {} · {}",
                config.system.name,
                config.integrator,
                degrees_of_freedom(config.map.dof())
            );
            output::say(points_table(&heading, &diagnosis))?;
        }
        output::say(output::verdict_text(&diagnosis.verdict, common.quiet))?;
        match &folder {
            Some(folder) if !common.quiet => {
                output::say(format!("\nWritten to {}", folder.path().display()))?;
            }
            None if !common.quiet => {
                output::say("\nAdd --out DIR for figures, all points and the report.")?;
            }
            _ => {}
        }
    }
    Ok(exit_status(diagnosis.verdict.kind))
}

/// The exit status that stands for a verdict.
pub fn exit_status(kind: VerdictKind) -> ExitCode {
    match kind {
        VerdictKind::Symplectic => ExitCode::SUCCESS,
        VerdictKind::NotSymplectic | VerdictKind::BrokenLoops => ExitCode::from(1),
        VerdictKind::Undecided => ExitCode::from(3),
    }
}

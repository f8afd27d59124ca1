//! `symplint trace CONFIG.toml`.

use std::path::Path;
use std::process::ExitCode;

use symplint::{
    Observable, Orbit, Piecewise, Rows, Rule, RuleChoice, Streaming, Trace, TraceRecord,
};
use symplint_report::figures::trace_figures;
use symplint_report::report::TraceReport;
use symplint_report::run_folder::RunFolder;
use symplint_report::table::trace_table;

use super::Failure;
use crate::cli::Common;
use crate::config::{Config, ConfigError};
use crate::output::{self, Progress};
use crate::provenance;

/// Follows loop integral and energy in time.
pub fn trace(path: &Path, common: &Common) -> Result<ExitCode, Failure> {
    let run = provenance::start();
    let config = Config::load(path, &common.set)?;
    let folder = common.out.as_deref().map(RunFolder::create).transpose()?;
    let progress = Progress::new("steps", common.quiet || common.json);
    let record = follow(&config, &progress)?;
    progress.finish();

    let report = TraceReport::new(
        &config.resolved,
        &record.points,
        provenance::provenance(&run, &config.resolved),
    );
    if let Some(folder) = &folder {
        folder.write_config(&config.resolved.to_string())?;
        folder.write_json("report.json", &report)?;
        folder.write_csv("points.csv", &record.points)?;
        for (step, ensemble) in &record.snapshots {
            folder.write_samples(&format!("loop_{step}.csv"), ensemble)?;
        }
        let title = format!("{}, {}", config.system.name, config.integrator);
        let hamiltonian = config.system.model.hamiltonian();
        let energy = hamiltonian.map(|hamiltonian| {
            |q: Rows<'_>, p: Rows<'_>, out: &mut [f64]| hamiltonian.energy(q, p, out)
        });
        let energy = energy.as_ref().map(|energy| energy as Observable<'_>);
        for (name, figure) in trace_figures(&title, &record, config.trace.step_size, energy) {
            figure.save(&folder.figures(), name)?;
        }
    }
    if common.json {
        output::say(report.to_json())?;
    } else {
        output::say(trace_table(&record.points, common.quiet))?;
        if let Some(folder) = folder.as_ref().filter(|_| !common.quiet) {
            output::say(format!("\nWritten to {}", folder.path().display()))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// The rule of a trace, which keeps an ensemble of samples and never makes new ones in between.
fn rule(choice: RuleChoice) -> Result<Rule, ConfigError> {
    let name = match choice {
        RuleChoice::Auto => return Ok(Rule::Pseudospectral),
        RuleChoice::Fixed(rule) => return Ok(rule),
        RuleChoice::Piecewise => Piecewise::NAME,
        RuleChoice::Streaming => Streaming::NAME,
    };
    Err(ConfigError::new(
        format!("diagnostic.rule is \"{name}\", and a trace cannot be had by it"),
        "give \"pseudospectral\" or \"finite-difference\", for example by --set diagnostic.rule=pseudospectral",
    ))
}

fn follow(config: &Config, progress: &Progress) -> Result<TraceRecord, Failure> {
    let settings = &config.trace;
    if let Some(&late) = settings
        .snapshots
        .iter()
        .find(|&&step| step > settings.steps)
    {
        let text = format!("trace.snapshots names step {late} of {}", settings.steps);
        let help = "take more steps or drop the snapshot, for example by --set trace.snapshots=[0]";
        return Err(ConfigError::new(text, help).into());
    }
    let trace = Trace {
        rule: rule(config.diagnostic.rule)?,
        samples: settings.samples,
        step_size: settings.step_size,
        steps: settings.steps,
        snapshots: settings.snapshots.clone(),
    };
    let system = &config.system;
    let hamiltonian = system.model.hamiltonian();
    let energy = |q: Rows<'_>, p: Rows<'_>, out: &mut [f64]| {
        if let Some(hamiltonian) = hamiltonian {
            hamiltonian.energy(q, p, out);
        }
    };
    // A system without an energy has none to follow.
    let orbit = hamiltonian.map(|_| Orbit {
        q: &system.q0,
        p: &system.p0,
        energy: &energy,
    });
    progress.plan(settings.steps + 1);
    let watch = |_: &symplint::TracePoint| progress.step();
    Ok(trace.run(&*config.map, &*config.phase_loop, orbit, &watch)?)
}

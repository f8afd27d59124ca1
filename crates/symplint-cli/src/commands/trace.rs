//! `symplint trace CONFIG.toml`.

use symplint::state::Rows;
use symplint::trace::{Observable, Orbit, TraceRecord};
use symplint::{Rule, Trace};
use symplint_config::{Config, ConfigError};
use symplint_report::figures::trace_figures;
use symplint_report::report::TraceReport;
use symplint_report::table::trace_table;
use symplint_run::{RunError, loop_file};

use super::run_output;
use crate::cli::TraceArgs;
use crate::failure::Failure;
use crate::output::{Progress, say};
use crate::provenance;
use crate::status::{SUCCESS, Status};

/// Follows the loop integral and the energy in time.
pub fn trace(arguments: &TraceArgs) -> Result<Status, Failure> {
    let started = provenance::start();
    let run = &arguments.run;
    let set = &arguments.settings.set;
    let config = Config::load_with(&arguments.config, set, |system, _| {
        let command = system.command.as_ref();
        let checked = command.map_or(Ok(()), |command| command.check_keeps_no_earlier_calls());
        checked.map_err(|error| Failure::from(RunError::from(error)))
    })?;
    let trace = settings(&config)?;
    let output = run_output("trace", &config.resolved, run)?;
    let progress = Progress::steady("steps", run.shown.quiet || run.shown.json);
    let record = follow(&trace, &config, &progress)?;
    progress.finish();

    let report = TraceReport::new(
        &config.resolved,
        &record.points,
        provenance::of(&started, &config.resolved),
    );
    if let Some(output) = &output {
        let folder = &output.folder;
        folder.write_config(&output.config)?;
        folder.write_json("report.json", &report)?;
        folder.write_csv("points.csv", &record.points)?;
        for (step, ensemble) in &record.snapshots {
            folder.write_samples(&loop_file(*step), ensemble)?;
        }
        let title = config.title();
        let hamiltonian = config.system.model.hamiltonian();
        let energy = hamiltonian.map(|hamiltonian| {
            |q: Rows<'_>, p: Rows<'_>, out: &mut [f64]| hamiltonian.energy(q, p, out)
        });
        let energy = energy.as_ref().map(|energy| energy as Observable<'_>);
        let figures = trace_figures(&title, &record, config.trace.step_size, energy);
        output.write_figures(figures, &trace.snapshots)?;
    }
    if run.shown.json {
        say(report.to_json())?;
    } else {
        say(trace_table(&record.points, run.shown.quiet))?;
        if let Some(output) = output.as_ref().filter(|_| !run.shown.quiet) {
            say(format!("\nWritten to {}", output.folder.path().display()))?;
        }
    }
    Ok(SUCCESS)
}

/// The rule of a trace. It follows a fixed ensemble, so the rules that make further samples do not apply.
fn rule(rule: Rule) -> Result<Rule, ConfigError> {
    let name = match rule {
        Rule::Auto => return Ok(Rule::Pseudospectral),
        Rule::Piecewise(_) | Rule::Streaming(_) => rule.kind().name(),
        _ => return Ok(rule),
    };
    Err(ConfigError::new(
        format!("diagnostic.rule is \"{name}\", which a trace does not accept"),
        "give \"pseudospectral\" or \"finite-difference\", for example by --set diagnostic.rule=pseudospectral",
    ))
}

fn settings(config: &Config) -> Result<Trace, ConfigError> {
    let settings = &config.trace;
    if let Some(&late) = settings
        .snapshots
        .iter()
        .find(|&&step| step > settings.steps)
    {
        return Err(ConfigError::new(
            format!(
                "trace.snapshots has step {late}, but trace.steps is {}",
                settings.steps
            ),
            "take more steps or leave that snapshot out, for example by --set trace.snapshots=[0]",
        ));
    }
    Ok(Trace {
        rule: rule(config.diagnostic.rule)?,
        samples: settings.samples,
        step_size: settings.step_size,
        steps: settings.steps,
        snapshots: settings.snapshots.clone(),
    })
}

fn follow(trace: &Trace, config: &Config, progress: &Progress) -> Result<TraceRecord, Failure> {
    let system = &config.system;
    let hamiltonian = system.model.hamiltonian();
    let energy = |q: Rows<'_>, p: Rows<'_>, out: &mut [f64]| {
        if let Some(hamiltonian) = hamiltonian {
            hamiltonian.energy(q, p, out);
        }
    };
    // A system that is a map has no energy.
    let orbit = hamiltonian.map(|_| Orbit {
        q: &system.q0,
        p: &system.p0,
        energy: &energy,
    });
    progress.plan(trace.steps + 1);
    let watch = |_: &symplint::trace::TracePoint| progress.step();
    Ok(trace.run_watched(&*config.map, &*config.phase_loop, orbit, &watch)?)
}

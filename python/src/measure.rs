//! `symplint.measure` and `symplint.loop_integral`: loops that another code advanced.

use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use symplint::{LoopIntegral, Snapshot, measure as compare};

use crate::arrays;
use crate::check::{CutoffPair, rule};
use crate::coordinates::Stated;
use crate::error::{diagnostic_error, other_error};
use crate::memory::Columns;
use crate::pool;
use crate::report::{self, Report};

/// A loop as two arrays of one row for each sample, and the relative rounding error of their numbers.
type Loop<'py> = (PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, f64>, bool);

fn snapshot(py: Python<'_>, (q, p, single): &Loop<'_>, h: Option<f64>) -> PyResult<Snapshot> {
    let states = arrays::ensemble(py, q, p)?;
    let mut snapshot = Snapshot::new(states);
    if *single {
        snapshot = snapshot.with_unit_roundoff(Snapshot::SINGLE);
    }
    snapshot.step_size = h;
    Ok(snapshot)
}

/// Compares a loop before a step with the same loop after steps.
#[pyfunction]
#[pyo3(signature = (before, after, h, stated, title, config))]
pub fn measure(
    py: Python<'_>,
    before: Loop<'_>,
    after: Vec<Loop<'_>>,
    h: Vec<Option<f64>>,
    stated: Stated,
    title: String,
    config: &str,
) -> PyResult<Report> {
    let run = report::start();
    let config: serde_json::Value =
        serde_json::from_str(config).map_err(|error| other_error(py, &error.to_string()))?;
    let before = snapshot(py, &before, None)?;
    let coordinates = stated.of(py, before.states.dof())?;
    let after = (after.iter().zip(h))
        .map(|(states, h)| {
            py.check_signals()?;
            snapshot(py, states, h)
        })
        .collect::<PyResult<Vec<Snapshot>>>()?;
    let diagnosis = pool::run(py, move || compare(&before, &after, &coordinates))?;
    let diagnosis = diagnosis.map_err(|error| diagnostic_error(py, &error))?;
    let threads = pool::shared(py)?.current_num_threads();
    Ok(Report::new(diagnosis, title, config, &run, threads))
}

/// A loop integral: (value, quadrature error, round-off, contributions of the degrees of freedom).
type Integral = (f64, Option<f64>, f64, Vec<f64>);

/// The loop integral of samples, read where they are if each coordinate lies side by side.
#[pyfunction]
#[pyo3(signature = (q, p, rule_name, cutoffs, stated))]
pub fn loop_integral(
    py: Python<'_>,
    q: PyReadonlyArray2<'_, f64>,
    p: PyReadonlyArray2<'_, f64>,
    rule_name: &str,
    cutoffs: CutoffPair,
    stated: Stated,
) -> PyResult<Integral> {
    let rule = rule(py, rule_name, cutoffs)?;
    arrays::check_shapes(py, &q, &p)?;
    let coordinates = stated.of(py, q.as_array().ncols())?;
    let integral = match Columns::of(&q).zip(Columns::of(&p)) {
        Some((q, p)) => pool::run(py, move || {
            LoopIntegral::of_rows(q.rows(), p.rows(), &rule, &coordinates)
        })?,
        None => {
            let states = arrays::ensemble(py, &q, &p)?;
            pool::run(py, move || {
                LoopIntegral::of_rows(states.q(), states.p(), &rule, &coordinates)
            })?
        }
    };
    let found = integral.map_err(|error| diagnostic_error(py, &error))?;
    Ok((
        found.value,
        found.quadrature_error,
        found.roundoff,
        found.contributions,
    ))
}

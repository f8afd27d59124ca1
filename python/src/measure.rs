//! `symplint.measure` and `symplint.loop_integral`: loops that another code advanced.

use numpy::PyReadonlyArray2;
use numpy::ndarray::{ArrayView2, s};
use pyo3::prelude::*;
use rayon::prelude::*;
use symplint::{Coordinates, Ensemble, Error, LoopIntegral, Rule, Snapshot, measure as compare};

use crate::arrays;
use crate::check::{CutoffPair, rule};
use crate::coordinates::Stated;
use crate::error::{diagnostic_error, other_error};
use crate::memory::Samples;
use crate::pool;
use crate::report::{self, Report};

/// Degrees of freedom of arrays in C order that are copied and integrated together, so that their rows stay in the cache.
const TOGETHER: usize = 32;

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

/// The loop integral of samples, read where they are if the values of each coordinate lie side by side.
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
    let integral = match Samples::of(&q).zip(Samples::of(&p)) {
        Some((q, p)) => pool::run(py, move || match q.rows().zip(p.rows()) {
            Some((q, p)) => LoopIntegral::of_rows(q, p, &rule, &coordinates),
            None => in_parts(q.view(), p.view(), &rule, &coordinates),
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

/// The integral of arrays in another order, some degrees of freedom at a time.
fn in_parts(
    q: ArrayView2<'_, f64>,
    p: ArrayView2<'_, f64>,
    rule: &Rule,
    coordinates: &Coordinates,
) -> Result<LoopIntegral, Error> {
    let dof = q.ncols();
    let of = |states: &mut Ensemble, first: usize| {
        let columns = s![.., first..first + states.dof()];
        let mut block = states.block();
        arrays::transpose(q.slice(columns), &mut block.q);
        arrays::transpose(p.slice(columns), &mut block.p);
        let coordinates = part(coordinates, first, states.dof())?;
        LoopIntegral::of_rows(states.q(), states.p(), rule, &coordinates)
    };
    // Each thread copies all its parts into the same memory: the system takes long to provide more.
    let of_thread = |firsts: &[usize]| -> Result<Vec<LoopIntegral>, Error> {
        let mut states = Ensemble::zeros(TOGETHER, q.nrows());
        let of_part = |&first: &usize| match dof - first {
            rest @ ..TOGETHER => of(&mut Ensemble::zeros(rest, q.nrows()), first),
            _ => of(&mut states, first),
        };
        firsts.iter().map(of_part).collect()
    };
    let firsts: Vec<usize> = (0..dof).step_by(TOGETHER).collect();
    let of_each = firsts.len().div_ceil(rayon::current_num_threads()).max(1);
    let parts: Result<Vec<_>, Error> = firsts.par_chunks(of_each).map(of_thread).collect();
    let whole = parts.and_then(|parts| match parts.concat().as_slice() {
        [one] => Ok(one.clone()),
        parts => LoopIntegral::merged(parts),
    });
    // An error of a part has the number of a degree of freedom among those of the part.
    whole.or_else(|_| of(&mut Ensemble::zeros(dof, q.nrows()), 0))
}

/// The coordinates of some degrees of freedom.
fn part(coordinates: &Coordinates, first: usize, count: usize) -> Result<Coordinates, Error> {
    let of = |value: fn(&Coordinates, usize) -> f64| {
        (first..first + count)
            .map(move |i| value(coordinates, i))
            .collect::<Vec<f64>>()
    };
    Coordinates::plain(count)
        .with_periods(of(Coordinates::period))?
        .with_momentum_periods(of(Coordinates::momentum_period))?
        .with_weights(of(Coordinates::weight))
}

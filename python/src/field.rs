//! `symplint.check_force` and `symplint.check_field`: a test of a force or a vector field.

use std::path::PathBuf;

use pyo3::prelude::*;
use symplint::field::{FieldKind, FieldRadius, FieldTest};
use symplint::{Loop, TimeAdvance};

use crate::calls::Caller;
use crate::check::Subject;
use crate::error::other_error;
use crate::workers;

/// How it is tested.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct FieldSettings {
    /// Whether the function is a force.
    is_force: bool,
    q0: Vec<f64>,
    p0: Vec<f64>,
    /// A radius for each coordinate, or nothing for those that the force suggests.
    radius: Option<Vec<f64>>,
    loops: usize,
    budget: usize,
    seed: u64,
}

/// Tests a force or a vector field, which the subject has as a step without a step size, and returns the report as JSON. Its results are
/// noted in a journal, if a path and the identity of the run, as JSON, are given.
#[pyfunction]
#[pyo3(signature = (subject, settings, journal=None))]
pub fn check_field(
    py: Python<'_>,
    subject: Subject,
    settings: FieldSettings,
    journal: Option<(PathBuf, String)>,
) -> PyResult<String> {
    let journal = journal
        .map(|(path, of)| workers::open(py, &path, &of))
        .transpose()?;
    let test = FieldTest {
        radius: settings.radius.map_or(FieldRadius::Auto, FieldRadius::Each),
        loops: settings.loops,
        budget: settings.budget,
        seed: settings.seed,
    };
    let kind = match settings.is_force {
        true => FieldKind::Force,
        false => FieldKind::Field,
    };
    let (q0, p0) = (settings.q0, settings.p0);
    let work = |_: &dyn Caller, map: &dyn TimeAdvance, _: &dyn Loop| match kind {
        FieldKind::Force => test.run_force(map, &q0),
        FieldKind::Field => test.run_field(map, &q0, &p0),
    };
    let report = subject.run(py, (None, journal), 1.0, work)?.result;
    serde_json::to_string(&report).map_err(|error| other_error(py, &error.to_string()))
}

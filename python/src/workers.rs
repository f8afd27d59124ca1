//! Steps that workers take: what a worker does, and the journal of what they did.

use std::path::Path;
use std::sync::Arc;

use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use symplint::Ensemble;
use symplint::map::Difference;
use symplint_run::{Call, Journal, JournalError};

use crate::arrays::{self, Arrays};
use crate::block_call::BlockCall;
use crate::error::{input_error, other_error};

/// The sample at which a function failed, and its exception.
type Failed = (usize, PyErr);

/// Advances states by a function of the user in the process of a worker. Returns the result or the failure: the rest of the
/// work of a worker continues.
#[pyfunction]
pub fn advance<'py>(
    function: Bound<'py, PyAny>,
    h: Option<f64>,
    reset: Option<Bound<'py, PyAny>>,
    per_sample: bool,
    single: bool,
    q: PyReadonlyArray2<'py, f64>,
    p: PyReadonlyArray2<'py, f64>,
) -> PyResult<(Option<Arrays<'py>>, Option<Failed>)> {
    let py = function.py();
    let call = BlockCall {
        function,
        what: if h.is_none() { "advance" } else { "step" },
        h,
        reset,
    };
    let mut states = arrays::ensemble(py, &q, &p)?;
    let mut block = states.block();
    let advanced = call.advance(per_sample, single, &mut None, &mut block);
    match advanced {
        Ok(_) => Ok((Some(arrays::arrays(py, &states)), None)),
        Err(failed) if crate::calls::ends_programs(py, &failed.error) => Err(failed.error),
        Err(failed) => Ok((None, Some((failed.sample, failed.error)))),
    }
}

/// The journal of a check whose states are advanced elsewhere.
#[pyclass(frozen, module = "symplint._native")]
pub struct SharedJournal(Arc<Journal>);

impl SharedJournal {
    /// What workers do is noted in this one.
    pub fn new(journal: &Arc<Journal>) -> Self {
        SharedJournal(Arc::clone(journal))
    }
}

#[pymethods]
impl SharedJournal {
    /// What tells the next call with these states, and what came of it, if the journal has it.
    fn find<'py>(
        &self,
        py: Python<'py>,
        h: f64,
        q: PyReadonlyArray2<'py, f64>,
        p: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<(Call, Option<Arrays<'py>>)> {
        let mut states = arrays::ensemble(py, &q, &p)?;
        let mut block = states.block();
        let call = self.0.call(h, &block);
        let replayed = self.0.replay(call, &mut block);
        let found = replayed.map_err(|error| lost(py, &error))?;
        Ok((call, found.then(|| arrays::arrays(py, &states))))
    }

    /// Notes what came of a call.
    fn note(
        &self,
        py: Python<'_>,
        call: Call,
        q: PyReadonlyArray2<'_, f64>,
        p: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<()> {
        let mut states = arrays::ensemble(py, &q, &p)?;
        (self.0.note(call, &states.block())).map_err(|error| lost(py, &error))
    }
}

/// The exception where states cannot be noted.
fn lost(py: Python<'_>, error: &JournalError) -> PyErr {
    other_error(py, &error.to_string())
}

/// The journal in a file, of what a text in JSON describes.
pub fn open(py: Python<'_>, path: &Path, of: &str) -> PyResult<Arc<Journal>> {
    let of = serde_json::from_str(of).map_err(|error| other_error(py, &error.to_string()))?;
    let journal = Journal::open(path, &of);
    let journal = journal.map_err(|error| input_error(py, &error.to_string()))?;
    Ok(Arc::new(journal))
}

/// The workers of a check: the object of Python that hands states to them.
pub struct Workers(Py<PyAny>);

impl Workers {
    /// These workers; what they do is noted in the journal, if there is one.
    pub fn new(
        py: Python<'_>,
        object: &Py<PyAny>,
        journal: Option<&Arc<Journal>>,
    ) -> PyResult<Self> {
        if let Some(journal) = journal {
            let shared = Bound::new(py, SharedJournal::new(journal))?;
            object.setattr(py, "journal", shared)?;
        }
        Ok(Workers(object.clone_ref(py)))
    }

    /// Lets them begin to advance states that will be asked for.
    pub fn begin(&self, py: Python<'_>, h: f64, states: &Ensemble) -> PyResult<()> {
        let (q, p) = arrays::arrays(py, states);
        self.0.call_method1(py, "begin", (h, q, p))?;
        Ok(())
    }

    /// The number of processes that took steps, and the largest difference between their results for the same states, if they
    /// differ.
    pub fn found(&self, py: Python<'_>) -> PyResult<(usize, Option<Difference>)> {
        let found = self.0.bind(py).call_method0("found")?;
        let (count, difference): (usize, Option<(char, usize, f64)>) = found.extract()?;
        let difference = difference.map(|(coordinate, dof, size)| Difference {
            coordinate,
            dof,
            size,
        });
        Ok((count, difference))
    }

    /// The advanced states, or the sample at which the step failed and why.
    pub fn advance<'py>(
        &self,
        py: Python<'py>,
        h: f64,
        states: &Ensemble,
    ) -> PyResult<Result<Arrays<'py>, Failed>> {
        let (q, p) = arrays::arrays(py, states);
        let advanced = self.0.bind(py).call_method1("advance", (h, q, p))?;
        let (states, failed): (Option<Arrays<'py>>, Option<(usize, Bound<'py, PyAny>)>) =
            advanced.extract()?;
        match (states, failed) {
            (Some(states), _) => Ok(Ok(states)),
            (None, Some((sample, error))) => Ok(Err((sample, PyErr::from_value(error)))),
            (None, None) => Err(other_error(py, "workers returned nothing")),
        }
    }
}

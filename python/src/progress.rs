//! The progress of a check, for Python to draw.

use std::sync::{Arc, Mutex, PoisonError};

use pyo3::prelude::*;
use symplint::diagnosis::Progress;
use symplint_report::progress::ProgressLine;

/// A line of text that shows how far a check has come.
#[pyclass(frozen)]
pub struct Line(Mutex<ProgressLine>);

impl Line {
    /// Begins to measure the rate.
    pub fn new(progress: &Arc<Progress>) -> Self {
        Line(Mutex::new(ProgressLine::new(progress)))
    }
}

#[pymethods]
impl Line {
    /// The line at this moment.
    fn text(&self) -> String {
        let mut line = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        line.text()
    }
}

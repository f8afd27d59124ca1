//! Errors as Python exceptions.

use pyo3::prelude::*;
use pyo3::types::PyType;
use symplint::Error;
use symplint::error::{LOOK_AT_MAP, StateLocation};
use symplint_config::ConfigError;

/// An exception class of `symplint._errors`.
fn class<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyType>> {
    Ok(py.import("symplint._errors")?.getattr(name)?.cast_into()?)
}

/// An exception of that class, or the error that prevented it.
fn exception(py: Python<'_>, name: &str, message: &str) -> PyErr {
    match class(py, name).and_then(|class| class.call1((message,))) {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

/// An argument that is not valid.
pub fn input_error(py: Python<'_>, message: &str) -> PyErr {
    exception(py, "InputError", message)
}

/// Anything else that went wrong.
pub fn other_error(py: Python<'_>, message: &str) -> PyErr {
    exception(py, "SymplintError", message)
}

/// An error of a configuration: the message and the remedy.
pub fn config_error(py: Python<'_>, error: &ConfigError) -> PyErr {
    match &error.remedy {
        Some(remedy) => input_error(py, &format!("{}; {remedy}", error.message)),
        None => input_error(py, &error.message),
    }
}

/// Where and with which step size a map failed.
struct Failed {
    h: Option<f64>,
    s: Option<f64>,
    sample: Option<usize>,
}

impl Failed {
    fn at(at: StateLocation, h: Option<f64>) -> Self {
        let (s, sample) = match at {
            StateLocation::Sample(sample) => (None, Some(sample)),
            StateLocation::SampleOf { sample, samples } => {
                (Some(sample as f64 / samples as f64), Some(sample))
            }
            StateLocation::Loop(s) | StateLocation::RandomLoop(s) | StateLocation::Displaced(s) => {
                (Some(s), None)
            }
            _ => (None, None),
        };
        Failed { h, s, sample }
    }

    /// That of an error which the map caused.
    fn of(error: &Error) -> Option<Self> {
        match error {
            Error::NotFinite {
                at,
                step_size,
                remedy,
                ..
            } if step_size.is_some() || *remedy == LOOK_AT_MAP => Some(Self::at(*at, *step_size)),
            Error::StepFailed { at, step_size, .. } => Some(Self::at(*at, *step_size)),
            Error::Memory { s, step_size, .. } => Some(Failed {
                h: *step_size,
                s: *s,
                sample: None,
            }),
            Error::InStep { error, .. } => Self::of(error),
            _ => None,
        }
    }
}

/// The exception for an error of the diagnostic.
pub fn diagnostic_error(py: Python<'_>, error: &Error) -> PyErr {
    step_error(py, error, "")
}

/// The exception for an error of the diagnostic, with advice that follows its text.
pub fn step_error(py: Python<'_>, error: &Error, advice: &str) -> PyErr {
    let message = format!("{error}{advice}");
    match Failed::of(error) {
        None => input_error(py, &message),
        Some(Failed { h, s, sample }) => {
            let made =
                class(py, "StepError").and_then(|class| class.call1((message, h, s, sample)));
            made.map_or_else(|error| error, PyErr::from_value)
        }
    }
}

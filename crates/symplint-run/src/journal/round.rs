//! A round of calls that are to be made elsewhere: by the jobs of a scheduler.
//!
//! The file is a journal whose records hold h, the number of degrees of freedom, that of samples, and the states before the
//! step.

use std::path::Path;

use serde_json::Value;
use symplint::Ensemble;
use symplint_files::write_whole;

use super::JournalError;
use super::log::{Call, Record, fill, header, numbers, record, records};

/// A call that is to be made.
pub struct Request {
    /// Identifies it in journals.
    pub call: Call,
    /// The step size.
    pub h: f64,
    /// The states before the step.
    pub states: Ensemble,
}

impl Request {
    /// A call with copies of states.
    pub fn new(call: Call, h: f64, states: Ensemble) -> Self {
        Request { call, h, states }
    }

    fn bytes(&self) -> Vec<u8> {
        let (dof, samples) = (self.states.dof(), self.states.samples());
        let sizes = vec![self.h, dof as f64, samples as f64];
        let states = numbers(&self.states.clone().block());
        record(self.call, &[sizes, states].concat())
    }

    /// The request in a record, if its numbers are as many as they say.
    fn of(record: &Record) -> Option<Self> {
        let (&[h, dof, samples], states) = record.numbers.split_first_chunk()?;
        let (dof, samples) = (dof as usize, samples as usize);
        let count = dof.checked_mul(samples)?.checked_mul(2)?;
        if count == 0 || states.len() != count {
            return None;
        }
        let mut read = Ensemble::zeros(dof, samples);
        fill(&mut read.block(), states);
        Some(Request::new(record.call, h, read))
    }
}

/// Writes a round of calls of the run that `run` describes, all of them or no file.
///
/// # Errors
/// If the file cannot be written.
pub fn write_round(path: &Path, run: &Value, requests: &[Request]) -> Result<(), JournalError> {
    let calls = requests.iter().flat_map(Request::bytes);
    let bytes: Vec<u8> = header(run).into_iter().chain(calls).collect();
    write_whole(path, &bytes).map_err(|error| JournalError::of_file("write", path, &error))
}

/// Reads a round of calls of the run that `run` describes, up to the first one that is damaged.
///
/// # Errors
/// If the file cannot be read, or is of another run.
pub fn read_round(path: &Path, run: &Value) -> Result<Vec<Request>, JournalError> {
    let requests = records(path, run)?;
    Ok(requests.iter().map_while(Request::of).collect())
}

//! A round of calls that are to be made elsewhere: by the jobs of a scheduler.
//!
//! The file is a journal whose records hold h, the number of degrees of freedom, that of samples, and the states before the
//! step.

use std::fs::{self, File};
use std::io::{self, BufReader, Read, Write};
use std::path::Path;

use serde_json::Value;
use symplint::{Block, Ensemble};

use crate::difference::difference;
use crate::error::JournalError;
use crate::record::{
    CHECKSUM, Call, Header, PREFIX, header, read_header, read_record, record, size,
};
use crate::scan::{Contents, scan};

/// A call that is to be made.
pub struct Request {
    /// What it is known by.
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

    fn numbers(&self) -> Vec<f64> {
        let (dof, samples) = (self.states.dof(), self.states.samples());
        let mut numbers = vec![self.h, dof as f64, samples as f64];
        for rows in [self.states.q(), self.states.p()] {
            (0..dof).for_each(|i| numbers.extend(rows.row(i)));
        }
        numbers
    }

    /// That of numbers, if there are as many as they say.
    fn of(call: Call, numbers: &[f64]) -> Option<Self> {
        let (&[h, dof, samples], states) = numbers.split_first_chunk()?;
        let (dof, samples) = (dof as usize, samples as usize);
        let count = dof.checked_mul(samples)?.checked_mul(2)?;
        if samples == 0 || dof == 0 || states.len() != count {
            return None;
        }
        let mut read = Ensemble::zeros(dof, samples);
        let mut block = read.block();
        fill(&mut block, states);
        Some(Request::new(call, h, read))
    }
}

fn fill(block: &mut Block<'_>, numbers: &[f64]) {
    let (dof, samples) = (block.dof(), block.len());
    for (i, row) in numbers.chunks_exact(samples).enumerate() {
        match i < dof {
            true => block.q.row_mut(i).copy_from_slice(row),
            false => block.p.row_mut(i - dof).copy_from_slice(row),
        }
    }
}

/// Writes a round of calls of the run that `run` describes, as a whole or not at all.
///
/// # Errors
/// If the file cannot be written.
pub fn write_round(path: &Path, run: &Value, requests: &[Request]) -> Result<(), JournalError> {
    let beside = path.with_extension("part");
    let write = || {
        let mut file = File::create(&beside)?;
        file.write_all(&header(&run.to_string()))?;
        for request in requests {
            file.write_all(&record(request.call, request.numbers().into_iter()))?;
        }
        file.sync_all()?;
        fs::rename(&beside, path)
    };
    write().map_err(|error| {
        let _ = fs::remove_file(&beside);
        JournalError::of_file("write", path, &error)
    })
}

/// Reads a round of calls of the run that `run` describes.
///
/// # Errors
/// If the file cannot be read, is not whole, or is of another run.
pub fn read_round(path: &Path, run: &Value) -> Result<Vec<Request>, JournalError> {
    let file_error = |error: io::Error| JournalError::of_file("read", path, &error);
    let file = File::open(path).map_err(file_error)?;
    let mut left = file.metadata().map_err(file_error)?.len();
    let mut file = BufReader::new(file);
    let foreign = || JournalError::NotAJournal {
        path: path.to_owned(),
    };
    let Header::Whole(there, length) = read_header(&mut file).map_err(file_error)? else {
        return Err(foreign());
    };
    let there: Value = serde_json::from_str(&there).map_err(|_| foreign())?;
    if let Some(difference) = difference("", &there, run) {
        let path = path.to_owned();
        return Err(JournalError::OtherRun { path, difference });
    }
    left = left.saturating_sub(length);
    let mut requests = Vec::new();
    while left > 0 {
        let mut bytes = Vec::new();
        let mut kept = Keeping {
            file: &mut file,
            bytes: &mut bytes,
        };
        let (call, count) = read_record(&mut kept, left)
            .map_err(file_error)?
            .ok_or_else(foreign)?;
        let numbers: Vec<f64> = bytes[PREFIX as usize..bytes.len() - CHECKSUM as usize]
            .chunks_exact(8)
            .map(|bytes| f64::from_le_bytes(bytes.try_into().expect("eight bytes")))
            .collect();
        requests.push(Request::of(call, &numbers).ok_or_else(foreign)?);
        left = left.saturating_sub(size(count));
    }
    Ok(requests)
}

/// The calls that the journal in a file has, also while a run writes to it: the file stays as it is, and is not locked.
///
/// # Errors
/// If the file cannot be read, or is not a journal of the run that `run` describes.
pub fn calls_in(path: &Path, run: &Value) -> Result<Vec<Call>, JournalError> {
    let expected = header(&run.to_string());
    let contents = File::open(path).and_then(|mut file| scan(&mut file, &expected));
    let path = path.to_owned();
    match contents {
        Err(error) => Err(JournalError::of_file("read", &path, &error)),
        Ok(Contents::Nothing) => Ok(Vec::new()),
        Ok(Contents::Foreign) => Err(JournalError::NotAJournal { path }),
        Ok(Contents::Damaged { at }) => Err(JournalError::Damaged { path, at }),
        Ok(Contents::Records {
            run: there, found, ..
        }) => {
            let there = serde_json::from_str(&there).unwrap_or(Value::Null);
            match difference("", &there, run) {
                None => Ok(found.into_keys().collect()),
                Some(difference) => Err(JournalError::OtherRun { path, difference }),
            }
        }
    }
}

/// Keeps what is read.
struct Keeping<'a, R> {
    file: &'a mut R,
    bytes: &'a mut Vec<u8>,
}

impl<R: Read> Read for Keeping<'_, R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.file.read(buffer)?;
        self.bytes.extend(&buffer[..read]);
        Ok(read)
    }
}

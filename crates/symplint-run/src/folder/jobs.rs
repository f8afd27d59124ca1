//! The calls that jobs of a scheduler make, in a run folder: a round of them in `round/calls`, and next to it the results of
//! each part, `part-K-of-N`, and its calls that failed, `part-K-of-N.failed`.

use std::collections::{HashMap, HashSet};
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use symplint::StepFailure;
use symplint_files::write_whole;
use symplint_report::run_folder::LOCK;

use super::{RunError, cannot_read, cannot_write, remove};
use crate::journal::{Call, Journal, JournalError, Request, read_round, records, write_round};

/// A call that failed this number of times is a failure of the map.
const MAX_FAILURES: usize = 2;

/// The folder of a round in a run folder.
const ROUND: &str = "round";
/// The calls of a round, in its folder.
const CALLS: &str = "calls";
/// The calls that failed, in a run folder.
const FAILED: &str = "failed.json";

/// A round in a run folder.
pub struct Round {
    folder: PathBuf,
    /// The identity of its run.
    run: Value,
}

/// A call that failed.
#[derive(Clone, Serialize, Deserialize)]
struct FailedCall {
    call: Call,
    h: f64,
    sample: usize,
    reason: String,
    /// How often it failed, with the failures of earlier rounds: a part that is collected twice counts once.
    times: usize,
}

impl Round {
    /// The round of a run in this folder.
    pub fn of_run(folder: &Path, run: &Value) -> Self {
        Round {
            folder: folder.join(ROUND),
            run: json!({ "round": true, "run": run }),
        }
    }

    /// Writes the calls of a new round.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn write(&self, requests: &[Request]) -> Result<(), RunError> {
        fs::create_dir_all(&self.folder).map_err(|error| cannot_write(&self.folder, &error))?;
        Ok(write_round(&self.folder.join(CALLS), &self.run, requests)?)
    }

    /// The calls.
    ///
    /// # Errors
    /// If the folder has no round, or one of another run.
    pub fn read(&self) -> Result<Vec<Request>, RunError> {
        Ok(read_round(&self.folder.join(CALLS), &self.run)?)
    }

    /// Checks that a run folder has a round, and keeps every run but other jobs out of the folder until the returned file is closed.
    ///
    /// # Errors
    /// If the folder has no round, or a run writes to the folder.
    pub fn share(folder: &Path) -> Result<File, RunError> {
        if !folder.join(ROUND).join(CALLS).exists() {
            let path = folder.to_owned();
            return Err(RunError::NoRound { path });
        }
        let path = folder.join(LOCK);
        let lock = File::open(&path).map_err(|error| cannot_read(&path, &error))?;
        match lock.try_lock_shared() {
            Err(TryLockError::WouldBlock) => {
                let path = folder.to_owned();
                Err(JournalError::InUse { path }.into())
            }
            // Some file systems of clusters have no locks.
            _ => Ok(lock),
        }
    }

    /// The journal of part k of n.
    ///
    /// # Errors
    /// If it cannot be written, or another job writes to it.
    pub fn part(&self, part: (usize, usize)) -> Result<Journal, RunError> {
        Ok(Journal::open(&self.of_part(part), &self.run)?)
    }

    /// The calls that the jobs of this round have made so far, in parts of any number. `collect` reports files that cannot be
    /// read.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn made(&self) -> Result<HashSet<Call>, RunError> {
        let parts = self.parts()?;
        let made = journals(&parts).filter_map(|path| records(path, &self.run).ok());
        Ok(made.flatten().map(|record| record.call).collect())
    }

    /// Stores the calls of a part that failed, and those of an earlier job for this part that its journal does not have.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn store_failed(
        &self,
        part: (usize, usize),
        journal: &Journal,
        failed: &[(&Request, StepFailure)],
    ) -> Result<(), RunError> {
        let path = self.of_part(part).with_extension("failed");
        let known = read_calls(&self.of_failed())?;
        let times = |call: Call| {
            let known = known.iter().find(|known| known.call == call);
            known.map_or(0, |known| known.times)
        };
        let new = failed.iter().map(|(request, failure)| FailedCall {
            call: request.call,
            h: request.h,
            sample: failure.sample,
            reason: failure.reason.clone(),
            times: times(request.call) + 1,
        });
        let mut calls: Vec<FailedCall> = new.collect();
        for earlier in read_calls(&path)? {
            let is_new = calls.iter().any(|call| call.call == earlier.call);
            if !is_new && !journal.has(earlier.call) {
                calls.push(earlier);
            }
        }
        write_calls(&path, &calls)
    }

    /// Moves the results of all parts into the journal of the run and its list of failures.
    ///
    /// # Errors
    /// If a file cannot be read, written or removed.
    pub fn collect(&self, journal: &Journal) -> Result<(), RunError> {
        let parts = self.parts()?;
        for path in journals(&parts) {
            journal.merge(&records(path, &self.run)?)?;
        }
        let mut failed = read_calls(&self.of_failed())?;
        for path in parts.iter().filter(|path| path.extension().is_some()) {
            for new in read_calls(path)? {
                match failed.iter_mut().find(|known| known.call == new.call) {
                    Some(known) => known.times = known.times.max(new.times),
                    None => failed.push(new),
                }
            }
        }
        failed.retain(|known| !journal.has(known.call));
        write_calls(&self.of_failed(), &failed)?;
        parts.iter().try_for_each(|path| remove(path))
    }

    /// Removes the calls of a run that has ended. The list of failures stays: these calls are not asked for again.
    ///
    /// # Errors
    /// If they cannot be removed.
    pub fn end(&self) -> Result<(), RunError> {
        self.parts()?.iter().try_for_each(|path| remove(path))?;
        remove(&self.folder.join(CALLS))?;
        // It may hold a file that a killed job did not write to its end.
        let _ = fs::remove_dir(&self.folder);
        Ok(())
    }

    /// Removes all of it, for a run that begins anew.
    ///
    /// # Errors
    /// If it cannot be removed.
    pub fn remove(&self) -> Result<(), RunError> {
        self.end()?;
        remove(&self.of_failed())
    }

    /// Calls that failed often enough.
    ///
    /// # Errors
    /// If the list cannot be read.
    pub fn failed(&self) -> Result<HashMap<Call, StepFailure>, RunError> {
        let failed = read_calls(&self.of_failed())?.into_iter();
        let failed = failed.filter(|failed| failed.times >= MAX_FAILURES);
        let failure = |FailedCall { sample, reason, .. }| StepFailure { sample, reason };
        Ok(failed
            .map(|failed| (failed.call, failure(failed)))
            .collect())
    }

    fn of_failed(&self) -> PathBuf {
        self.folder.with_file_name(FAILED)
    }

    fn of_part(&self, (k, n): (usize, usize)) -> PathBuf {
        self.folder.join(format!("part-{k}-of-{n}"))
    }

    /// The files of the parts, sorted.
    fn parts(&self) -> Result<Vec<PathBuf>, RunError> {
        let entries = match fs::read_dir(&self.folder) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries.and_then(|entries| {
                let paths = entries.map(|entry| Ok(entry?.path()));
                paths.collect::<io::Result<Vec<PathBuf>>>()
            }),
        };
        let mut paths = entries.map_err(|error| cannot_read(&self.folder, &error))?;
        paths.retain(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.starts_with("part-")
        });
        paths.sort();
        Ok(paths)
    }
}

/// The parts with results.
fn journals(parts: &[PathBuf]) -> impl Iterator<Item = &PathBuf> {
    parts.iter().filter(|path| path.extension().is_none())
}

/// Reads a list of calls; a file that is not there is an empty one.
fn read_calls(path: &Path) -> Result<Vec<FailedCall>, RunError> {
    match fs::read_to_string(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(cannot_read(path, &error)),
        Ok(text) => serde_json::from_str(&text).map_err(|error| cannot_read(path, &error)),
    }
}

/// Writes a list of calls at once; no file for an empty one.
fn write_calls(path: &Path, calls: &[FailedCall]) -> Result<(), RunError> {
    if calls.is_empty() {
        return remove(path);
    }
    let text = serde_json::to_vec(calls).map_err(io::Error::from);
    let written = text.and_then(|text| write_whole(path, &text));
    written.map_err(|error| cannot_write(path, &error))
}

//! A round of calls for the jobs of a scheduler, in a run folder: `round/calls`, and beside it what each job makes of its
//! part, `part-K-of-N` with the states and `part-K-of-N.failed` with the calls that failed.

use std::collections::{HashMap, HashSet};
use std::fs::{self, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use symplint::StepFailure;
use symplint_files::write_whole;
use symplint_journal::{Call, Journal, JournalError, Request, calls_in, read_round, write_round};

use super::earlier_run::JOURNAL;
use crate::failure::Failure;

/// So often a call is made before its failure counts as that of the map.
const MOST_FAILURES: usize = 2;

/// The folder of rounds in a run folder.
pub const ROUND: &str = "round";
/// The calls of a round, in its folder.
const CALLS: &str = "calls";
/// The calls that failed, in a run folder.
pub const FAILED: &str = "failed.json";

/// A round in a run folder.
pub struct Round {
    folder: PathBuf,
    /// What the calls are of.
    run: Value,
}

/// A call that failed.
#[derive(Clone, Serialize, Deserialize)]
struct FailedCall {
    call: Call,
    h: f64,
    sample: usize,
    reason: String,
    /// How often: in the list of a part with what the list of the run had when the job ended, so that a part counts once however
    /// often it is taken in.
    times: usize,
}

impl Round {
    /// That of a run in this folder.
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
    pub fn write(&self, requests: &[Request]) -> Result<(), Failure> {
        fs::create_dir_all(&self.folder).map_err(|error| write_error(&self.folder, &error))?;
        Ok(write_round(&self.folder.join(CALLS), &self.run, requests)?)
    }

    /// The calls.
    ///
    /// # Errors
    /// If there is no round, or it is of another run.
    pub fn read(&self) -> Result<Vec<Request>, Failure> {
        let path = self.folder.join(CALLS);
        read_round(&path, &self.run).map_err(|error| match error {
            JournalError::NotAJournal { path } => Failure::Usage {
                message: format!("{} is damaged", path.display()),
                remedy:
                    "write the round anew by `symplint collect DIR`, which keeps what jobs made"
                        .into(),
            },
            JournalError::OtherRun { path, difference } => Failure::Usage {
                message: format!("{} is of another run: {difference}", path.display()),
                remedy: "put back what differs, or begin anew by `symplint plan --force`".into(),
            },
            error => error.into(),
        })
    }

    /// Checks that there is a round in a run folder.
    ///
    /// # Errors
    /// If there is none.
    pub fn check_there(folder: &Path) -> Result<(), Failure> {
        match folder.join(ROUND).join(CALLS).exists() {
            true => Ok(()),
            false => Err(Failure::Usage {
                message: format!("{} has no round of calls", folder.display()),
                remedy: "write one by `symplint plan CONFIG.toml --out DIR`".into(),
            }),
        }
    }

    /// The journal of part k of n.
    ///
    /// # Errors
    /// If it cannot be written, or another job writes to it.
    pub fn part(&self, k: usize, n: usize) -> Result<Journal, Failure> {
        self.open_part(&self.folder.join(part_name(k, n)))
    }

    fn open_part(&self, path: &Path) -> Result<Journal, Failure> {
        Journal::open(path, &self.run).map_err(|error| match error {
            JournalError::NotAJournal { path } => Failure::Usage {
                message: format!("{} is not what a job made", path.display()),
                remedy: "remove it: its calls are made again".into(),
            },
            error => error.into(),
        })
    }

    /// The calls that the jobs of this round have made so far, for parts of any number. Of a file that cannot be read now there
    /// are none: `collect` names it.
    ///
    /// # Errors
    /// If the folder cannot be read.
    pub fn made(&self) -> Result<HashSet<Call>, Failure> {
        let parts = parts_in(&self.folder)?;
        let journals = parts.iter().filter(|path| path.extension().is_none());
        let made = journals.filter_map(|path| calls_in(path, &self.run).ok());
        Ok(made.flatten().collect())
    }

    /// Notes the calls of part k of n that failed, beside those of an earlier run of this part that the part has not made since.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn note_failed(
        &self,
        (k, n): (usize, usize),
        part: &Journal,
        failed: &[(&Request, StepFailure)],
    ) -> Result<(), Failure> {
        let path = self.folder.join(part_name(k, n) + ".failed");
        let known = self.failed_calls()?;
        let before = |request: &Request| {
            let known = known.iter().find(|known| known.call == request.call);
            known.map_or(0, |known| known.times)
        };
        let mut calls: Vec<FailedCall> = (failed.iter())
            .map(|(request, failure)| FailedCall {
                call: request.call,
                h: request.h,
                sample: failure.sample,
                reason: failure.reason.clone(),
                times: before(request) + 1,
            })
            .collect();
        if path.exists() {
            let earlier = read_calls(&path)?.into_iter();
            let stays = |earlier: &FailedCall| {
                let is_new = failed
                    .iter()
                    .any(|(request, _)| request.call == earlier.call);
                !is_new && !part.has(earlier.call)
            };
            calls.extend(earlier.filter(stays));
        }
        write_calls(&path, &calls)
    }

    /// Takes what all parts made into the journal of the run and its list of failures, and removes them. How many calls that
    /// were.
    ///
    /// # Errors
    /// If a file cannot be read, written or removed, or a job is still under way.
    pub fn collect(&self, journal: &Journal) -> Result<usize, Failure> {
        let parts = parts_in(&self.folder)?;
        // None is taken in before all have ended.
        let journals = parts.iter().filter(|path| path.extension().is_none());
        let journals: Vec<Journal> = (journals)
            .map(|path| self.open_part(path))
            .collect::<Result<_, Failure>>()?;
        let mut taken = 0;
        for part in &journals {
            taken += journal.merge(part)?;
        }
        let mut failed = self.failed_calls()?;
        for new in failed_in_round(&parts)? {
            match failed.iter_mut().find(|known| known.call == new.call) {
                Some(known) => known.times = known.times.max(new.times),
                None => failed.push(new),
            }
        }
        failed.retain(|known| !journal.has(known.call));
        write_calls(&self.of_failed(), &failed)?;
        for path in parts {
            remove(&path)?;
        }
        Ok(taken)
    }

    /// Removes the calls of a run that has ended, with what jobs made that nobody waits for. The list of those that failed stays:
    /// they are not asked for again.
    ///
    /// # Errors
    /// If they cannot be removed.
    pub fn end(&self) -> Result<(), Failure> {
        for path in parts_in(&self.folder)?
            .iter()
            .chain([&self.folder.join(CALLS)])
        {
            remove(path)?;
        }
        // It may hold a file that a job that was killed did not write to its end, which the next round replaces.
        let _ = fs::remove_dir(&self.folder);
        Ok(())
    }

    /// Removes all of it, for a run that begins anew.
    ///
    /// # Errors
    /// If it cannot be removed.
    pub fn remove(&self) -> Result<(), Failure> {
        self.end()?;
        remove(&self.of_failed())
    }

    /// Calls that failed as often as counts.
    ///
    /// # Errors
    /// If the list cannot be read.
    pub fn failed(&self) -> Result<HashMap<Call, StepFailure>, Failure> {
        let failed = self.failed_calls()?.into_iter();
        Ok(failed
            .filter(|failed| failed.times >= MOST_FAILURES)
            .map(|failed| {
                let FailedCall { sample, reason, .. } = failed;
                (failed.call, StepFailure { sample, reason })
            })
            .collect())
    }

    fn failed_calls(&self) -> Result<Vec<FailedCall>, Failure> {
        match self.of_failed() {
            path if path.exists() => read_calls(&path),
            _ => Ok(Vec::new()),
        }
    }

    fn of_failed(&self) -> PathBuf {
        self.folder.with_file_name(FAILED)
    }
}

/// Checks that nobody notes calls in a run folder, neither a run nor a job.
///
/// # Errors
/// If somebody does, or a file cannot be read.
pub fn check_idle(folder: &Path) -> Result<(), Failure> {
    let journal = folder.join(JOURNAL);
    if !journal.exists() {
        return Ok(());
    }
    for path in parts_in(&folder.join(ROUND))?.into_iter().chain([journal]) {
        // To be written, or some file systems do not lock it.
        let file = fs::File::options().append(true).open(&path);
        let file = file.map_err(|error| read_error(&path, &error))?;
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(JournalError::InUse { path }.into());
        }
    }
    Ok(())
}

/// The files of the parts in the folder of a round.
fn parts_in(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(|error| read_error(folder, &error))?,
    };
    let paths = entries.map(|entry| entry.map(|entry| entry.path()));
    let paths: Result<Vec<PathBuf>, _> = paths.collect();
    let mut paths = paths.map_err(|error| read_error(folder, &error))?;
    let is_part = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("part-")
    };
    paths.retain(is_part);
    paths.sort();
    Ok(paths)
}

/// The calls that failed in a round, each once: those that several jobs made, for parts of different numbers, too.
fn failed_in_round(parts: &[PathBuf]) -> Result<Vec<FailedCall>, Failure> {
    let mut failed: Vec<FailedCall> = Vec::new();
    for path in parts.iter().filter(|path| path.extension().is_some()) {
        for new in read_calls(path)? {
            if !failed.iter().any(|known| known.call == new.call) {
                failed.push(new);
            }
        }
    }
    Ok(failed)
}

fn part_name(k: usize, n: usize) -> String {
    format!("part-{k}-of-{n}")
}

fn read_calls(path: &Path) -> Result<Vec<FailedCall>, Failure> {
    let text = fs::read_to_string(path).map_err(|error| read_error(path, &error))?;
    serde_json::from_str(&text).map_err(|error| Failure::Read {
        path: path.to_owned(),
        reason: error.to_string(),
        remedy: "remove it: its calls are made again, and fail again if the map does",
    })
}

/// Writes a list of calls as a whole; none where it is empty.
fn write_calls(path: &Path, calls: &[FailedCall]) -> Result<(), Failure> {
    if calls.is_empty() {
        return remove(path);
    }
    let text = serde_json::to_vec(calls).map_err(std::io::Error::from);
    let written = text.and_then(|text| write_whole(path, &text));
    written.map_err(|error| write_error(path, &error))
}

/// Removes a file that may not be there.
pub fn remove(path: &Path) -> Result<(), Failure> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(write_error(path, &error)),
        _ => Ok(()),
    }
}

fn read_error(path: &Path, error: &std::io::Error) -> Failure {
    Failure::Read {
        path: path.to_owned(),
        reason: error.to_string(),
        remedy: "make it readable, or remove it: what jobs noted in it is made again",
    }
}

fn write_error(path: &Path, error: &std::io::Error) -> Failure {
    Failure::Write {
        path: path.to_owned(),
        reason: error.to_string(),
    }
}

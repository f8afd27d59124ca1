//! The journal: calls of a map, made or replayed.

mod error;
mod log;
mod round;

use std::collections::HashMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use serde_json::Value;
use symplint::Block;

use crate::difference::difference;

pub use error::JournalError;
pub use log::{Call, Key, Record, key, records};
use log::{PREFIX, Reader, fill, header, numbers, record};
pub use round::{Request, read_round, write_round};

/// How often records are written through to the disk, at most: a program that is killed loses none of them, a machine
/// that fails the last ones.
const SYNC: Duration = Duration::from_secs(1);

/// Evaluations of a map that were made, in a file.
///
/// # Examples
/// ```
/// # let folder = tempfile::TempDir::new()?;
/// # let path = folder.path().join("journal");
/// use serde_json::json;
/// use symplint::Ensemble;
/// use symplint_run::{Journal, JournalError};
///
/// let run = json!({ "map": "a drift", "version": "1.0" });
/// let drift = |journal: &Journal, calls: &mut usize| {
///     let mut states = Ensemble::zeros(1, 8);
///     states.block().p.fill(1.0);
///     let advanced = journal.advance(0.5, &mut states.block(), |block| {
///         *calls += 1;
///         block.q.fill(0.5);
///         Ok::<(), JournalError>(())
///     });
///     advanced.map(|()| states)
/// };
/// let mut calls = 0;
/// let states = drift(&Journal::open(&path, &run)?, &mut calls)?;
/// // The program ended, and is started again.
/// let journal = Journal::open(&path, &run)?;
/// assert_eq!(drift(&journal, &mut calls)?.q().row(0), states.q().row(0));
/// assert_eq!((calls, journal.replayed()), (1, 8));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Journal {
    path: PathBuf,
    records: Mutex<Records>,
    replayed: AtomicUsize,
    failure: OnceLock<JournalError>,
}

struct Records {
    /// Locked until it is closed.
    file: File,
    /// The start of the next record.
    end: u64,
    /// The start of the numbers of each call, and their count.
    found: HashMap<Call, (u64, usize)>,
    /// How often each call was asked for in this run.
    asked: HashMap<Key, u32>,
    synced: Instant,
}

impl Journal {
    /// The journal in a file, which is made if it is not there, of a run that `run` describes: the map, the configuration, the
    /// version of the program. The journal of another run without calls begins anew. The first record that is damaged, as by
    /// a kill, and all after it are removed: their calls are made again.
    ///
    /// # Errors
    /// If the file is not a journal, or of another run, or of one that is still under way, or cannot be read or written.
    pub fn open(path: &Path, run: &Value) -> Result<Self, JournalError> {
        let mut file = open_locked(path)?;
        let expected = header(run);
        let begins = begins_as(&mut file, &expected).map_err(of_file("read", path))?;
        if begins {
            return Self::begin(path, file, &expected);
        }
        let length = file.metadata().map_err(of_file("read", path))?.len();
        let reader = Reader::new(&file, length).map_err(of_file("read", path))?;
        let Some((mut reader, there)) = reader else {
            let path = path.to_owned();
            return Err(JournalError::NotAJournal { path });
        };
        let mut found = HashMap::new();
        loop {
            let first = reader.end + PREFIX as u64;
            match reader.next().map_err(of_file("read", path))? {
                Some(record) => found.insert(record.call, (first, record.numbers.len())),
                None => break,
            };
        }
        let end = reader.end;
        match difference("", &there, run) {
            None => file.set_len(end).map_err(of_file("write", path))?,
            Some(_) if found.is_empty() => return Self::begin(path, file, &expected),
            Some(difference) => {
                let path = path.to_owned();
                return Err(JournalError::OtherRun { path, difference });
            }
        }
        Ok(Self::of(path.to_owned(), file, end, found))
    }

    /// A journal without calls, which replaces whatever the file holds.
    ///
    /// # Errors
    /// If a run that is under way writes to the file, or it cannot be written.
    pub fn replace(path: &Path, run: &Value) -> Result<Self, JournalError> {
        Self::begin(path, open_locked(path)?, &header(run))
    }

    fn begin(path: &Path, mut file: File, header: &[u8]) -> Result<Self, JournalError> {
        let mut write = || {
            file.set_len(0)?;
            file.rewind()?;
            file.write_all(header)?;
            file.sync_data()
        };
        write().map_err(of_file("write", path))?;
        let end = header.len() as u64;
        Ok(Self::of(path.to_owned(), file, end, HashMap::new()))
    }

    fn of(path: PathBuf, file: File, end: u64, found: HashMap<Call, (u64, usize)>) -> Self {
        Journal {
            path,
            records: Mutex::new(Records {
                file,
                end,
                found,
                asked: HashMap::new(),
                synced: Instant::now(),
            }),
            replayed: AtomicUsize::new(0),
            failure: OnceLock::new(),
        }
    }

    /// Advances the states of a block by one step of size `h`: as the journal has it, or by `advance`, which is noted then.
    /// The same call may be made on purpose more than once, to see whether the map has a memory: the journal tells the
    /// first from the second.
    ///
    /// # Errors
    /// The failure of `advance`, which is not stored: a resumed run tries again. If the journal cannot be read or
    /// written; [`failure`](Self::failure) has the reason then.
    pub fn advance<E: From<JournalError>>(
        &self,
        h: f64,
        block: &mut Block<'_>,
        advance: impl FnOnce(&mut Block<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let call = self.call(h, block);
        if !self.replay(call, block)? {
            advance(block)?;
            self.note(call, block)?;
        }
        Ok(())
    }

    /// The next call with these states and this step size, which differs from those before it: for calls that are begun
    /// now and end later, in any order.
    pub fn call(&self, h: f64, block: &Block<'_>) -> Call {
        let key = key(h, block);
        let mut records = self.records();
        let asked = records.asked.entry(key).or_insert(0);
        let before = *asked;
        *asked = asked.saturating_add(1);
        (key, before)
    }

    /// Writes into the block what the journal has of a call, and says whether it has it.
    ///
    /// # Errors
    /// If the journal cannot be read.
    pub fn replay(&self, call: Call, block: &mut Block<'_>) -> Result<bool, JournalError> {
        let replayed = (self.read(call, block)).map_err(|error| self.failed("read", &error))?;
        if replayed {
            self.replayed.fetch_add(block.len(), Ordering::Relaxed);
        }
        Ok(replayed)
    }

    /// Notes what came of a call.
    ///
    /// # Errors
    /// If the journal cannot be written: then it ends as it did before.
    pub fn note(&self, call: Call, block: &Block<'_>) -> Result<(), JournalError> {
        (self.append(call, &numbers(block))).map_err(|error| self.failed("write", &error))
    }

    /// Whether the journal has what came of a call.
    pub fn has(&self, call: Call) -> bool {
        self.records().found.contains_key(&call)
    }

    /// Takes in records of other journals of the same map; returns how many this one did not have.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn merge(&self, records: &[Record]) -> Result<usize, JournalError> {
        let mut new = 0;
        for record in records.iter().filter(|record| !self.has(record.call)) {
            let appended = self.append(record.call, &record.numbers);
            appended.map_err(|error| self.failed("write", &error))?;
            new += 1;
        }
        Ok(new)
    }

    /// Writes all records through to the disk: to be called at the end.
    ///
    /// # Errors
    /// If they cannot be written, or could not be before.
    pub fn finish(&self) -> Result<(), JournalError> {
        if let Some(failure) = self.failure() {
            return Err(failure.clone());
        }
        let synced = self.records().file.sync_data();
        synced.map_err(|error| self.failed("write", &error))
    }

    /// Evaluations that were replayed so far.
    pub fn replayed(&self) -> usize {
        self.replayed.load(Ordering::Relaxed)
    }

    /// Why the journal cannot be read or written any more, if that is so: then a diagnosis should end, and not pay for
    /// evaluations that are lost.
    pub fn failure(&self) -> Option<&JournalError> {
        self.failure.get()
    }

    fn records(&self) -> MutexGuard<'_, Records> {
        self.records.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn read(&self, call: Call, block: &mut Block<'_>) -> io::Result<bool> {
        let mut records = self.records();
        let count = 2 * block.dof() * block.len();
        let found = records.found.get(&call).copied();
        let Some((first, _)) = found.filter(|(_, there)| *there == count) else {
            return Ok(false);
        };
        records.file.seek(SeekFrom::Start(first))?;
        let mut bytes = vec![0; 8 * count];
        records.file.read_exact(&mut bytes)?;
        let number = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().expect("eight bytes"));
        let numbers: Vec<f64> = bytes.chunks_exact(8).map(number).collect();
        fill(block, &numbers);
        Ok(true)
    }

    /// Adds a record. If that fails the file ends as it did before.
    fn append(&self, call: Call, numbers: &[f64]) -> io::Result<()> {
        let bytes = record(call, numbers);
        let mut records = self.records();
        let end = records.end;
        let mut write = || {
            records.file.seek(SeekFrom::Start(end))?;
            records.file.write_all(&bytes)?;
            if records.synced.elapsed() >= SYNC {
                records.file.sync_data()?;
                records.synced = Instant::now();
            }
            Ok(())
        };
        if let Err(error) = write() {
            // If that fails, too, the checksum shows that the record is not whole.
            let _ = records.file.set_len(end);
            return Err(error);
        }
        let first = end + PREFIX as u64;
        records.found.insert(call, (first, numbers.len()));
        records.end += bytes.len() as u64;
        Ok(())
    }

    fn failed(&self, action: &'static str, error: &io::Error) -> JournalError {
        let of_file = || JournalError::of_file(action, &self.path, error);
        self.failure.get_or_init(of_file).clone()
    }
}

/// The file, which no other process can open in this way until it is closed.
fn open_locked(path: &Path) -> Result<File, JournalError> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).create(true).truncate(false);
    let file = options.open(path).map_err(of_file("write", path))?;
    // Some file systems of clusters have no locks.
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => {
            let path = path.to_owned();
            Err(JournalError::InUse { path })
        }
        _ => Ok(file),
    }
}

fn of_file(action: &'static str, path: &Path) -> impl Fn(io::Error) -> JournalError {
    move |error| JournalError::of_file(action, path, &error)
}

/// Whether a file has nothing but the beginning of a header, whose writing was cut off.
fn begins_as(file: &mut File, header: &[u8]) -> io::Result<bool> {
    if file.metadata()?.len() >= header.len() as u64 {
        return Ok(false);
    }
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    file.rewind()?;
    Ok(header.starts_with(&bytes))
}

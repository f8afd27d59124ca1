//! The journal: calls of a map, made or replayed.

use std::collections::HashMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use serde_json::Value;
use symplint::Block;

use crate::difference::difference;
use crate::error::JournalError;
use crate::key::{Key, key};
use crate::record::{Call, PREFIX, header, record};
use crate::scan::{Contents, scan};

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
/// use symplint_journal::{Journal, JournalError};
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

/// An empty file for a new journal, which no other run has.
pub struct Claim {
    path: PathBuf,
    /// Locked until it is closed.
    file: File,
}

impl Claim {
    /// A journal without calls, of a run that `run` describes.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn begin(mut self, run: &Value) -> Result<Journal, JournalError> {
        let bytes = header(&run.to_string());
        begin(&mut self.file, &bytes).map_err(of_file("write", &self.path))?;
        let end = bytes.len() as u64;
        Ok(Journal::of(self.path, self.file, end, HashMap::new()))
    }
}

struct Records {
    /// Locked until it is closed.
    file: File,
    /// Where the next record begins.
    end: u64,
    /// Where the numbers of each call begin, and how many there are.
    found: HashMap<Call, (u64, u64)>,
    /// How often each call was asked for in this run.
    asked: HashMap<Key, u32>,
    synced: Instant,
}

impl Records {
    /// Writes them through to the disk, and looks whether `path` still leads to the file: until it is closed, a file without a
    /// name can be written to all the same.
    fn sync(&mut self, path: &Path) -> io::Result<()> {
        self.file.sync_data()?;
        if !is_at(&self.file, path)? {
            return Err(io::Error::other("another file is in its place"));
        }
        self.synced = Instant::now();
        Ok(())
    }
}

impl Journal {
    /// The journal in a file, which is made if it is not there, of a run that `run` describes: the map, the configuration, the
    /// version of the program. One of another run that has no calls begins anew. A record that was cut off at the end of the file
    /// is removed, and one whose bytes changed is passed over: its call is made again.
    ///
    /// # Errors
    /// If the file is no journal, or of another run, or one that still goes on, or is damaged where it says which run it is
    /// of, or cannot be read or written.
    pub fn open(path: &Path, run: &Value) -> Result<Self, JournalError> {
        let mut file = open_locked(path)?;
        let text = run.to_string();
        let bytes = header(&text);
        let contents = scan(&mut file, &bytes).map_err(of_file("read", path))?;
        let path = path.to_owned();
        let (end, found) = match contents {
            Contents::Nothing => {
                begin(&mut file, &bytes).map_err(of_file("write", &path))?;
                (bytes.len() as u64, HashMap::new())
            }
            Contents::Foreign => return Err(JournalError::NotAJournal { path }),
            Contents::Damaged { at } => return Err(JournalError::Damaged { path, at }),
            Contents::Records {
                run: there,
                end,
                found,
            } => {
                let of_there = serde_json::from_str(&there).unwrap_or(Value::Null);
                let of_here = serde_json::from_str(&text).unwrap_or(Value::Null);
                match difference("", &of_there, &of_here) {
                    None => {
                        file.set_len(end).map_err(of_file("write", &path))?;
                        (end, found)
                    }
                    // Nothing is lost.
                    Some(_) if found.is_empty() => {
                        begin(&mut file, &bytes).map_err(of_file("write", &path))?;
                        (bytes.len() as u64, found)
                    }
                    Some(difference) => return Err(JournalError::OtherRun { path, difference }),
                }
            }
        };
        Ok(Self::of(path, file, end, found))
    }

    /// A journal without calls, in place of whatever the file holds.
    ///
    /// # Errors
    /// If a run that still goes on writes to the file, or it cannot be written.
    pub fn anew(path: &Path, run: &Value) -> Result<Self, JournalError> {
        let file = open_locked(path)?;
        let path = path.to_owned();
        Claim { path, file }.begin(run)
    }

    /// A file for a new journal, which is made: whoever has it may write what belongs to the journal before it begins.
    ///
    /// # Errors
    /// If another run writes to the file, or did so already, or it cannot be written.
    pub fn claim(path: &Path) -> Result<Claim, JournalError> {
        let file = open_locked(path)?;
        let path = path.to_owned();
        match file.metadata() {
            Err(error) => Err(JournalError::of_file("read", &path, &error)),
            Ok(file) if file.len() > 0 => Err(JournalError::InUse { path }),
            Ok(_) => Ok(Claim { path, file }),
        }
    }

    fn of(path: PathBuf, file: File, end: u64, found: HashMap<Call, (u64, u64)>) -> Self {
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
    /// The failure of `advance`, which is not noted: whoever goes on tries again. If the journal cannot be read or
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
        (self.write(call, block)).map_err(|error| self.failed("write", &error))
    }

    /// Whether it has no calls.
    pub fn is_empty(&self) -> bool {
        self.records().found.is_empty()
    }

    /// Whether the journal has what came of a call.
    pub fn has(&self, call: Call) -> bool {
        self.records().found.contains_key(&call)
    }

    /// Takes in the calls of another journal of the same map; returns how many this one did not have.
    ///
    /// # Errors
    /// If one cannot be read, or the other not written.
    pub fn merge(&self, other: &Journal) -> Result<usize, JournalError> {
        let mut found: Vec<(Call, (u64, u64))> = (other.records().found.iter())
            .map(|(&call, &at)| (call, at))
            .collect();
        found.sort_unstable_by_key(|(_, (first, _))| *first);
        let mut new = 0;
        for (call, (first, count)) in found {
            if self.has(call) {
                continue;
            }
            let numbers =
                (other.numbers(first, count)).map_err(|error| other.failed("read", &error))?;
            (self.append(call, &numbers)).map_err(|error| self.failed("write", &error))?;
            new += 1;
        }
        Ok(new)
    }

    /// Writes what is noted through to the disk, and looks whether the file is still there: to be called at the end, as records
    /// are written through about once a second.
    ///
    /// # Errors
    /// If it is not, or cannot be written, or could not be before.
    pub fn finish(&self) -> Result<(), JournalError> {
        if let Some(failure) = self.failure() {
            return Err(failure.clone());
        }
        let synced = self.records().sync(&self.path);
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
        let count = 2 * (block.dof() * block.len()) as u64;
        let found = records.found.get(&call).copied();
        let Some((first, _)) = found.filter(|(_, there)| *there == count) else {
            return Ok(false);
        };
        records.file.seek(SeekFrom::Start(first))?;
        let mut numbers = BufReader::new(&mut records.file);
        let mut bytes = [0; 8];
        for i in 0..2 * block.dof() {
            let row = match i < block.dof() {
                true => block.q.row_mut(i),
                false => block.p.row_mut(i - block.dof()),
            };
            for x in row {
                numbers.read_exact(&mut bytes)?;
                *x = f64::from_bits(u64::from_le_bytes(bytes));
            }
        }
        Ok(true)
    }

    /// So many numbers from a place in the file on.
    fn numbers(&self, first: u64, count: u64) -> io::Result<Vec<f64>> {
        let mut records = self.records();
        records.file.seek(SeekFrom::Start(first))?;
        let mut bytes = vec![0; 8 * count as usize];
        records.file.read_exact(&mut bytes)?;
        let number = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().expect("eight bytes"));
        Ok(bytes.chunks_exact(8).map(number).collect())
    }

    fn write(&self, call: Call, block: &Block<'_>) -> io::Result<()> {
        let rows = |i: usize| match i < block.dof() {
            true => block.q.row(i),
            false => block.p.row(i - block.dof()),
        };
        let numbers: Vec<f64> = (0..2 * block.dof())
            .flat_map(|i| rows(i).iter().copied())
            .collect();
        self.append(call, &numbers)
    }

    /// Adds a record. Where that fails the file ends as it did before.
    fn append(&self, call: Call, numbers: &[f64]) -> io::Result<()> {
        let count = numbers.len() as u64;
        let bytes = record(call, numbers.iter().copied());
        let mut records = self.records();
        let end = records.end;
        let records = &mut *records;
        let mut write = || {
            records.file.seek(SeekFrom::Start(end))?;
            records.file.write_all(&bytes)?;
            match records.synced.elapsed() >= SYNC {
                true => records.sync(&self.path),
                false => Ok(()),
            }
        };
        if let Err(error) = write() {
            // What is left of it is found to be torn, too.
            let _ = records.file.set_len(end);
            return Err(error);
        }
        records.found.insert(call, (end + PREFIX, count));
        records.end += bytes.len() as u64;
        Ok(())
    }

    fn failed(&self, action: &'static str, error: &io::Error) -> JournalError {
        let path = &self.path;
        let replaced = !is_at(&self.records().file, path).unwrap_or(true);
        let of_file = || match path.exists() {
            true if replaced => JournalError::Replaced { path: path.clone() },
            true => JournalError::of_file(action, path, error),
            false => JournalError::Removed { path: path.clone() },
        };
        self.failure.get_or_init(of_file).clone()
    }
}

/// The file, which nobody else may open in this way until it is closed.
fn open_locked(path: &Path) -> Result<File, JournalError> {
    /// Another run may remove the file before it is locked, once at its end.
    const TRIES: usize = 3;
    let mut options = OpenOptions::new();
    options.read(true).write(true).create(true).truncate(false);
    let mut file = options.open(path).map_err(of_file("write", path))?;
    for attempt in 1.. {
        // Some file systems of clusters have no locks.
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            break;
        }
        if attempt == TRIES || is_at(&file, path).unwrap_or(false) {
            return Ok(file);
        }
        file = options.open(path).map_err(of_file("write", path))?;
    }
    let path = path.to_owned();
    Err(JournalError::InUse { path })
}

fn of_file(action: &'static str, path: &Path) -> impl Fn(io::Error) -> JournalError {
    move |error| JournalError::of_file(action, path, &error)
}

/// Writes a header in place of what the file holds.
fn begin(file: &mut File, header: &[u8]) -> io::Result<()> {
    file.set_len(0)?;
    file.rewind()?;
    file.write_all(header)?;
    file.sync_data()
}

/// Whether a path leads to this file, and not to another that was put in its place.
fn is_at(file: &File, path: &Path) -> io::Result<bool> {
    let (there, here) = (path.metadata()?, file.metadata()?);
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        Ok((there.dev(), there.ino()) == (here.dev(), here.ino()))
    }
    // A file that is open cannot be replaced elsewhere.
    #[cfg(not(unix))]
    Ok(there.len() == here.len())
}

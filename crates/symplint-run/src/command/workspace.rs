//! The folder with the files of all calls: temporary, or kept.
//!
//! A temporary folder holds a file `lock`, locked as long as its program runs. The system releases the lock however the
//! program ends, so the next run can remove what a killed one left behind, and never touches the folder of a run
//! that is still running.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use super::CallsError;
use super::stop::{register_folder, remove_folder};

/// How the names of temporary folders begin.
const PREFIX: &str = "symplint-command-";

const LOCK: &str = "lock";

/// How the names of the folders of calls begin.
const OF_CALL: &str = "call-";

/// The folder of the files of calls.
pub struct Workspace {
    /// The folder for files that are kept, and the number of the last call that it has from before.
    kept: Option<(PathBuf, usize)>,
    /// Made for the first call.
    temporary: Mutex<Option<Temporary>>,
    calls: AtomicUsize,
}

struct Temporary {
    folder: PathBuf,
    /// Locked until it is closed.
    _lock: File,
}

/// The folder of one call.
pub struct CallFolder {
    path: PathBuf,
    kept: bool,
}

impl Workspace {
    /// In the temporary folder of the system, removed at the end.
    pub fn temporary() -> Self {
        Workspace {
            kept: None,
            temporary: Mutex::new(None),
            calls: AtomicUsize::new(0),
        }
    }

    /// In a folder that stays, after `calls` calls in it.
    pub fn kept(path: PathBuf, calls: usize) -> Self {
        let mut workspace = Self::temporary();
        workspace.kept = Some((path, calls));
        workspace.calls = AtomicUsize::new(calls);
        workspace
    }

    /// The folder that stays, if it holds calls from before.
    pub fn of_earlier_calls(&self) -> Option<&Path> {
        let (path, calls) = self.kept.as_ref()?;
        (*calls > 0).then_some(path)
    }

    /// A new folder for a call.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn folder_of_call(&self) -> Result<CallFolder, CallsError> {
        let refused = |folder: &Path, error: io::Error| {
            CallsError::system(&format!("write {}", folder.display()), &error)
        };
        let (root, kept) = match &self.kept {
            Some((path, _)) => {
                fs::create_dir_all(path).map_err(|error| refused(path, error))?;
                (path.clone(), true)
            }
            None => {
                let root = self.temporary_root();
                let root = root.map_err(|error| refused(&std::env::temp_dir(), error))?;
                (root, false)
            }
        };
        loop {
            let number = self.calls.fetch_add(1, Ordering::Relaxed) + 1;
            let path = root.join(name_of_call(number));
            match fs::create_dir(&path) {
                Ok(()) => return Ok(CallFolder { path, kept }),
                // Jobs of the same run keep their calls in one folder.
                Err(error) if kept && error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(CallsError::of_file(&path, &error)),
            }
        }
    }

    fn temporary_root(&self) -> io::Result<PathBuf> {
        let mut temporary = self
            .temporary
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(made) = &*temporary {
            return Ok(made.folder.clone());
        }
        remove_stale(&std::env::temp_dir());
        let made = make_temporary()?;
        let folder = made.folder.clone();
        *temporary = Some(made);
        Ok(folder)
    }
}

impl Drop for Workspace {
    fn drop(&mut self) {
        let temporary = self
            .temporary
            .get_mut()
            .unwrap_or_else(PoisonError::into_inner);
        if let Some(Temporary { folder, .. }) = temporary.take() {
            remove_folder(&folder);
        }
    }
}

fn make_temporary() -> io::Result<Temporary> {
    let folder = tempfile::Builder::new().prefix(PREFIX).tempdir()?.keep();
    register_folder(&folder);
    let lock = || {
        // Locked before it has its name: a `lock` that is not locked belongs to a program that has ended.
        let unnamed = folder.join("unnamed");
        let lock = File::create(&unnamed)?;
        // If the file system has no locks, another run cannot lock it either, and nothing is removed.
        let _ = lock.try_lock();
        fs::rename(unnamed, folder.join(LOCK))?;
        Ok(lock)
    };
    match lock() {
        Ok(lock) => Ok(Temporary {
            folder,
            _lock: lock,
        }),
        Err(error) => {
            remove_folder(&folder);
            Err(error)
        }
    }
}

/// Removes what programs that were killed left behind. What cannot be removed stays: it may be another user's.
fn remove_stale(temporary: &Path) {
    let Ok(entries) = fs::read_dir(temporary) else {
        return;
    };
    for entry in entries.flatten() {
        let is_ours = entry.file_name().to_string_lossy().starts_with(PREFIX);
        // Not through a link.
        if !is_ours || !entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            continue;
        }
        let lock = File::options().write(true).open(entry.path().join(LOCK));
        if let Ok(lock) = lock
            && lock.try_lock().is_ok()
        {
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

fn name_of_call(number: usize) -> String {
    format!("{OF_CALL}{number:06}")
}

/// The largest number of a call that a folder keeps, 0 where it is not there; nothing if it holds anything but calls.
pub fn kept_before(path: &Path) -> Option<usize> {
    let entries = match fs::read_dir(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Some(0),
        entries => entries.ok()?,
    };
    let mut last = 0;
    for entry in entries {
        let name = entry.ok()?.file_name();
        let number: usize = name.to_str()?.strip_prefix(OF_CALL)?.parse().ok()?;
        last = last.max(number);
    }
    Some(last)
}

impl CallFolder {
    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for CallFolder {
    fn drop(&mut self) {
        if !self.kept {
            let _ = fs::remove_dir_all(&self.path);
        }
    }
}

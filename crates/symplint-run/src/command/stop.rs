//! An end of this program by a signal: processes that it calls are in their own groups, so Ctrl-C on a terminal does not reach them.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

static STOPPED: AtomicBool = AtomicBool::new(false);
static CALLS: AtomicUsize = AtomicUsize::new(0);
static FOLDERS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// The longest time that calls have to end their processes.
const TO_END: Duration = Duration::from_secs(2);

/// The time that results of processes that had ended have to get into the journal.
const TO_NOTE: Duration = Duration::from_millis(100);

/// Kills all commands that run, with the processes that they started, and removes all temporary folders.
///
/// For programs that are about to end by a signal: a thread that starts a command, or whose command failed, waits for ever from then
/// on, so that no failure is reported. Results of commands that had ended can still get into the journal.
pub fn stop_all() {
    STOPPED.store(true, Ordering::SeqCst);
    let started = Instant::now();
    if CALLS.load(Ordering::SeqCst) > 0 {
        while CALLS.load(Ordering::SeqCst) > 0 && started.elapsed() < TO_END {
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(TO_NOTE);
    }
    let folders = FOLDERS.lock().unwrap_or_else(PoisonError::into_inner);
    folders.iter().for_each(|folder| remove(folder));
}

/// Whether [`stop_all`] was called.
pub fn is_stopped() -> bool {
    STOPPED.load(Ordering::SeqCst)
}

/// A call, whose process [`stop_all`] waits for.
pub struct RunningCall(());

impl RunningCall {
    /// Begins a call. Waits for ever after [`stop_all`].
    pub fn begin() -> Self {
        CALLS.fetch_add(1, Ordering::SeqCst);
        let call = RunningCall(());
        match is_stopped() {
            true => call.wait_for_ever(),
            false => call,
        }
    }

    /// Ends a call that [`stop_all`] stopped.
    pub fn wait_for_ever(self) -> ! {
        drop(self);
        loop {
            std::thread::park();
        }
    }
}

impl Drop for RunningCall {
    fn drop(&mut self) {
        CALLS.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Lists a folder that [`stop_all`] removes.
pub fn register_folder(path: &Path) {
    let mut folders = FOLDERS.lock().unwrap_or_else(PoisonError::into_inner);
    folders.push(path.to_owned());
}

/// Removes a folder that was registered.
pub fn remove_folder(path: &Path) {
    remove(path);
    let mut folders = FOLDERS.lock().unwrap_or_else(PoisonError::into_inner);
    folders.retain(|folder| folder != path);
}

/// Removes a folder and all that is in it. Processes that were killed may write for some more time.
fn remove(folder: &Path) {
    const TRIES: usize = 50;
    for _ in 0..TRIES {
        match std::fs::remove_dir_all(folder) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                std::thread::sleep(Duration::from_millis(10));
            }
            _ => return,
        }
    }
}

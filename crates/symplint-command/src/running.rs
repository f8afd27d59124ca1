//! All processes and temporary folders of this program, so that a signal can end and remove them.
//!
//! Processes are in groups of their own, so Ctrl-C on a terminal does not reach them.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::process::kill_group;

struct Registry {
    /// Whether no more is to begin.
    stopped: bool,
    next: usize,
    processes: BTreeMap<usize, Arc<Mutex<Child>>>,
    folders: Vec<PathBuf>,
}

static REGISTRY: Mutex<Registry> = Mutex::new(Registry {
    stopped: false,
    next: 0,
    processes: BTreeMap::new(),
    folders: Vec::new(),
});

fn registry() -> MutexGuard<'static, Registry> {
    REGISTRY.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Kills all commands that run, with what they started, and removes all temporary folders.
///
/// For programs that are about to end by a signal: what starts a command, or finds that one failed, waits for ever from then on,
/// so that no failure is reported. What came of commands that had ended well can still be noted.
pub fn stop_all() {
    let mut registry = registry();
    registry.stopped = true;
    for process in registry.processes.values() {
        kill_group(&mut process.lock().unwrap_or_else(PoisonError::into_inner));
    }
    let folders = registry.folders.clone();
    let called_any = registry.next > 0;
    drop(registry);
    if called_any {
        std::thread::sleep(TO_NOTE);
    }
    for folder in &folders {
        remove(folder);
    }
}

/// How long results of commands that had ended are waited for.
const TO_NOTE: Duration = Duration::from_millis(100);

/// The registry, which whoever begins something after [`stop_all`] never gets.
fn registry_to_begin() -> MutexGuard<'static, Registry> {
    loop {
        wait_if_stopped();
        let registry = registry();
        // Between the two it may have come.
        if !registry.stopped {
            return registry;
        }
    }
}

/// Waits for ever after [`stop_all`].
pub fn wait_if_stopped() {
    while registry().stopped {
        std::thread::park();
    }
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

/// A process that [`stop_all`] ends.
pub struct Running {
    key: usize,
    process: Arc<Mutex<Child>>,
}

impl Running {
    /// Starts a process.
    ///
    /// # Errors
    /// If it cannot be started.
    pub fn spawn(command: &mut Command) -> io::Result<Self> {
        let mut registry = registry_to_begin();
        // With the registry locked: a process is listed before it can be missed.
        let process = Arc::new(Mutex::new(command.spawn()?));
        let key = registry.next;
        registry.next += 1;
        registry.processes.insert(key, Arc::clone(&process));
        Ok(Running { key, process })
    }

    /// The process.
    pub fn process(&self) -> MutexGuard<'_, Child> {
        self.process.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        registry().processes.remove(&self.key);
    }
}

/// Makes a folder by `make`, which [`stop_all`] removes.
///
/// # Errors
/// Those of `make`.
pub fn register_folder<T>(
    make: impl FnOnce() -> io::Result<T>,
    path: impl Fn(&T) -> &Path,
) -> io::Result<T> {
    let mut registry = registry_to_begin();
    let made = make()?;
    registry.folders.push(path(&made).to_owned());
    Ok(made)
}

/// Removes a folder that was registered.
pub fn remove_folder(path: &Path) {
    remove(path);
    registry().folders.retain(|folder| folder != path);
}

//! The map: blocks of samples cut into calls, some of them at a time.

use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use symplint::{Block, Coordinates, Ensemble, StepFailure, TimeAdvance};
use symplint_journal::Journal;

use crate::CommandError;
use crate::call::{Call, Program};
use crate::workspace::{Workspace, is_empty};

/// What calls may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// The longest time of one call.
    pub timeout: Duration,
    /// Calls at a time.
    pub workers: NonZero<usize>,
    /// Samples in one file at most.
    pub batch: NonZero<usize>,
}

/// A program as a map.
///
/// Every argument may contain `{before}`, `{after}` and `{h}`: the file to read, the file to write, and the step size. What
/// happens to a sample depends neither on the number of calls at a time nor on that of threads.
pub struct CommandMap {
    program: Program,
    coordinates: Coordinates,
    limits: Limits,
    workspace: Workspace,
    slots: Slots,
    journal: OnceLock<Arc<Journal>>,
}

impl CommandMap {
    /// The map that `command` is: a program and its arguments, run in `folder`.
    ///
    /// # Errors
    /// If there is no program, or no argument names the files.
    pub fn new(
        command: Vec<String>,
        folder: &Path,
        coordinates: Coordinates,
        limits: Limits,
    ) -> Result<Self, CommandError> {
        if command.is_empty() {
            return Err(CommandError::Empty);
        }
        for (placeholder, what) in [("{before}", "input"), ("{after}", "output")] {
            if !command[1..].iter().any(|word| word.contains(placeholder)) {
                return Err(CommandError::NoPlaceholder { placeholder, what });
            }
        }
        Ok(CommandMap {
            program: Program {
                command,
                folder: folder.to_owned(),
            },
            coordinates,
            slots: Slots::new(limits.workers.get()),
            limits,
            workspace: Workspace::temporary(),
            journal: OnceLock::new(),
        })
    }

    /// The same, with the files of all calls kept in a new or empty folder.
    ///
    /// # Errors
    /// If the folder holds anything.
    pub fn keeping(mut self, path: PathBuf) -> Result<Self, CommandError> {
        if !is_empty(&path) {
            return Err(CommandError::Occupied { path });
        }
        self.workspace = Workspace::kept(path);
        Ok(self)
    }

    /// Notes all calls from now on in a journal, and makes none that it has already. One journal at most.
    pub fn keep_journal(&self, journal: Arc<Journal>) {
        let given = self.journal.set(journal);
        assert!(given.is_ok(), "a map has one journal");
    }

    /// The files that the command names before its first `{before}`, `{after}` or `{h}`, with their paths: the program, and the
    /// script that an interpreter runs. Files named later may be data that calls write.
    pub fn program_files(&self) -> Vec<(&str, PathBuf)> {
        let words = self.program.command.iter();
        let words = words.take_while(|word| !word.contains('{'));
        let files = words.map(|word| (&**word, self.program.folder.join(word)));
        files.filter(|(_, path)| path.is_file()).collect()
    }

    /// Advances the samples of one call.
    fn call(&self, h: f64, mut states: Ensemble) -> Result<Ensemble, StepFailure> {
        let Some(journal) = self.journal.get() else {
            return self.run(h, states);
        };
        journal.advance(h, &mut states.block(), |block| {
            let after = self.run(h, block.copy_of(0..block.len()))?;
            put_back(block, 0, &after);
            Ok::<(), StepFailure>(())
        })?;
        Ok(states)
    }

    /// Runs the program once.
    fn run(&self, h: f64, states: Ensemble) -> Result<Ensemble, StepFailure> {
        let call = Call {
            program: &self.program,
            coordinates: &self.coordinates,
            timeout: self.limits.timeout,
            h,
        };
        let _slot = self.slots.take();
        call.advance(&self.workspace, states)
    }
}

impl TimeAdvance for CommandMap {
    fn dof(&self) -> usize {
        self.coordinates.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        let batch = self.limits.batch.get();
        let firsts: Vec<usize> = (0..block.len()).step_by(batch).collect();
        let parts: Vec<Ensemble> = (firsts.iter())
            .map(|&first| block.copy_of(first..block.len().min(first + batch)))
            .collect();
        // Parts are taken in their order, and none after a failure: the first failure is the same however many are
        // advanced at a time, and a program that hangs is not waited for once more for each part.
        let results: Vec<Mutex<Option<Result<Ensemble, StepFailure>>>> =
            parts.iter().map(|_| Mutex::new(None)).collect();
        let (next, failed) = (AtomicUsize::new(0), AtomicBool::new(false));
        let work = || {
            while !failed.load(Ordering::Relaxed) {
                let k = next.fetch_add(1, Ordering::Relaxed);
                let Some(states) = parts.get(k) else {
                    return;
                };
                let result = self.call(h, states.clone());
                if result.is_err() {
                    failed.store(true, Ordering::Relaxed);
                }
                *results[k].lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
            }
        };
        match self.limits.workers.get().min(parts.len()) {
            0 | 1 => work(),
            workers => std::thread::scope(|scope| {
                for _ in 0..workers {
                    scope.spawn(work);
                }
            }),
        }
        for (first, result) in firsts.into_iter().zip(results) {
            match result.into_inner().unwrap_or_else(PoisonError::into_inner) {
                Some(Ok(states)) => put_back(block, first, &states),
                Some(Err(failure)) => {
                    return Err(StepFailure {
                        sample: first + failure.sample,
                        ..failure
                    });
                }
                // Only parts after a failure were not taken.
                None => {}
            }
        }
        Ok(())
    }

    fn coordinates(&self) -> Coordinates {
        self.coordinates.clone()
    }

    fn is_stopped(&self) -> bool {
        // Calls that cannot be noted would be lost.
        (self.journal.get()).is_some_and(|journal| journal.failure().is_some())
    }
}

fn put_back(block: &mut Block<'_>, first: usize, states: &Ensemble) {
    let range = first..first + states.samples();
    for i in 0..states.dof() {
        block.q.row_mut(i)[range.clone()].copy_from_slice(states.q().row(i));
        block.p.row_mut(i)[range.clone()].copy_from_slice(states.p().row(i));
    }
}

/// So many calls at a time, whatever the number of threads that ask for one.
struct Slots {
    free: Mutex<usize>,
    freed: Condvar,
}

/// The right to make a call.
struct Slot<'a>(&'a Slots);

impl Slots {
    fn new(count: usize) -> Self {
        Slots {
            free: Mutex::new(count),
            freed: Condvar::new(),
        }
    }

    /// Waits until fewer calls are under way.
    fn take(&self) -> Slot<'_> {
        let free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let mut free = (self.freed.wait_while(free, |free| *free == 0))
            .unwrap_or_else(PoisonError::into_inner);
        *free -= 1;
        Slot(self)
    }
}

impl Drop for Slot<'_> {
    fn drop(&mut self) {
        *(self.0.free.lock()).unwrap_or_else(PoisonError::into_inner) += 1;
        self.0.freed.notify_one();
    }
}

//! The map: blocks of samples cut into calls, some of them at a time.

use std::collections::HashMap;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use symplint::map::Prefetch;
use symplint::{Block, Coordinates, Ensemble, StepFailure, TimeAdvance};
use symplint_journal::{Call as JournalCall, Journal, Request};

use crate::call::{Call, Program};
use crate::known_files::KnownFile;
use crate::lack::CallFailure;
use crate::names::names;
use crate::planned::Planned;
use crate::running::wait_if_stopped;
use crate::search::found_in_path;
use crate::workspace::{Workspace, kept_before};
use crate::{CallsError, CommandError};

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
    planned: OnceLock<Planned>,
    known: OnceLock<Vec<KnownFile>>,
    failure: OnceLock<CallsError>,
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
            planned: OnceLock::new(),
            known: OnceLock::new(),
            failure: OnceLock::new(),
        })
    }

    /// The same, with the files of all calls kept in a folder, which is new or empty, or holds those of earlier calls: then the
    /// numbers of calls go on.
    ///
    /// # Errors
    /// If the folder holds anything else.
    pub fn keeping(mut self, path: PathBuf) -> Result<Self, CommandError> {
        self.workspace = match kept_before(&path) {
            Some(calls) => Workspace::kept(path, calls),
            None => return Err(CommandError::Occupied { path }),
        };
        Ok(self)
    }

    /// Refuses a folder that keeps the files of earlier calls: where it is not their run that goes on.
    ///
    /// # Errors
    /// If there are any.
    pub fn check_keeps_no_earlier_calls(&self) -> Result<(), CommandError> {
        match self.workspace.of_earlier_calls() {
            Some(path) => Err(CommandError::Occupied {
                path: path.to_owned(),
            }),
            None => Ok(()),
        }
    }

    /// Notes all calls from now on in a journal, and makes none that it has already. One journal at most.
    pub fn keep_journal(&self, journal: Arc<Journal>) {
        let given = self.journal.set(journal);
        assert!(given.is_ok(), "a map has one journal");
    }

    /// Makes no calls from now on: those that the journal has are replayed, those in `failed` fail, and all others are
    /// [`missing`](Self::missing), which ends the diagnosis.
    pub fn plan_only(&self, journal: Arc<Journal>, failed: HashMap<JournalCall, StepFailure>) {
        let given = self.planned.set(Planned::new(journal, failed));
        assert!(given.is_ok(), "a map is planned once");
    }

    /// The calls that were asked for and not made, each once.
    pub fn missing(&self) -> Vec<Request> {
        self.planned.get().map_or(Vec::new(), Planned::missing)
    }

    /// Makes calls, some at a time, and notes them in a journal; none that it has already. `made` is told of each.
    ///
    /// # Errors
    /// If the journal cannot be read or written, a call could not be made, or the program is not what it
    /// [was](Self::know_program). Calls that fail are no error.
    pub fn make(
        &self,
        requests: &[&Request],
        journal: &Journal,
        made: &(dyn Fn(&Request, Result<(), StepFailure>) + Sync),
    ) -> Result<(), CallsError> {
        let each = |k: usize| {
            let request = requests[k];
            let mut states = request.states.clone();
            if journal.has(request.call) {
                made(request, Ok(()));
                return Ok(());
            }
            match self.run(request.h, states) {
                Err(failure) => match self.failure() {
                    Some(error) => return Err(error.clone()),
                    None => made(request, Err(failure)),
                },
                Ok(after) => {
                    states = after;
                    journal.note(request.call, &states.block())?;
                    made(request, Ok(()));
                }
            }
            Ok(())
        };
        self.in_order(requests.len(), each)
            .into_iter()
            .flatten()
            .collect()
    }

    /// What the program is known by: the files that the command names before its first `{before}`, with the SHA-256 of their
    /// contents. Where one of them changes or comes to be from now on, no call is made or noted any more, and
    /// [`failure`](Self::failure) names it.
    ///
    /// # Errors
    /// If one cannot be read.
    pub fn know_program(&self) -> Result<Vec<(&str, &str)>, CallsError> {
        let files = self.program_files().into_iter();
        let files = files.map(|(word, path)| KnownFile::read(word, path));
        let files = files.collect::<Result<Vec<_>, _>>()?;
        let known = self.known.get_or_init(|| files);
        Ok((known.iter())
            .map(|file| (&*file.word, &*file.sha256))
            .collect())
    }

    /// Why calls are not made, or are not those of the run any more, if that is so: no failure of the map.
    pub fn failure(&self) -> Option<&CallsError> {
        self.failure.get()
    }

    /// Checks that the program is what it was when it was hashed, if it was.
    fn check_program(&self) -> Result<(), StepFailure> {
        self.find_changes().map_err(|error| self.stopped(error))
    }

    fn find_changes(&self) -> Result<(), CallsError> {
        let Some(known) = self.known.get() else {
            return Ok(());
        };
        let changed = |path: &Path| CallsError::Changed {
            path: path.to_owned(),
        };
        for file in known {
            if file.changed()? {
                return Err(changed(&file.path));
            }
        }
        // Looked for again: another program may have come before it in `PATH`.
        let now = self.program_files();
        let then = known.iter().map(|file| (&*file.word, file.path.clone()));
        let then: Vec<(&str, PathBuf)> = then.collect();
        let gone = then.iter().find(|file| !now.contains(file));
        // A file that came to be would be missed when the run goes on: calls make it.
        let new = || now.iter().find(|file| !then.contains(file));
        match gone.or_else(new) {
            Some((_, path)) => Err(changed(path)),
            None => Ok(()),
        }
    }

    /// Takes note of why the run ends, which is no failure of the map.
    fn stopped(&self, error: CallsError) -> StepFailure {
        StepFailure {
            sample: 0,
            reason: self.failure.get_or_init(|| error).to_string(),
        }
    }

    /// The files that the command [names](crate::names) before its first `{before}`, with their paths: the program, which is looked
    /// for in `PATH` as the system does, the script that an interpreter runs, and what these are given to read. Files named later may
    /// be data that calls write.
    fn program_files(&self) -> Vec<(&str, PathBuf)> {
        let Program { command, folder } = &self.program;
        let program = found_in_path(&command[0], folder).map(|path| (&*command[0], path));
        let others = names(command).into_iter();
        let others = others.map(|name| (name, folder.join(name)));
        let files = program.into_iter().chain(others);
        // What these folders hold is of this process or of the system.
        let is_of_system = |path: &Path| path.starts_with("/dev") || path.starts_with("/proc");
        let files = files.filter(|(_, path)| !is_of_system(path) && path.is_file());
        files.collect()
    }

    /// Advances the samples of one call.
    fn call(&self, h: f64, mut states: Ensemble) -> Result<Ensemble, StepFailure> {
        if let Some(planned) = self.planned.get() {
            return planned.advance(h, states);
        }
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

    /// The states of each call, and the first sample of it.
    fn parts(&self, block: &Block<'_>) -> impl Iterator<Item = (usize, Ensemble)> {
        let (batch, samples) = (self.limits.batch.get(), block.len());
        let firsts = (0..samples).step_by(batch);
        firsts.map(move |first| (first, block.copy_of(first..samples.min(first + batch))))
    }

    /// Does some things at a time. They are begun in their order, and none after a failure: the first failure is the same however
    /// many are done at a time, and a program that hangs is not waited for once more for each. Nothing stands for what was not begun.
    fn in_order<T: Send, E: Send>(
        &self,
        count: usize,
        each: impl Fn(usize) -> Result<T, E> + Sync,
    ) -> Vec<Option<Result<T, E>>> {
        let results: Vec<Mutex<Option<Result<T, E>>>> =
            (0..count).map(|_| Mutex::new(None)).collect();
        let (next, failed) = (AtomicUsize::new(0), AtomicBool::new(false));
        let work = || {
            while !failed.load(Ordering::Relaxed) {
                let k = next.fetch_add(1, Ordering::Relaxed);
                if k >= count {
                    return;
                }
                let result = each(k);
                if result.is_err() {
                    failed.store(true, Ordering::Relaxed);
                }
                *results[k].lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
            }
        };
        match self.limits.workers.get().min(count) {
            0 | 1 => work(),
            workers => std::thread::scope(|scope| {
                for _ in 0..workers {
                    scope.spawn(work);
                }
            }),
        }
        let taken = |result: Mutex<_>| result.into_inner().unwrap_or_else(PoisonError::into_inner);
        results.into_iter().map(taken).collect()
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
        self.check_program()?;
        // Where a signal ended the program, or removed its files, it did not fail.
        let after = (call.advance(&self.workspace, states)).inspect_err(|_| wait_if_stopped());
        // It may have changed since, and a call may have failed for that.
        self.check_program()?;
        after.map_err(|failure| match failure {
            CallFailure::Program(failure) => failure,
            CallFailure::Lack(lack) => self.stopped(lack.into()),
        })
    }
}

impl TimeAdvance for CommandMap {
    fn dof(&self) -> usize {
        self.coordinates.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        let parts: Vec<(usize, Ensemble)> = self.parts(block).collect();
        let each = |k: usize| self.call(h, parts[k].1.clone());
        let results = match self.planned.get() {
            // All that are missing are to be known.
            Some(_) => (0..parts.len()).map(|k| Some(each(k))).collect(),
            None => self.in_order(parts.len(), each),
        };
        for ((first, _), result) in parts.iter().zip(results) {
            match result {
                Some(Ok(states)) => put_back(block, *first, &states),
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
        let lost = (self.journal.get()).is_some_and(|journal| journal.failure().is_some());
        lost || self.failure().is_some() || self.planned.get().is_some_and(Planned::lacks_calls)
    }

    fn prefetch(&self) -> Option<&dyn Prefetch> {
        self.planned.get().map(|_| self as &dyn Prefetch)
    }
}

impl Prefetch for CommandMap {
    fn begin(&self, h: f64, block: &Block<'_>) {
        if let Some(planned) = self.planned.get() {
            (self.parts(block)).for_each(|(_, states)| planned.begin(h, states));
        }
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

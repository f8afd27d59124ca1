//! Programs as maps: blocks of samples are cut into calls, some of them at a time. For each call the map writes `before.npz` (arrays `q`
//! and `p` of shape (samples, dof), `h`, `period`, `weight`), runs the program, and reads `after.npz`.

mod call;
mod error;
mod planned;
mod process;
mod program_file;
mod stop;
mod workspace;

use std::collections::HashMap;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use symplint::map::{Capabilities, Prefetch};
use symplint::{Block, Coordinates, Ensemble, StepFailure, TimeAdvance};

pub use call::FileFormat;
pub use error::{CallsError, CommandError};
pub use stop::stop_all;

use crate::journal::{Call as JournalCall, Journal, Request};
use call::{Call, CallFailure, Program};
use planned::PlannedCalls;
use program_file::ProgramFile;
use stop::{RunningCall, is_stopped};
use workspace::{Workspace, kept_before};

/// Limits of calls.
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
    planned: OnceLock<PlannedCalls>,
    /// Names of files that identify the program besides its own.
    files: Vec<String>,
    hashed: OnceLock<Vec<ProgramFile>>,
    failure: OnceLock<CallsError>,
}

impl CommandMap {
    /// The map that `command` is: a program and its arguments, run in `folder`.
    ///
    /// # Errors
    /// If the program is missing, or no argument names the files.
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
                format: FileFormat::default(),
            },
            coordinates,
            slots: Slots::new(limits.workers.get()),
            limits,
            workspace: Workspace::temporary(),
            journal: OnceLock::new(),
            planned: OnceLock::new(),
            files: Vec::new(),
            hashed: OnceLock::new(),
            failure: OnceLock::new(),
        })
    }

    /// The same program, which reads and writes files of this format.
    pub fn with_format(mut self, format: FileFormat) -> Self {
        self.program.format = format;
        self
    }

    /// The same program, identified also by the contents of these files, in the folder in which it runs.
    pub fn identified_by(mut self, files: Vec<String>) -> Self {
        self.files = files;
        self
    }

    /// The same, with the files of all calls kept in a folder, which is new or empty, or holds the files of earlier calls, whose numbers
    /// continue.
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

    /// Refuses a folder that keeps the files of earlier calls, for a run that is not resumed.
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
        let given = self.planned.set(PlannedCalls::new(journal, failed));
        assert!(given.is_ok(), "a map is planned once");
    }

    /// The calls that were asked for and not made, each once.
    pub fn missing(&self) -> Vec<Request> {
        self.planned.get().map_or(Vec::new(), PlannedCalls::missing)
    }

    /// Makes calls, some at a time, and notes their results in a journal; `made` is called after each. Returns the calls that
    /// failed, and why the others were not made, if they were not: the journal cannot be written, a call could not be made, or the
    /// program is not the one that was [identified](Self::identity).
    pub fn make<'a>(
        &self,
        requests: &[&'a Request],
        journal: &Journal,
        made: &(dyn Fn() + Sync),
    ) -> (Vec<(&'a Request, StepFailure)>, Result<(), CallsError>) {
        let each = |k: usize| {
            let request: &Request = requests[k];
            let failed = match self.run(request.h, request.states.clone()) {
                Ok(mut after) => {
                    journal.note(request.call, &after.block())?;
                    None
                }
                Err(failure) => match self.failure() {
                    Some(error) => return Err(error.clone()),
                    None => Some(failure),
                },
            };
            made();
            Ok(failed)
        };
        let (mut failed, mut ended) = (Vec::new(), Ok(()));
        let results = self.in_order(requests.len(), each).into_iter();
        for (request, result) in requests.iter().zip(results.flatten()) {
            match result {
                Ok(failure) => failed.extend(failure.map(|failure| (*request, failure))),
                Err(error) => ended = ended.and(Err(error)),
            }
        }
        (failed, ended)
    }

    /// The identity of the program: the names of its file, which is searched in `PATH`, and of the files that
    /// [identify it](Self::identified_by), with the SHA-256 of their contents. If one of them changes from now on, no call is made or
    /// noted any more, and [`failure`](Self::failure) names it.
    ///
    /// # Errors
    /// If one cannot be read.
    pub fn identity(&self) -> Result<Vec<(&str, &str)>, CallsError> {
        let Program {
            command, folder, ..
        } = &self.program;
        let paths = std::env::var_os("PATH");
        // A program that is not there is reported by its first call.
        let program = which::which_in(&command[0], paths, folder).ok();
        let program = program.map(|path| (&*command[0], path));
        let others = self.files.iter().map(|name| (&**name, folder.join(name)));
        let files = program.into_iter().chain(others);
        let files = files.map(|(name, path)| ProgramFile::read(name, path));
        let files = files.collect::<Result<Vec<_>, _>>()?;
        let hashed = self.hashed.get_or_init(|| files).iter();
        Ok(hashed.map(|file| (&*file.name, &*file.sha256)).collect())
    }

    /// Why the calls of the run end, if they do: no failure of the map.
    pub fn failure(&self) -> Option<&CallsError> {
        self.failure.get()
    }

    /// Stores why the calls of the run end.
    fn stopped(&self, error: CallsError) -> StepFailure {
        StepFailure {
            sample: 0,
            reason: self.failure.get_or_init(|| error).to_string(),
        }
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

    /// Does some things at a time. They begin in their order, and none after a failure: the first failure is the same for any number of
    /// workers, and a program that hangs is waited for once. Skipped things are `None`.
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
        let under_way = RunningCall::begin();
        let after = call.advance(&self.workspace, states);
        if after.is_err() && is_stopped() {
            // The signal ended the program, or removed its files: it did not fail.
            under_way.wait_for_ever();
        }
        // The result, or the failure, may come from a changed program.
        let mut hashed = self.hashed.get().into_iter().flatten();
        (hashed.try_for_each(ProgramFile::check_same)).map_err(|error| self.stopped(error))?;
        after.map_err(|failure| match failure {
            CallFailure::Program(failure) => failure,
            CallFailure::Calls(error) => self.stopped(error),
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
            // Jobs make all that are missing.
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

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            prefetch: self.planned.get().map(|_| self as &dyn Prefetch),
            is_stopped: Some(Box::new(|| {
                // Calls that cannot be noted would be lost.
                let lost = (self.journal.get()).is_some_and(|journal| journal.failure().is_some());
                let lacks_calls = self.planned.get().is_some_and(PlannedCalls::lacks_calls);
                lost || self.failure().is_some() || lacks_calls
            })),
            ..Capabilities::of_coordinates(self.coordinates.clone())
        }
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

/// The calls at a time, whatever the number of threads that ask for one.
struct Slots {
    taken: SyncSender<()>,
    free: Mutex<Receiver<()>>,
}

/// The right to make a call.
struct Slot<'a>(&'a Slots);

impl Slots {
    fn new(count: usize) -> Self {
        let (taken, free) = sync_channel(count);
        let free = Mutex::new(free);
        Slots { taken, free }
    }

    /// Waits until fewer calls are under way.
    fn take(&self) -> Slot<'_> {
        self.taken.send(()).expect("the slots have the receiver");
        Slot(self)
    }
}

impl Drop for Slot<'_> {
    fn drop(&mut self) {
        let free = self.0.free.lock().unwrap_or_else(PoisonError::into_inner);
        let _ = free.recv();
    }
}

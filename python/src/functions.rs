//! The functions of the user, called on the thread that started the diagnosis.

use std::collections::HashMap;
use std::sync::Arc;

use numpy::PyArray1;
use pyo3::prelude::*;
use symplint::error::Dependence;
use symplint::{Block, Error, StepFailure};
use symplint_run::Journal;

use crate::arrays::{pair, read_rows};
use crate::block_call::{BlockCall, Failed, for_each_batch};
use crate::calls::{Answer, Call, ends_programs};
use crate::error::{diagnostic_error, input_error, step_error};
use crate::memory::{Loan, Memory};
use crate::progress::Line;
use crate::workers::Workers;

/// Exceptions that are kept to be the cause of an error of the diagnostic, at most: one for each step size and text, so more
/// than there are step sizes in any sweep.
const KEPT: usize = 256;

/// Advice if states of one batch may influence each other.
const ALONE: &str = "; sums and means over degrees of freedom need axis=1, as rows are states; if the step chooses its substeps or \
                     iterations for all rows of a batch together, write it for one state and give per_sample=True";

/// A step as the user gives it.
pub struct Step {
    /// The function, or one that makes it for a step size.
    pub function: Py<PyAny>,
    /// Whether it advances one state at a time.
    pub per_sample: bool,
    /// Whether `function(h)` makes the step for h.
    pub make: bool,
    /// Called before every call of the function.
    pub reset: Option<Py<PyAny>>,
    /// Whether its arrays are of single precision.
    pub single: bool,
    /// States and tangent vectors after a step, from those before it, if its derivatives are known.
    pub tangents: Option<Py<PyAny>>,
    /// Its parts, if it has any.
    pub parts: Vec<Py<PyAny>>,
}

impl Step {
    /// The call of one of its functions, with its reset.
    fn call<'py>(
        &self,
        function: Bound<'py, PyAny>,
        h: Option<f64>,
        what: &'static str,
    ) -> BlockCall<'py> {
        let py = function.py();
        BlockCall {
            function,
            h,
            reset: (self.reset.as_ref()).map(|reset| reset.bind(py).clone()),
            what,
        }
    }
}

/// All functions of the user.
pub struct Functions {
    pub step: Option<Step>,
    pub project: Option<Py<PyAny>>,
    /// Writes the energy of states into their first coordinates.
    pub energy: Option<Py<PyAny>>,
    /// Reverses states in time.
    pub reversal: Option<Py<PyAny>>,
    pub phase_loop: Option<Py<PyAny>>,
    pub progress: Option<Py<PyAny>>,
    /// The journal of the states that the step makes, if there is one.
    pub journal: Option<Arc<Journal>>,
    /// Who takes the steps, if not this process.
    pub workers: Option<Workers>,
    /// Steps made for a step size, by its bits.
    made: HashMap<u64, Py<PyAny>>,
    memory: Option<Py<Memory>>,
    raised: Vec<Raised>,
    planned: usize,
    measured: usize,
}

/// Which function it is.
#[derive(Clone, Copy, PartialEq)]
enum Of {
    /// The step of this size.
    Step(f64),
    Project,
    Loop,
}

impl Of {
    /// Its name if its failure is the fault of an argument.
    fn name(self) -> Option<&'static str> {
        match self {
            Of::Step(_) => None,
            Of::Project => Some("project"),
            Of::Loop => Some("loop"),
        }
    }
}

/// An exception of a function of the user.
struct Raised {
    of: Of,
    /// The text of the failure that it became.
    reason: String,
    error: PyErr,
}

impl Raised {
    /// Whether it became this error of the diagnostic.
    fn became(&self, error: &Error) -> bool {
        match (error, self.of) {
            (Error::InStep { error, .. }, _) => self.became(error),
            (
                Error::StepFailed {
                    reason, step_size, ..
                },
                Of::Step(h),
            ) => step_size.is_none_or(|size| size == h) && self.reason == *reason,
            // A loop or a projection that fails gives states that are not numbers.
            (Error::NotFinite { .. }, Of::Project | Of::Loop) => true,
            _ => false,
        }
    }
}

impl Functions {
    /// These functions, of which none was called yet.
    pub fn new(
        step: Option<Step>,
        project: Option<Py<PyAny>>,
        phase_loop: Option<Py<PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> Self {
        Functions {
            step,
            project,
            energy: None,
            reversal: None,
            phase_loop,
            progress,
            journal: None,
            workers: None,
            made: HashMap::new(),
            memory: None,
            raised: Vec::new(),
            planned: 0,
            measured: 0,
        }
    }

    /// Serves a call.
    ///
    /// # Errors
    /// An exception that stops the diagnosis.
    pub fn serve(&mut self, py: Python<'_>, call: Call) -> PyResult<()> {
        match call {
            Call::Begin(h, states) => match &self.workers {
                Some(workers) => workers.begin(py, h, &states),
                None => Ok(()),
            },
            Call::Step(h, mut loan) => {
                let mut block = loan.block();
                let advanced = match &self.workers {
                    Some(workers) => advance_by_workers(py, workers, h, &mut block)?,
                    None => self.advance(py, h, &mut block),
                };
                self.answer(py, loan, Of::Step(h), advanced)
            }
            Call::Part(number, h, mut loan) => {
                let advanced = self.advance_part(py, number, h, &mut loan.block());
                self.answer(py, loan, Of::Step(h), advanced)
            }
            Call::Tangents(h, mut loan) => {
                let advanced = self.advance_tangents(py, h, &mut loan.block());
                self.answer(py, loan, Of::Step(h), advanced)
            }
            Call::Project(mut loan) => {
                let projected = self.project(py, &mut loan.block());
                self.answer(py, loan, Of::Project, projected)
            }
            Call::Energy(mut loan) => {
                let found = self.energies(py, &mut loan.block());
                loan.answer(Ok(found.map_err(|failed| failed.error)?));
                Ok(())
            }
            Call::Compare(difference, loan) => {
                let found = self.workers.as_ref().map(|workers| workers.found(py));
                if let Some((_, Some(found))) = found.transpose()? {
                    difference.get_or_init(|| found);
                }
                loan.answer(Ok(true));
                Ok(())
            }
            Call::Reverse(mut loan) => {
                let reversed = self.reverse(py, &mut loan.block());
                loan.answer(Ok(reversed.map_err(|failed| failed.error)?));
                Ok(())
            }
            Call::Loop(s, mut loan) => {
                let sampled = self.sample(py, s, &mut loan.block());
                let sampled = (sampled.map(|()| true)).map_err(|error| Failed { sample: 0, error });
                self.answer(py, loan, Of::Loop, sampled)
            }
            Call::Started(started) => match &self.progress {
                Some(progress) if progress.bind(py).hasattr("started")? => {
                    let line = Line::new(&started);
                    progress.call_method1(py, "started", (line,))?;
                    Ok(())
                }
                _ => Ok(()),
            },
            Call::Planned(more) => {
                self.planned += more;
                self.tell_progress(py, None)
            }
            Call::Measured(h) => {
                self.measured += 1;
                self.tell_progress(py, Some(h).filter(|h| h.is_finite()))
            }
            Call::Finished => Ok(()),
        }
    }

    /// The exception for an error of the diagnostic; its cause is that of a function of the user, if one raised it.
    pub fn exception(&self, py: Python<'_>, error: &Error) -> PyErr {
        let Some(raised) = self.raised.iter().find(|raised| raised.became(error)) else {
            let by_batch = self.step.as_ref().is_some_and(|step| !step.per_sample);
            return match error {
                Error::Memory {
                    dependence: Dependence::Either,
                    ..
                } if by_batch => step_error(py, error, ALONE),
                _ => diagnostic_error(py, error),
            };
        };
        let exception = match raised.of.name() {
            None => diagnostic_error(py, error),
            Some(name) => {
                let reason = &raised.reason;
                input_error(py, &format!("the {name} function failed: {reason}"))
            }
        };
        exception.set_cause(py, Some(raised.error.clone_ref(py)));
        exception
    }

    /// Answers with what a function did. Exceptions that end programs are passed to the caller of the diagnosis.
    fn answer(
        &mut self,
        py: Python<'_>,
        loan: Loan<Answer>,
        of: Of,
        result: Result<bool, Failed>,
    ) -> PyResult<()> {
        let Failed { sample, error } = match result {
            Ok(finite) => {
                loan.answer(Ok(finite));
                return Ok(());
            }
            Err(failed) => failed,
        };
        // States that cannot be noted would be lost.
        let lost = (self.journal.as_ref()).is_some_and(|journal| journal.failure().is_some());
        if lost || ends_programs(py, &error) {
            return Err(error);
        }
        let reason = error.to_string();
        loan.answer(Err(StepFailure {
            sample,
            reason: reason.clone(),
        }));
        let raised = Raised { of, reason, error };
        let known =
            (self.raised.iter()).any(|kept| kept.of == raised.of && kept.reason == raised.reason);
        if !known && self.raised.len() < KEPT {
            self.raised.push(raised);
        }
        Ok(())
    }

    /// Advances the states of a block.
    fn advance(&mut self, py: Python<'_>, h: f64, block: &mut Block<'_>) -> Result<bool, Failed> {
        let of_batch = |error| Failed { sample: 0, error };
        let step = self
            .step
            .as_ref()
            .expect("only a Python map asks for a step");
        let function = if step.make {
            match self.made.get(&h.to_bits()) {
                Some(made) => made.bind(py).clone(),
                None => {
                    let made = step.function.bind(py).call1((h,)).map_err(of_batch)?;
                    self.made.insert(h.to_bits(), made.clone().unbind());
                    made
                }
            }
        } else {
            step.function.bind(py).clone()
        };
        let call = match step.make {
            true => step.call(function, None, "advance"),
            false => step.call(function, Some(h), "step"),
        };
        let journal = self.journal.as_deref();
        noted(journal, h, step, &call, &mut self.memory, block)
    }

    /// Advances states and tangent vectors.
    fn advance_tangents(
        &mut self,
        py: Python<'_>,
        h: f64,
        block: &mut Block<'_>,
    ) -> Result<bool, Failed> {
        let step = self.step.as_ref();
        let step = step.expect("only a Python map asks for its derivatives");
        let tangents = step.tangents.as_ref();
        let function = tangents.expect("the map has derivatives").bind(py).clone();
        let call = step.call(function, Some(h), "jvp");
        let journal = self.journal.as_deref();
        noted(journal, h, step, &call, &mut self.memory, block)
    }

    /// Advances the states of a block by a part of the step. That is not noted: only a diagnosis that looks for the part that has a
    /// defect asks for it.
    fn advance_part(
        &mut self,
        py: Python<'_>,
        number: usize,
        h: f64,
        block: &mut Block<'_>,
    ) -> Result<bool, Failed> {
        let step = self.step.as_ref();
        let step = step.expect("only a Python map asks for a part of a step");
        let call = step.call(step.parts[number].bind(py).clone(), Some(h), "step");
        call.advance(step.per_sample, step.single, &mut self.memory, block)
    }

    /// Puts the states of a block on the manifold.
    fn project(&mut self, py: Python<'_>, block: &mut Block<'_>) -> Result<bool, Failed> {
        let project = self.project.as_ref();
        let project = project.expect("only a map that projects asks for it");
        let function = project.bind(py).clone();
        self.change(function, "project", block)
    }

    /// Writes the energies of the states of a block into it.
    fn energies(&mut self, py: Python<'_>, block: &mut Block<'_>) -> Result<bool, Failed> {
        let energy = self.energy.as_ref();
        let function = energy.expect("the map has an energy").bind(py).clone();
        self.change(function, "energy", block)
    }

    /// Reverses the states of a block in time.
    fn reverse(&mut self, py: Python<'_>, block: &mut Block<'_>) -> Result<bool, Failed> {
        let reversal = self.reversal.as_ref();
        let function = reversal.expect("the map has a reversal").bind(py).clone();
        self.change(function, "reversal", block)
    }

    /// Calls a function of states other than the step.
    fn change(
        &mut self,
        function: Bound<'_, PyAny>,
        what: &'static str,
        block: &mut Block<'_>,
    ) -> Result<bool, Failed> {
        let call = BlockCall {
            function,
            h: None,
            reset: None,
            what,
        };
        let per_sample = self.step.as_ref().is_some_and(|step| step.per_sample);
        call.advance(per_sample, false, &mut self.memory, block)
    }

    /// Writes the states of the loop at the parameters s.
    fn sample(&self, py: Python<'_>, s: Vec<f64>, block: &mut Block<'_>) -> PyResult<()> {
        let function = self
            .phase_loop
            .as_ref()
            .expect("only a Python loop is sampled here");
        let sampled = function.bind(py).call1((PyArray1::from_vec(py, s),))?;
        let (q, p) = pair(sampled, "loop", "return q and p")?;
        let samples = block.len();
        read_rows(&q, "q of the loop", &mut block.q, samples)?;
        read_rows(&p, "p of the loop", &mut block.p, samples)?;
        Ok(())
    }

    fn tell_progress(&self, py: Python<'_>, h: Option<f64>) -> PyResult<()> {
        match &self.progress {
            Some(progress) => {
                progress.call1(py, (self.measured, self.planned, h))?;
                Ok(())
            }
            None => Ok(()),
        }
    }
}

/// Calls a function for the states of a block. Every call is noted by itself in the journal, if there is one, as soon as it returns.
fn noted(
    journal: Option<&Journal>,
    h: f64,
    step: &Step,
    call: &BlockCall<'_>,
    memory: &mut Option<Py<Memory>>,
    block: &mut Block<'_>,
) -> Result<bool, Failed> {
    let mut advance =
        |block: &mut Block<'_>| call.advance(step.per_sample, step.single, memory, block);
    let Some(journal) = journal else {
        return advance(block);
    };
    let mut noted = |batch: &mut Block<'_>| {
        journal.advance(h, batch, |states| advance(states).map(|_| ()))?;
        Ok(batch.all_finite())
    };
    if !step.per_sample {
        return for_each_batch(block, &mut noted);
    }
    let Block { q, p } = block.reborrow();
    let states = q.column_blocks(1).zip(p.column_blocks(1));
    for (sample, (q, p)) in states.enumerate() {
        noted(&mut Block::new(q, p)).map_err(|failed| Failed { sample, ..failed })?;
    }
    Ok(block.all_finite())
}

/// Lets workers advance the states of a block.
///
/// # Errors
/// If states can be sent to no worker.
fn advance_by_workers(
    py: Python<'_>,
    workers: &Workers,
    h: f64,
    block: &mut Block<'_>,
) -> PyResult<Result<bool, Failed>> {
    let states = block.copy_of(0..block.len());
    match workers.advance(py, h, &states)? {
        Ok((q, p)) => {
            let samples = block.len();
            let finite = read_rows(&q, "q", &mut block.q, samples)?
                & read_rows(&p, "p", &mut block.p, samples)?;
            Ok(Ok(finite))
        }
        Err((sample, error)) => Ok(Err(Failed { sample, error })),
    }
}

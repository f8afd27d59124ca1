//! `symplint.check`: a diagnosis of a Python function or of an integrator of the library.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use symplint::diagnosis::Event;
use symplint::map::{ProjectedLoop, balanced_radii};
use symplint::request::{RequestError, SETTINGS, Value};
use symplint::{Circle, Coordinates, Diagnostic, Ensemble, Error, Loop, Phases, Rule, TimeAdvance};
use symplint_run::Journal;

use crate::arrays::{self, Arrays};
use crate::calls::{self, Call, Caller};
use crate::coordinates::Stated;
use crate::error::{input_error, other_error};
use crate::functions::{Functions, Step};
use crate::loops::{NativeLoop, named_phases};
use crate::models::Integrator;
use crate::pool;
use crate::report::{self, Report};
use crate::step::{Projects, PythonLoop, PythonMap, Stoppable};
use crate::workers::{self, Workers};

/// The tested map: `symplint.check` has checked the types.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Subject {
    /// An integrator of the library, or nothing: then a function.
    integrator: Option<Py<Integrator>>,
    step: Option<Py<PyAny>>,
    /// States and tangent vectors after a step, from those before it, if its derivatives are known.
    tangents: Option<Py<PyAny>>,
    /// Names and functions of its parts, if it has any.
    parts: Vec<(String, Py<PyAny>)>,
    per_sample: bool,
    make: bool,
    reset: Option<Py<PyAny>>,
    single: bool,
    project: Option<Py<PyAny>>,
    /// Writes the energy of states into their first coordinates, if it is given.
    energy: Option<Py<PyAny>>,
    /// Reverses states in time, if it is given.
    reversal: Option<Py<PyAny>>,
    /// Whether `project` evaluates a one-form.
    form: bool,
    dof: usize,
    coordinates: Stated,
    /// A loop of the library, or nothing: then a function, or else a circle.
    native_loop: Option<Py<NativeLoop>>,
    phase_loop: Option<Py<PyAny>>,
    q0: Vec<f64>,
    p0: Vec<f64>,
    /// Radii in q and p of a circle; nothing for those that the map suggests.
    radii: Option<(Vec<f64>, Vec<f64>)>,
    /// Phases of a circle, by name, and the seed of random ones.
    phases: (String, u64),
    threads: Option<usize>,
    /// Who takes the steps, if not this process.
    workers: Option<Py<PyAny>>,
}

/// Settings of the diagnosis by name.
pub struct Settings(BTreeMap<String, Value>);

impl<'a, 'py> FromPyObject<'a, 'py> for Settings {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let item = |(key, item): (Bound<'py, PyAny>, Bound<'py, PyAny>)| {
            let name: String = key.extract()?;
            let Some(value) = value(&item) else {
                let text = format!(
                    "{} is an object of type {}",
                    argument(&name),
                    item.get_type().name()?
                );
                return Err(input_error(given.py(), &text));
            };
            Ok((name, value))
        };
        let table = given.cast::<PyDict>()?;
        table
            .iter()
            .map(item)
            .collect::<PyResult<_>>()
            .map(Settings)
    }
}

/// A Python object as the value of a setting, if it is one.
fn value(given: &Bound<'_, PyAny>) -> Option<Value> {
    if let Ok(flag) = given.extract() {
        return Some(Value::Flag(flag));
    }
    if let Ok(text) = given.extract() {
        return Some(Value::Text(text));
    }
    if let Ok(table) = given.cast::<PyDict>() {
        let item = |(key, item): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
            Some((key.extract().ok()?, value(&item)?))
        };
        return table
            .iter()
            .map(item)
            .collect::<Option<_>>()
            .map(Value::Table);
    }
    if let Ok(whole) = given.extract() {
        return Some(Value::Whole(whole));
    }
    if let Ok(number) = given.extract() {
        return Some(Value::Number(number));
    }
    let items = given.try_iter().ok()?;
    (items.map(|item| value(&item.ok()?)).collect::<Option<_>>()).map(Value::List)
}

/// Names of settings that have another one in Python.
const ARGUMENTS: [(&str, &str); 4] = [
    ("step_size", "typical_step"),
    ("seed", "rng"),
    ("cutoff_q", "cutoff"),
    ("cutoff_p", "cutoff"),
];

/// The argument of `symplint.check` that gives a setting.
fn argument(setting: &str) -> &str {
    let found = ARGUMENTS.iter().find(|(name, _)| *name == setting);
    found.map_or(setting, |(_, argument)| argument)
}

impl Settings {
    fn diagnostic(&self, py: Python<'_>) -> PyResult<Diagnostic> {
        Diagnostic::from_settings(&self.0).map_err(|error| {
            let text = match error {
                RequestError::Refused { name, refused } => {
                    format!("{}{refused}", argument(name))
                }
                error => error.to_string(),
            };
            input_error(py, &text)
        })
    }
}

/// The names of all settings of a diagnosis.
#[pyfunction]
pub fn settings() -> Vec<&'static str> {
    SETTINGS.iter().map(|setting| setting.name).collect()
}

/// λ_q and λ_p of the finite-difference rule.
pub type CutoffPair = (f64, f64);

/// The rule of this name, with the settings that a configuration has by default, but for the cut-offs.
pub fn rule(py: Python<'_>, name: &str, cutoffs: CutoffPair) -> PyResult<Rule> {
    let cutoff = |name: &str, of| (name.to_owned(), Value::Number(of));
    let rule = ("rule".to_owned(), Value::Text(name.to_owned()));
    let given = [
        rule,
        cutoff("cutoff_q", cutoffs.0),
        cutoff("cutoff_p", cutoffs.1),
    ];
    Ok(Settings(BTreeMap::from(given)).diagnostic(py)?.rule)
}

/// The data that threads of a diagnosis need: no Python objects.
struct Shared {
    integrator: Option<Arc<dyn TimeAdvance>>,
    coordinates: Coordinates,
    projects: Projects,
    parts: Vec<String>,
    has_workers: bool,
    has_tangent: bool,
    has_energy: bool,
    has_reversal: bool,
    native_loop: Option<Arc<dyn Loop>>,
    has_loop: bool,
    q0: Vec<f64>,
    p0: Vec<f64>,
    radii: Option<(Vec<f64>, Vec<f64>)>,
    phases: Phases,
}

impl Subject {
    fn shared(&self, py: Python<'_>) -> PyResult<Shared> {
        let integrator = (self.integrator.as_ref()).map(|given| Arc::clone(&given.get().map));
        Ok(Shared {
            integrator,
            coordinates: self.coordinates.of(py, self.dof)?,
            projects: match (&self.project, self.form) {
                (None, _) => Projects::Nothing,
                (Some(_), false) => Projects::OntoManifold,
                (Some(_), true) => Projects::OntoForm,
            },
            parts: self.parts.iter().map(|(name, _)| name.clone()).collect(),
            has_workers: self.workers.is_some(),
            has_tangent: self.tangents.is_some(),
            has_energy: self.energy.is_some(),
            has_reversal: self.reversal.is_some(),
            native_loop: (self.native_loop.as_ref()).map(|given| Arc::clone(&given.get().inner)),
            has_loop: self.phase_loop.is_some(),
            q0: self.q0.clone(),
            p0: self.p0.clone(),
            radii: self.radii.clone(),
            phases: named_phases(py, &self.phases.0, self.phases.1)?,
        })
    }

    fn functions(&self, py: Python<'_>, progress: Option<Py<PyAny>>) -> Functions {
        let step = self.step.as_ref().map(|function| Step {
            function: function.clone_ref(py),
            tangents: self.tangents.as_ref().map(|found| found.clone_ref(py)),
            per_sample: self.per_sample,
            make: self.make,
            reset: self.reset.as_ref().map(|reset| reset.clone_ref(py)),
            single: self.single,
            parts: (self.parts.iter())
                .map(|(_, part)| part.clone_ref(py))
                .collect(),
        });
        let clone =
            |function: &Option<Py<PyAny>>| function.as_ref().map(|function| function.clone_ref(py));
        Functions::new(
            step,
            clone(&self.project),
            clone(&self.phase_loop),
            progress,
        )
    }

    /// Runs `work` with the map and the loop: on this thread, unless there are to be more or no Python function is the map.
    pub fn run<R: Send>(
        &self,
        py: Python<'_>,
        (progress, journal): (Option<Py<PyAny>>, Option<Arc<Journal>>),
        step_size: f64,
        work: impl FnOnce(&dyn Caller, &dyn TimeAdvance, &dyn Loop) -> Result<R, Error> + Send,
    ) -> PyResult<Ran<R>> {
        let shared = self.shared(py)?;
        let mut functions = self.functions(py, progress);
        let workers = self.workers.as_ref();
        functions.workers = workers
            .map(|workers| Workers::new(py, workers, journal.as_ref()))
            .transpose()?;
        functions.journal = journal;
        functions.energy = self.energy.as_ref().map(|energy| energy.clone_ref(py));
        functions.reversal = self.reversal.as_ref().map(|of| of.clone_ref(py));
        let serve = |py: Python<'_>, call: Call| functions.serve(py, call);
        let with = |caller: &dyn Caller| shared.with(caller, step_size, work);
        let (outcome, threads) = if self.step.is_some() && self.threads.is_none_or(|n| n == 1) {
            pool::alone(py)?;
            (calls::run_here(py, with, serve)?, 1)
        } else {
            let pool = pool::own(py, self.threads)?;
            let on_pool = |caller: &dyn Caller| pool.install(|| with(caller));
            let outcome = calls::run_beside(py, on_pool, serve)?;
            (outcome, pool.current_num_threads())
        };
        match outcome {
            Ok(result) => Ok(Ran {
                result,
                threads,
                functions,
            }),
            Err(error) => Err(functions.exception(py, &error)),
        }
    }
}

/// What came of some work with a map and a loop.
pub struct Ran<R> {
    pub result: R,
    /// Threads of the work.
    threads: usize,
    /// The Python functions, which know what they raised.
    functions: Functions,
}

impl Shared {
    /// Calls `work` with the map and the loop.
    fn with<R>(
        &self,
        caller: &dyn Caller,
        step_size: f64,
        work: impl FnOnce(&dyn Caller, &dyn TimeAdvance, &dyn Loop) -> Result<R, Error>,
    ) -> Result<R, Error> {
        let map: Box<dyn TimeAdvance + '_> = match &self.integrator {
            Some(map) => Box::new(Stoppable::new(&**map, caller)),
            None => {
                let mut map = PythonMap::new(caller, self.coordinates.clone(), self.projects);
                map.parts = &self.parts;
                map.has_workers = self.has_workers;
                map.has_tangent = self.has_tangent;
                map.has_energy = self.has_energy;
                map.has_reversal = self.has_reversal;
                Box::new(map)
            }
        };
        let phase_loop: Box<dyn Loop + '_> = match &self.native_loop {
            Some(given) => Box::new(&**given),
            None if self.has_loop => Box::new(PythonLoop::new(caller, self.coordinates.dof())),
            None => {
                let circle = |radii_q, radii_p| {
                    let (q0, p0) = (self.q0.clone(), self.p0.clone());
                    let circle = Circle::with_radii(q0, p0, radii_q, radii_p)?;
                    Ok::<_, Error>(circle.with_phases(self.phases))
                };
                match &self.radii {
                    Some((q, p)) => Box::new(circle(q.clone(), p.clone())?),
                    None => {
                        let found = balanced_radii(&*map, &self.q0, &self.p0, step_size)?;
                        Box::new(found.counted(circle(found.q.clone(), found.p.clone())?))
                    }
                }
            }
        };
        let phase_loop: Box<dyn Loop + '_> = match map.capabilities().constraint {
            Some(_) => Box::new(ProjectedLoop::new(phase_loop, &map)),
            None => phase_loop,
        };
        work(caller, &*map, &*phase_loop)
    }
}

/// Diagnoses a map. Its results are noted in a journal, if a path and the identity of the run, as JSON, are given. With the report comes the exception for a step size of the given loop that the map could not take, if
/// there is one.
#[pyfunction]
#[pyo3(signature = (subject, settings, title, config, progress=None, journal=None))]
pub fn check(
    py: Python<'_>,
    subject: Subject,
    settings: Settings,
    title: String,
    config: &str,
    progress: Option<Py<PyAny>>,
    journal: Option<(PathBuf, String)>,
) -> PyResult<(Report, Option<PyErr>)> {
    let run = report::start();
    let journal = journal
        .map(|(path, of)| workers::open(py, &path, &of))
        .transpose()?;
    let config: serde_json::Value =
        serde_json::from_str(config).map_err(|error| other_error(py, &error.to_string()))?;
    let diagnostic = settings.diagnostic(py)?;
    let largest = diagnostic.step_sizes.iter().copied().reduce(f64::max);
    let step_size = largest.or(diagnostic.typical_step).unwrap_or(1.0);
    let watched = progress.is_some();
    let failed: OnceLock<Error> = OnceLock::new();
    let measure = |caller: &dyn Caller, map: &dyn TimeAdvance, phase_loop: &dyn Loop| {
        diagnostic.run_watched(map, phase_loop, &|event| match event {
            Event::Started(progress) if watched => caller.tell(Call::Started(progress.clone())),
            Event::Planned(more) if watched => caller.tell(Call::Planned(more)),
            Event::Measured(point) if watched => caller.tell(Call::Measured(point.step_size)),
            Event::Failed(error) => {
                failed.get_or_init(|| error.clone());
            }
            _ => {}
        })
    };
    let Ran {
        result: diagnosis,
        threads,
        functions,
    } = subject.run(py, (progress, journal), step_size, measure)?;
    let failed = (failed.get()).map(|error| functions.exception(py, error));
    let replayed = (functions.journal.as_ref()).map_or(0, |journal| journal.replayed());
    let workers = functions.workers.as_ref().map(|workers| workers.found(py));
    let (count, _) = workers.transpose()?.unwrap_or_default();
    let report = (Report::new(diagnosis, title, config, &run, threads))
        .replaying(replayed)
        .by_workers(count);
    Ok((report, failed))
}

/// Samples of the loop before and after some steps of size h.
#[pyfunction]
pub fn image<'py>(
    py: Python<'py>,
    subject: Subject,
    h: f64,
    samples: usize,
    repeat: usize,
) -> PyResult<(Arrays<'py>, Arrays<'py>)> {
    let advance = |_: &dyn Caller, map: &dyn TimeAdvance, phase_loop: &dyn Loop| {
        let before = Ensemble::sample(phase_loop, samples)?;
        let mut after = before.clone();
        (0..repeat).try_for_each(|_| after.advance(map, h))?;
        Ok((before, after))
    };
    let (before, after) = subject.run(py, (None, None), h, advance)?.result;
    Ok((arrays::arrays(py, &before), arrays::arrays(py, &after)))
}

/// How many seconds each of several steps of size h took, of all samples of the loop, with everything that happens between
/// the diagnostic and the step: for `benches/overhead.py`.
#[pyfunction]
pub fn advance_seconds(
    py: Python<'_>,
    subject: Subject,
    h: f64,
    samples: usize,
    repetitions: usize,
) -> PyResult<Vec<f64>> {
    let advance = |_: &dyn Caller, map: &dyn TimeAdvance, phase_loop: &dyn Loop| {
        let before = Ensemble::sample(phase_loop, samples)?;
        let mut states = before.clone();
        let mut once = || {
            states.clone_from(&before);
            let start = Instant::now();
            states.advance(map, h)?;
            Ok(start.elapsed().as_secs_f64())
        };
        (0..repetitions).map(|_| once()).collect()
    };
    let seconds = subject.run(py, (None, None), h, advance)?.result;
    Ok(seconds)
}

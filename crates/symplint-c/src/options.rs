//! The options of a check, which may grow.
//!
//! The struct begins with its size, as the caller's header has it. Later versions add fields at the end; what a caller's
//! struct does not have gets its default.

use std::collections::BTreeMap;
use std::ffi::c_char;

use serde::Serialize;
use symplint::request::Value;
use symplint::rules::Piecewise;
use symplint::{Circle, Coordinates, Diagnostic, Phases};

use crate::callback::{SymplintReversal, SymplintSubstep};
use crate::pointers::{optional_values, overlay, text, values, write_prefix};
use crate::status::{Failure, SymplintStatus, guarded};

/// Options of `symplint_check`. Fill it by `symplint_options_init`, then change its fields.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SymplintOptions {
    /// Size of this struct in bytes.
    pub size: usize,
    /// Step sizes, or NULL: 2^-1, 2^-2, ..., 2^-10, or what `typical_step` finds.
    pub step_sizes: *const f64,
    /// Number of step sizes.
    pub step_count: usize,
    /// A typical step size, or 0. If `step_sizes` is NULL, the step sizes are the largest one that advances the motions on the loop by
    /// about a radian, and seven halvings of it.
    pub typical_step: f64,
    /// Radius of the loop, a circle in every degree of freedom. 1 by default.
    pub radius: f64,
    /// Radius in each position, or NULL: `radius`.
    pub radius_q: *const f64,
    /// Radius in each momentum, or NULL: `radius`.
    pub radius_p: *const f64,
    /// Period of each position, 0 for none; or NULL.
    pub period: *const f64,
    /// Period of each momentum, 0 for none; or NULL. Loops must not wind round such a torus, because ∮ p·dq has no unique value there.
    pub momentum_period: *const f64,
    /// Weight of each momentum, canonical momentum = weight * p; or NULL.
    pub weight: *const f64,
    /// "auto", "pseudospectral", "finite-difference", "piecewise" or "streaming"; NULL is "auto".
    pub rule: *const c_char,
    /// Samples of a loop. 0, the default, takes as many as the loop needs.
    pub samples: usize,
    /// The largest number of evaluations (states advanced by one step), at least 200. 20000 by default.
    pub budget: usize,
    /// Loops in all; those after the first are random. 8 by default.
    pub loops: usize,
    /// Number of steps of the largest size, to test whether a defect accumulates. 0 by default.
    pub steps: usize,
    /// Seed of the random loops. 1 by default.
    pub seed: u64,
    /// Tolerance of the piecewise rule, relative. 1e-12 by default.
    pub tolerance: f64,
    /// Threads for the work of this library, at most one for each processor, 0 for all; the step is called on the calling thread alone. 1 by default.
    pub threads: usize,
    /// Whether the Jacobian of a step is also tested: 1, the default, or 0.
    pub jacobian: i32,
    /// Whether a defect is traced to a part of the loop: 1, the default, or 0.
    pub localise: i32,
    /// Where each degree of freedom starts on its circle: "staggered" at multiples of the golden ratio, "equal" (the circle of
    /// the paper) or "random"; NULL is "staggered".
    pub phases: *const c_char,
    /// The step is composed with itself this number of times. 1 by default.
    pub repeat: usize,
    /// Whether the step is a map without a step size, such as a kicker or one turn of a ring: 1, or 0, the default. It is
    /// called with h = 1, and `step_sizes` and `typical_step` are not used.
    pub no_step_size: i32,
    /// 2 dof signs, 1 or -1, of all positions and then all momenta, that reverse time; or NULL: the signs of all momenta change.
    pub reversal: *const f64,
    /// Whether other properties of the map are tested, such as the conservation of volume: 1, the default, or 0. The report has
    /// them.
    pub properties: i32,
    /// Whether a step of size -h is tested to undo a step of size h: 1, or 0, the default. The step is called with negative h then.
    pub symmetric: i32,
    /// Settings that have no field here, as a JSON object with the keys of `diagnostic` in configuration files, such as
    /// "{\"cutoff_q\": 10.0, \"closure\": \"chords\"}"; or NULL. They replace the fields for the same settings.
    pub settings: *const c_char,
    /// A substep of a step that is a composition, such as a kick, a drift or an element of a lattice; or NULL: then
    /// `step` is the whole step.
    pub substep: SymplintSubstep,
    /// Number of substeps of one step, if `substep` is not NULL.
    pub substep_count: usize,
    /// Names of the substeps in their order, for the report; or NULL: "part 1", "part 2", ...
    pub substep_names: *const *const c_char,
    /// A function of states that reverses time, instead of `reversal`; or NULL.
    pub reversal_function: SymplintReversal,
}

/// Evaluations by default: a step of another code is dear.
const BUDGET: usize = 20_000;

/// Bytes of the struct of version 0.1.0, the first: it ends with `localise`. Later fields come after that.
const FIRST_SIZE: usize = std::mem::offset_of!(SymplintOptions, localise) + size_of::<i32>();

impl Default for SymplintOptions {
    fn default() -> Self {
        let null = std::ptr::null();
        let diagnostic = Diagnostic::default();
        SymplintOptions {
            size: size_of::<Self>(),
            step_sizes: null,
            step_count: 0,
            typical_step: 0.0,
            radius: 1.0,
            radius_q: null,
            radius_p: null,
            period: null,
            momentum_period: null,
            weight: null,
            rule: std::ptr::null(),
            samples: 0,
            budget: BUDGET,
            loops: diagnostic.loops,
            steps: 0,
            seed: diagnostic.seed,
            tolerance: Piecewise::default().tolerance,
            threads: 1,
            jacobian: 1,
            localise: 1,
            phases: std::ptr::null(),
            repeat: 1,
            no_step_size: 0,
            reversal: null,
            properties: 1,
            symmetric: 0,
            settings: std::ptr::null(),
            substep: None,
            substep_count: 0,
            substep_names: std::ptr::null(),
            reversal_function: None,
        }
    }
}

/// Fills options with their defaults. `size` is sizeof(SymplintOptions).
///
/// # Safety
/// `options` has `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_options_init(
    options: *mut SymplintOptions,
    size: usize,
) -> SymplintStatus {
    guarded(|| {
        check_size(size)?;
        let defaults = SymplintOptions {
            size,
            ..SymplintOptions::default()
        };
        // SAFETY: what the caller of this function promises.
        unsafe { write_prefix("options", options, size, &defaults) }
    })
}

/// Refuses sizes that no version of the struct has.
fn check_size(size: usize) -> Result<(), Failure> {
    let most = size_of::<SymplintOptions>();
    if size > most {
        return Err(Failure::bad_argument(format!(
            "the options have {size} bytes and this library, {}, knows {most}: the header is newer than the library",
            env!("CARGO_PKG_VERSION")
        )));
    }
    match size < FIRST_SIZE {
        true => Err(Failure::bad_argument(format!(
            "the options have {size} bytes where there are {FIRST_SIZE} at least; fill them by symplint_options_init"
        ))),
        false => Ok(()),
    }
}

/// The options with the arrays that they point to.
#[derive(Debug, Serialize)]
pub struct Settings {
    q0: Vec<f64>,
    p0: Vec<f64>,
    radius_q: Vec<f64>,
    radius_p: Vec<f64>,
    period: Option<Vec<f64>>,
    momentum_period: Option<Vec<f64>>,
    weight: Option<Vec<f64>>,
    phases: String,
    #[serde(skip)]
    seed: u64,
    /// Those of the diagnosis, by name.
    #[serde(flatten)]
    settings: BTreeMap<String, Value>,
    #[serde(skip)]
    pub substep: SymplintSubstep,
    #[serde(skip)]
    pub reversal_function: SymplintReversal,
    /// Names of the substeps, if the step is a composition.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub substeps: Vec<String>,
    /// Results do not depend on it.
    #[serde(skip)]
    pub threads: usize,
}

impl Settings {
    /// Degrees of freedom.
    pub fn dof(&self) -> usize {
        self.q0.len()
    }

    /// Reads options, or takes the defaults if there are no options.
    ///
    /// # Safety
    /// Arrays that are not null have as many values as the header says.
    pub unsafe fn read(
        dof: usize,
        q0: *const f64,
        p0: *const f64,
        options: *const SymplintOptions,
    ) -> Result<Self, Failure> {
        if dof == 0 {
            return Err(Failure::bad_argument(
                "dof is 0; give one degree of freedom or more",
            ));
        }
        let mut read = SymplintOptions::default();
        if !options.is_null() {
            let mut size = 0_usize;
            // SAFETY: the struct begins with its size, and has this number of bytes; integers, numbers and pointers may have any.
            unsafe {
                overlay("options", options.cast(), size_of::<usize>(), &mut size)?;
                check_size(size)?;
                overlay("options", options, size, &mut read)?;
            }
        }
        // SAFETY: the caller promises this number of values, or null.
        unsafe {
            let of_each = |what, pointer| optional_values(what, pointer, dof);
            let radius = |what, pointer| {
                Ok::<_, Failure>(of_each(what, pointer)?.unwrap_or_else(|| vec![read.radius; dof]))
            };
            let processors = std::thread::available_parallelism().map_or(1, usize::from);
            Ok(Settings {
                q0: values("q0", q0, dof)?.to_vec(),
                p0: values("p0", p0, dof)?.to_vec(),
                radius_q: radius("radius_q", read.radius_q)?,
                radius_p: radius("radius_p", read.radius_p)?,
                period: of_each("period", read.period)?,
                momentum_period: of_each("momentum_period", read.momentum_period)?,
                weight: of_each("weight", read.weight)?,
                phases: text("phases", read.phases)?
                    .unwrap_or("staggered")
                    .to_owned(),
                seed: read.seed,
                settings: settings(&read, dof)?,
                substep: read.substep,
                reversal_function: read.reversal_function,
                substeps: substeps(&read)?,
                threads: read.threads.min(processors),
            })
        }
    }

    /// The given loop.
    pub fn circle(&self) -> Result<Circle, Failure> {
        if (self.radius_q.iter().chain(&self.radius_p)).all(|&radius| radius == 0.0) {
            return Err(Failure::bad_argument(
                "radius is 0 in all coordinates; give a positive number".to_owned(),
            ));
        }
        let (q0, p0) = (self.q0.clone(), self.p0.clone());
        let circle = Circle::with_radii(q0, p0, self.radius_q.clone(), self.radius_p.clone());
        let Some(phases) = Phases::named(&self.phases, self.seed) else {
            return Err(Failure::bad_argument(format!(
                "phases is \"{}\"; give \"staggered\", \"equal\" or \"random\"",
                self.phases
            )));
        };
        Ok(circle?.with_phases(phases))
    }

    /// The meaning of the coordinates.
    pub fn coordinates(&self) -> Result<Coordinates, Failure> {
        let mut coordinates = Coordinates::plain(self.q0.len());
        if let Some(period) = &self.period {
            coordinates = coordinates.with_periods(period.clone())?;
        }
        if let Some(period) = &self.momentum_period {
            coordinates = coordinates.with_momentum_periods(period.clone())?;
        }
        if let Some(weight) = &self.weight {
            coordinates = coordinates.with_weights(weight.clone())?;
        }
        Ok(coordinates)
    }

    /// The diagnosis that the options describe.
    pub fn diagnostic(&self) -> Result<Diagnostic, Failure> {
        Diagnostic::from_settings(&self.settings)
            .map_err(|error| Failure::bad_argument(error.to_string()))
    }
}

/// Substeps of a step: a number of more digits is not a count, but an error of the caller.
const MAX_SUBSTEPS: usize = 1_000_000;

/// The names of the substeps; none if the step is one whole.
///
/// # Safety
/// The array of names, if it is not null, has as many texts as there are substeps.
unsafe fn substeps(read: &SymplintOptions) -> Result<Vec<String>, Failure> {
    if read.substep.is_none() {
        return Ok(Vec::new());
    }
    let count = read.substep_count;
    if !(1..=MAX_SUBSTEPS).contains(&count) {
        return Err(Failure::bad_argument(format!(
            "substep_count is {count}; give the number of substeps of one step, from 1 to {MAX_SUBSTEPS}"
        )));
    }
    let unnamed = |k: usize| format!("part {}", k + 1);
    if read.substep_names.is_null() {
        return Ok((0..count).map(unnamed).collect());
    }
    // SAFETY: the caller promises this number of texts.
    let names = unsafe { values("substep_names", read.substep_names, count) }?;
    let name = |(k, name): (usize, &*const c_char)| {
        // SAFETY: as above.
        let name = unsafe { text("substep_names", *name) }?;
        Ok(name.map_or_else(|| unnamed(k), str::to_owned))
    };
    names.iter().enumerate().map(name).collect()
}

/// The settings of the diagnosis by name; those that are left at NULL or 0 for a default are not among them.
///
/// # Safety
/// Arrays that are not null have as many values as the header says.
unsafe fn settings(read: &SymplintOptions, dof: usize) -> Result<BTreeMap<String, Value>, Failure> {
    let whole = |number: usize| Value::Whole(number as u64);
    let flag = |flag: i32| Value::Flag(flag != 0);
    let list = |numbers: &[f64]| Value::List(numbers.iter().copied().map(Value::Number).collect());
    let mut settings = BTreeMap::from(
        [
            ("budget", whole(read.budget)),
            ("loops", whole(read.loops)),
            ("steps", whole(read.steps)),
            ("seed", Value::Whole(read.seed)),
            ("tolerance", Value::Number(read.tolerance)),
            ("jacobian", flag(read.jacobian)),
            ("localise", flag(read.localise)),
            ("repeat", whole(read.repeat)),
            ("properties", flag(read.properties)),
            ("symmetric", flag(read.symmetric)),
        ]
        .map(|(name, value)| (name.to_owned(), value)),
    );
    let mut give = |name: &str, value| settings.insert(name.to_owned(), value);
    // SAFETY: the caller promises this number of values, or null.
    let (rule, sizes, reversal, more) = unsafe {
        (
            text("rule", read.rule)?,
            match read.step_sizes.is_null() {
                true => None,
                false => Some(values("step_sizes", read.step_sizes, read.step_count)?),
            },
            optional_values("reversal", read.reversal, 2 * dof)?,
            text("settings", read.settings)?,
        )
    };
    if let Some(rule) = rule {
        give("rule", Value::Text(rule.to_owned()));
    }
    if read.samples > 0 {
        give("samples", whole(read.samples));
    }
    if let Some(signs) = reversal {
        give("reversal", list(&signs));
    }
    match sizes {
        _ if read.no_step_size != 0 => {
            give("step_sizes", Value::Text("none".to_owned()));
        }
        Some(sizes) => {
            give("step_sizes", list(sizes));
        }
        None if read.typical_step != 0.0 => {
            give("step_size", Value::Number(read.typical_step));
        }
        None => {}
    }
    if let Some(more) = more {
        let more: BTreeMap<String, Value> = serde_json::from_str(more).map_err(|error| {
            Failure::bad_argument(format!(
                "settings is not a JSON object: {error}; write it as {{\"loops\": 4}}"
            ))
        })?;
        settings.extend(more);
    }
    if read.reversal_function.is_some() && settings.contains_key("reversal") {
        return Err(Failure::bad_argument(
            "both reversal and reversal_function are given; leave one of them at NULL",
        ));
    }
    Ok(settings)
}

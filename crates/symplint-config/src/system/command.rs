//! A program as a map: `name = "command"`.

use std::num::NonZero;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use symplint::{Coordinates, TimeAdvance};
use symplint_files::LoopFile;
use symplint_models::Model;
use symplint_run::{CommandMap, FileFormat, Limits};

use super::given_map::NONE;
use super::{System, SystemInfo};
use crate::ConfigError;
use crate::document::Value;
use crate::section::{Key, NumberRange, Section};

/// Evaluations where none are given: each is a simulation of another code.
const BUDGET: usize = 20_000;

/// Calls at a time, and samples in a file, at most.
const MAX_COUNT: u64 = 1 << 20;

/// Seconds of one call at most: a year.
const MAX_TIMEOUT: f64 = 3.2e7;

pub const COMMAND: SystemInfo = SystemInfo {
    name: "command",
    summary: "a program as a map: reads an .npz file with arrays q and p of shape (samples, dof), h, period and \
              weight, and writes one with q and p after one step of size h; without integrator",
    keys: &[
        Key::required(
            "command",
            "[\"python3\", \"advance.py\", \"{before}\", \"{after}\", \"{h}\"]",
            "the program and its arguments; {before} is the file to read, {after} the one to write",
        ),
        Key::required(
            "q0",
            "[1.0]",
            "centre of the loop, positions: a list, or { file = \"state.npz\" } with an array q",
        ),
        Key::required(
            "p0",
            "[0.5]",
            "centre of the loop, momenta: a list, or a file with an array p",
        ),
        Key::new(
            "format",
            "\"npz\"",
            "of the files: npz, raw (one line `symplint h dof samples`, then doubles, all q and then all p, by degree of freedom) or \
             text (the same with decimals)",
        ),
        Key::new(
            "files",
            "[]",
            "further files that identify the program, such as scripts and tables: if one changes, it is another run",
        ),
        Key::optional(
            "period",
            "[0.0]",
            "period of each position, 0 if not periodic; by default no position is periodic",
        ),
        Key::optional(
            "weight",
            "[1.0]",
            "canonical momentum = weight × p; by default 1",
        ),
        Key::new("timeout", "600.0", "seconds for one call"),
        Key::new("workers", "4", "number of calls at the same time"),
        Key::new("batch", "64", "largest number of samples in one file"),
        Key::optional(
            "folder",
            "\".\"",
            "working directory of the program; by default the folder of this file",
        ),
        Key::optional(
            "keep",
            "\"symplint-calls\"",
            "a new folder for the files of all calls; by default these files are removed",
        ),
    ],
    integrator: NONE,
    budget: Some(BUDGET),
    build: |section, folder| {
        let q0 = state(section, "q0", folder)?;
        let p0 = state(section, "p0", folder)?;
        if q0.len() != p0.len() {
            let message = format!("{} momenta for {} positions", p0.len(), q0.len());
            return Err(section.error("p0", message, "give one momentum for each position"));
        }
        let coordinates = coordinates(section, q0.len())?;
        let runs_in = match section.optional_text("folder")? {
            Some(own) => folder.join(own),
            None => folder.to_owned(),
        };
        // The resolved configuration may be read from a run folder, so it needs absolute paths.
        // An empty path, that of a file in the current folder, has no absolute one.
        let runs_in = std::path::absolute(Path::new(".").join(&runs_in)).unwrap_or(runs_in);
        if let Some(path) = runs_in.to_str() {
            section.record("folder", path);
        }
        let command = section.texts("command")?;
        let mut map = CommandMap::new(command, &runs_in, coordinates, limits(section)?)
            .map_err(|error| section.refused_by("command", &error))?;
        let format = section.choice("format", &FileFormat::NAMES)?;
        map = map.with_format(FileFormat::named(format).unwrap_or_default());
        map = map.identified_by(section.texts("files")?);
        if let Some(keep) = section.optional_text("keep")? {
            let keep = folder.join(keep);
            let keep = std::path::absolute(&keep).unwrap_or(keep);
            if let Some(path) = keep.to_str() {
                section.record("keep", path);
            }
            map = (map.keeping(keep)).map_err(|error| section.refused_by("keep", &error))?;
        }
        let map = Arc::new(map);
        Ok(System {
            name: "command",
            model: Model::Map(Arc::clone(&map) as Arc<dyn TimeAdvance>),
            q0,
            p0,
            command: Some(map),
        })
    },
};

fn limits(section: &Section) -> Result<Limits, ConfigError> {
    let count = |key| {
        let count = section.whole_between(key, 1, MAX_COUNT)? as usize;
        Ok::<_, ConfigError>(NonZero::new(count).unwrap_or(NonZero::<usize>::MIN))
    };
    let timeout = section
        .number("timeout", NumberRange::Positive)?
        .min(MAX_TIMEOUT);
    Ok(Limits {
        timeout: Duration::from_secs_f64(timeout),
        workers: count("workers")?,
        batch: count("batch")?,
    })
}

fn coordinates(section: &Section, dof: usize) -> Result<Coordinates, ConfigError> {
    let of_each = |key| match section.written_place(key) {
        Some(_) => section.numbers(key, dof).map(Some),
        None => Ok(None),
    };
    let mut coordinates = Coordinates::plain(dof);
    if let Some(periods) = of_each("period")? {
        coordinates = (coordinates.with_periods(periods))
            .map_err(|error| section.refused_by("period", &error))?;
    }
    if let Some(weights) = of_each("weight")? {
        coordinates = (coordinates.with_weights(weights))
            .map_err(|error| section.refused_by("weight", &error))?;
    }
    Ok(coordinates)
}

/// Positions or momenta: a list, or an array of a file.
fn state(section: &Section, key: &'static str, folder: &Path) -> Result<Vec<f64>, ConfigError> {
    let node = section.required(key)?;
    let values = match &node.value {
        Value::Table(_) => of_file(section, key, folder)?,
        _ => section.some_numbers(key)?,
    };
    match values.is_empty() {
        true => Err(section.error(key, "the list is empty", "give one number or more")),
        false => Ok(values),
    }
}

/// The array `q` or `p` of an .npz file: one state, of shape (dof) or (1, dof).
fn of_file(section: &Section, key: &'static str, folder: &Path) -> Result<Vec<f64>, ConfigError> {
    let keys = [Key::required(
        "file",
        "\"state.npz\"",
        "an .npz file with arrays q and p",
    )];
    let inner = section.subsection(key, &keys)?;
    let file = match &inner {
        Some(inner) => inner.text("file")?,
        None => String::new(),
    };
    let path = folder.join(file);
    let read = LoopFile::read_states(&path)
        .map_err(|error| section.error(key, error.to_string(), error.remedy()))?;
    let rows = match key {
        "q0" => read.states.q(),
        _ => read.states.p(),
    };
    let values: Vec<f64> = match (read.states.samples(), read.states.dof()) {
        (1, dof) => (0..dof).map(|i| rows.row(i)[0]).collect(),
        // An array with one axis.
        (_, 1) => rows.row(0).to_vec(),
        (samples, dof) => {
            return Err(section.error(
                key,
                format!(
                    "{} has {samples} states of {dof} degrees of freedom",
                    path.display()
                ),
                "give one state, the centre of the loop: arrays of shape (dof)",
            ));
        }
    };
    if let Some(inner) = inner {
        let absolute = std::path::absolute(&path).ok();
        if let Some(absolute) = absolute.as_deref().and_then(Path::to_str) {
            inner.record("file", absolute);
        }
        section.adopt(key, inner);
    }
    Ok(values)
}

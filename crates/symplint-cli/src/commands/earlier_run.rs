//! What a folder holds before a run: nothing, an earlier run, or files of others.
//!
//! A run folder is recognised by the first line of its `config.toml`.

use std::fs;
use std::io::{Error, ErrorKind};
use std::path::Path;

use serde_json::Value as Json;
use symplint_config::parse_number;
use symplint_report::report::to_json;
use symplint_report::run_folder::LOCK;

use crate::failure::OccupiedError;

/// The beginning of a `config.toml` in a run folder; the command follows.
const MARKER: &str = "# symplint run folder: ";

/// The files of `check`, `trace` and `measure` beside the configuration and the figures.
pub const RECORDS: &[&str] = &["report.json", "points.csv"];

/// How a run goes, and not what it finds: a run goes on with other values of these keys.
const NOT_OF_THE_RUN: &[&str] = &["system.workers", "system.timeout", "system.keep"];

/// The evaluations of a map that costs.
pub const JOURNAL: &str = "journal";

pub fn figure_files(name: &str) -> [String; 2] {
    ["svg", "png"].map(|extension| format!("figures/{name}.{extension}"))
}

/// The loop of a trace after so many steps.
pub fn loop_file(step: usize) -> String {
    format!("loop_{step}.csv")
}

/// The text of `config.toml` in a run folder.
pub fn config_text(command: &str, config: &toml::Table) -> String {
    format!(
        "{MARKER}{command}\n\
         # The configuration of the run with all defaults. To change it, copy it to another folder.\n\n\
         {config}"
    )
}

/// The command that wrote a `config.toml` into its run folder.
pub fn command_of(text: &str) -> Option<&str> {
    text.lines().next()?.strip_prefix(MARKER)
}

/// What a run is known by: its configuration by value, without keys that do not matter.
pub fn identity(config: &toml::Table) -> Json {
    known_by("", &serde_json::json!(config))
}

fn known_by(dotted: &str, value: &Json) -> Json {
    // Digits, which compare bit by bit.
    let digits = |number: f64| Json::from(format!("{number:?}"));
    match value {
        Json::Object(table) => {
            let keys = table
                .iter()
                .map(|(key, value)| (key, join(dotted, key), value));
            let keys = keys.filter(|(_, dotted, _)| !NOT_OF_THE_RUN.contains(&&**dotted));
            let pairs = keys.map(|(key, dotted, value)| (key.clone(), known_by(&dotted, value)));
            Json::Object(pairs.collect())
        }
        // The words of a program are no numbers.
        Json::Array(list) if dotted != "system.command" => {
            list.iter().map(|value| known_by(dotted, value)).collect()
        }
        Json::Number(number) => number.as_f64().map_or(Json::Null, digits),
        Json::String(text) => parse_number(text).map_or_else(|| value.clone(), digits),
        _ => value.clone(),
    }
}

/// The value of a number, also of one that is written as a string.
fn number(value: &toml::Value) -> Option<f64> {
    match value {
        toml::Value::Integer(number) => Some(*number as f64),
        toml::Value::Float(number) => Some(*number),
        toml::Value::String(text) => parse_number(text),
        _ => None,
    }
}

/// The run in a run folder.
pub struct EarlierRun {
    command: String,
    config: toml::Table,
}

impl EarlierRun {
    /// The run in a folder; none where the folder is new or empty.
    ///
    /// # Errors
    /// If the folder holds files that symplint did not write, or that were changed since.
    pub fn in_folder(path: &Path) -> Result<Option<Self>, OccupiedError> {
        match fs::metadata(path) {
            // Creating the folder gives the message where its parent is a file.
            Err(error)
                if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) =>
            {
                return Ok(None);
            }
            Ok(found) if !found.is_dir() => {
                let path = path.to_owned();
                return Err(OccupiedError::NotAFolder { path });
            }
            _ => {}
        }
        let mut names = entries(path)?;
        // A run that was refused leaves an empty folder of figures.
        if names.iter().any(|name| name == "figures") && is_empty_folder(&path.join("figures")) {
            names.retain(|name| name != "figures");
        }
        // A run that was killed before it noted anything leaves an empty journal.
        let is_empty = |name: &str| fs::metadata(path.join(name)).is_ok_and(|file| file.len() == 0);
        names.retain(|name| !is_no_result(name) && (name != JOURNAL || !is_empty(name)));
        let Some(first) = names.first() else {
            return Ok(None);
        };
        let foreign = |file: &str| OccupiedError::Foreign {
            folder: path.to_owned(),
            file: file.to_owned(),
        };
        if !names.iter().any(|name| name == "config.toml") {
            return Err(foreign(first));
        }
        let text = read(&path.join("config.toml"))?;
        let Some(command) = command_of(&text) else {
            return Err(foreign("config.toml"));
        };
        let edited = || OccupiedError::Edited {
            folder: path.to_owned(),
        };
        let config: toml::Table = text.parse().map_err(|_| edited())?;
        if config_text(command, &config) != text {
            return Err(edited());
        }
        // A run that failed at once leaves nothing but its configuration.
        if names == ["config.toml"] {
            return Ok(None);
        }
        let report = path.join("report.json");
        if report.exists() {
            let written: Json =
                serde_json::from_str(&read(&report)?).map_err(|_| foreign("report.json"))?;
            let is_ours =
                (written["schema"].as_str()).is_some_and(|schema| schema.starts_with("symplint/"));
            if !is_ours {
                return Err(foreign("report.json"));
            }
            // Converted to text and back, as the report was, so that numbers are rounded in the same way.
            let of_config: Json = serde_json::from_str(&to_json(&config)).unwrap_or(Json::Null);
            if known_by("", &of_config) != known_by("", &written["config"]) {
                return Err(edited());
            }
        }
        Ok(Some(EarlierRun {
            command: command.to_owned(),
            config,
        }))
    }

    /// The files that the run may have written beside `config.toml`. Those of items of the paper are not known.
    pub fn files(&self) -> Vec<String> {
        let figures: &[&str] = match self.command.as_str() {
            "check" => &["step_sizes", "samples", "loop"],
            "measure" => &["step_sizes", "loop"],
            "trace" => &["loop_integral", "energy", "loops"],
            _ => return vec!["claims.json".into(), "claims.md".into()],
        };
        let mut files: Vec<String> = RECORDS.iter().map(|&name| name.into()).collect();
        files.extend((self.command == "check").then(|| JOURNAL.to_owned()));
        files.extend(figures.iter().flat_map(|name| figure_files(name)));
        let snapshots = self
            .config
            .get("trace")
            .and_then(|trace| trace.get("snapshots"));
        let steps = snapshots
            .and_then(toml::Value::as_array)
            .filter(|_| self.command == "trace");
        let steps = steps
            .into_iter()
            .flatten()
            .filter_map(toml::Value::as_integer);
        files.extend(steps.filter_map(|step| Some(loop_file(usize::try_from(step).ok()?))));
        files
    }

    /// Checks that this is the run of `command` with `config`.
    ///
    /// # Errors
    /// If it is another run.
    pub fn check_same(
        &self,
        folder: &Path,
        command: &str,
        config: &toml::Table,
    ) -> Result<(), OccupiedError> {
        let difference = if self.command == command {
            difference("", &self.config, config)
        } else {
            Some(format!(
                "of `symplint {}`, and this is `symplint {command}`",
                self.command
            ))
        };
        match difference {
            None => Ok(()),
            Some(difference) => Err(OccupiedError::OtherRun {
                folder: folder.to_owned(),
                difference,
            }),
        }
    }
}

/// The first difference of two configurations, as text. A section that only this run has does not count: with it,
/// `reproduce` adds items.
fn difference(path: &str, there: &toml::Table, here: &toml::Table) -> Option<String> {
    let is_of_the_run = |key: &String| !NOT_OF_THE_RUN.contains(&&*join(path, key));
    for (key, there) in there.iter().filter(|(key, _)| is_of_the_run(key)) {
        let dotted = join(path, key);
        let found = match (there, here.get(key)) {
            (toml::Value::Table(there), Some(toml::Value::Table(here))) => {
                difference(&dotted, there, here)
            }
            (there, Some(here)) if same(there, here) => None,
            (there, Some(here)) => Some(format!(
                "{dotted} is {} there and {} here",
                short(there),
                short(here)
            )),
            (_, None) => Some(format!("it has {dotted}, and this run does not")),
        };
        if found.is_some() {
            return found;
        }
    }
    (here.keys())
        .find(|key| !path.is_empty() && !there.contains_key(*key) && is_of_the_run(key))
        .map(|key| format!("this run has {}, and it does not", join(path, key)))
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() {
        key.to_owned()
    } else {
        format!("{path}.{key}")
    }
}

/// A value in a few characters.
fn short(value: &toml::Value) -> String {
    const LONGEST: usize = 60;
    let text = match value {
        toml::Value::Float(number) if *number != 0.0 && !(1e-4..1e6).contains(&number.abs()) => {
            format!("{number:e}")
        }
        _ => value.to_string(),
    };
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{} …", &text[..end]),
        None => text,
    }
}

/// Whether two values are the same, also where one number is written in another way. Strings are not numbers to one another:
/// they may be words of a program. Nor is -0.0 the same as 0.0: calls differ in their bits.
fn same(one: &toml::Value, other: &toml::Value) -> bool {
    let bits = |value| number(value).map(f64::to_bits);
    match (one, other) {
        (toml::Value::String(one), toml::Value::String(other)) => one == other,
        (toml::Value::Array(one), toml::Value::Array(other)) => {
            one.len() == other.len() && one.iter().zip(other).all(|(a, b)| same(a, b))
        }
        _ => match (bits(one), bits(other)) {
            (None, None) => one == other,
            (one, other) => one == other,
        },
    }
}

/// Whether this is the lock of a run folder, or what a run left behind that was killed while it wrote one of its files.
fn is_no_result(name: &str) -> bool {
    let written = name
        .strip_prefix('.')
        .and_then(|name| name.strip_suffix(".part"));
    name == LOCK
        || written.is_some_and(|name| {
            RECORDS.contains(&name) || ["config.toml", "claims.json", "claims.md"].contains(&name)
        })
}

fn is_empty_folder(path: &Path) -> bool {
    fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_none())
}

/// The names in a folder, sorted.
fn entries(folder: &Path) -> Result<Vec<String>, OccupiedError> {
    let unreadable = |error: Error| OccupiedError::Unreadable {
        path: folder.to_owned(),
        reason: error.to_string(),
    };
    let mut names = fs::read_dir(folder)
        .map_err(unreadable)?
        .map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned()))
        .collect::<Result<Vec<String>, Error>>()
        .map_err(unreadable)?;
    names.sort();
    Ok(names)
}

fn read(path: &Path) -> Result<String, OccupiedError> {
    fs::read_to_string(path).map_err(|error| OccupiedError::Unreadable {
        path: path.to_owned(),
        reason: error.to_string(),
    })
}

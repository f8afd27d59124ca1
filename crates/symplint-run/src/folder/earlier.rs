//! Whether a folder is empty, the folder of an earlier run, or a folder with other files.
//!
//! A run folder is recognised by the first line of its `config.toml`.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use serde_json::Value;
use symplint_report::report::to_json;
use symplint_report::run_folder::LOCK;

use super::output::{figure_files, loop_file};
use crate::difference::difference;

/// The beginning of a `config.toml` in a run folder; the command follows.
const MARKER: &str = "# symplint run folder: ";

/// Why a folder is not written to.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OccupiedError {
    /// A file of the same name.
    #[error("{} is a file, not a folder", path.display())]
    NotAFolder {
        /// The path.
        path: PathBuf,
    },
    /// The folder or a file in it cannot be read.
    #[error("cannot read {}: {reason}", path.display())]
    Unreadable {
        /// The path.
        path: PathBuf,
        /// The error of the operating system.
        reason: String,
    },
    /// Files that symplint did not write.
    #[error("{} is not empty and not a run folder: symplint did not write {file}", folder.display())]
    Foreign {
        /// The folder.
        folder: PathBuf,
        /// One of the files.
        file: String,
    },
    /// A run folder that was changed by hand.
    #[error("config.toml in {} was changed after the run", folder.display())]
    Edited {
        /// The folder.
        folder: PathBuf,
    },
    /// The run of another command or configuration.
    #[error("{} holds another run: {difference}", folder.display())]
    OtherRun {
        /// The folder.
        folder: PathBuf,
        /// The first difference.
        difference: String,
    },
}

impl OccupiedError {
    /// The remedy.
    pub fn remedy(&self) -> &'static str {
        match self {
            OccupiedError::NotAFolder { .. } | OccupiedError::Unreadable { .. } => {
                "give --out a folder that is new or empty"
            }
            OccupiedError::Foreign { .. } | OccupiedError::Edited { .. } => {
                "give --out a folder that is new or empty; --force does not replace such files"
            }
            OccupiedError::OtherRun { .. } => {
                "give --out another folder, or add --force to replace that run"
            }
        }
    }
}

/// The files of `check`, `trace` and `measure` besides the configuration and the figures.
pub const RECORDS: &[&str] = &["report.json", "report.html", "points.csv"];

/// The evaluations of a costly map.
pub const JOURNAL: &str = "journal";

/// Keys that change how a run proceeds, and not its results: a run resumes with other values of them.
const NOT_OF_THE_RUN: &[&str] = &["system.workers", "system.timeout", "system.keep"];

/// Keys whose strings are never numbers.
const WORDS: &[&str] = &["system.command", "system.files"];

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

/// The configuration that identifies a run: without the keys that do not, and with numbers for strings that are numbers.
pub fn identity(config: &toml::Table, number: fn(&str) -> Option<f64>) -> Value {
    reduced("", &serde_json::json!(config), number)
}

fn reduced(path: &str, value: &Value, number: fn(&str) -> Option<f64>) -> Value {
    match value {
        Value::Object(table) => {
            let join = |key: &String| match path {
                "" => key.clone(),
                path => format!("{path}.{key}"),
            };
            let pairs = table.iter().map(|(key, value)| (key, join(key), value));
            let pairs = pairs.filter(|(_, path, _)| !NOT_OF_THE_RUN.contains(&&**path));
            let pairs =
                pairs.map(|(key, path, value)| (key.clone(), reduced(&path, value, number)));
            Value::Object(pairs.collect())
        }
        Value::Array(list) if !WORDS.contains(&path) => {
            let values = list.iter().map(|value| reduced(path, value, number));
            values.collect()
        }
        Value::String(text) => number(text).map_or_else(|| value.clone(), Value::from),
        _ => value.clone(),
    }
}

/// The run in a run folder.
pub struct EarlierRun {
    command: String,
    config: toml::Table,
    identity: Value,
}

impl EarlierRun {
    /// The run in a folder; nothing if the folder is new or empty.
    ///
    /// # Errors
    /// If the folder holds files that symplint did not write, or that were changed since.
    pub fn in_folder(
        path: &Path,
        number: fn(&str) -> Option<f64>,
    ) -> Result<Option<Self>, OccupiedError> {
        match fs::metadata(path) {
            // Creating the folder gives the message if its parent is a file.
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
        let mut names = names_in(path).map_err(|error| unreadable(path, &error))?;
        names.retain(|name| !is_no_result(path, name));
        let Some(first) = names.first() else {
            return Ok(None);
        };
        let foreign = |file: &str| OccupiedError::Foreign {
            folder: path.to_owned(),
            file: file.to_owned(),
        };
        let edited = || OccupiedError::Edited {
            folder: path.to_owned(),
        };
        if !names.iter().any(|name| name == "config.toml") {
            return Err(foreign(first));
        }
        let text = read(&path.join("config.toml"))?;
        let command = command_of(&text).ok_or_else(|| foreign("config.toml"))?;
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
            let written = serde_json::from_str(&read(&report)?).unwrap_or(Value::Null);
            let is_ours =
                (written["schema"].as_str()).is_some_and(|schema| schema.starts_with("symplint/"));
            if !is_ours {
                return Err(foreign("report.json"));
            }
            // Converted to text and back, as the report was, so that numbers are rounded in the same way.
            let of_config = serde_json::from_str(&to_json(&config)).unwrap_or(Value::Null);
            if difference("", &of_config, &written["config"]).is_some() {
                return Err(edited());
            }
        }
        Ok(Some(EarlierRun {
            command: command.to_owned(),
            identity: identity(&config, number),
            config,
        }))
    }

    /// The files that the run may have written besides `config.toml`. Those of items of the paper are not known.
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
        let snapshots = (self.config.get("trace")).and_then(|trace| trace.get("snapshots"));
        let steps = snapshots
            .and_then(toml::Value::as_array)
            .filter(|_| self.command == "trace");
        let steps = (steps.into_iter().flatten()).filter_map(toml::Value::as_integer);
        files.extend(steps.filter_map(|step| Some(loop_file(usize::try_from(step).ok()?))));
        files
    }

    /// Checks that this is the run of `command` with a configuration of this identity. A section that only the new run has is not a
    /// difference: with it, `reproduce` adds items.
    ///
    /// # Errors
    /// If it is another run.
    pub fn check_same(
        &self,
        folder: &Path,
        command: &str,
        identity: &Value,
    ) -> Result<(), OccupiedError> {
        let mut here = identity.clone();
        if let (Value::Object(here), Value::Object(there)) = (&mut here, &self.identity) {
            here.retain(|key, _| there.contains_key(key));
        }
        let difference = match self.command == command {
            true => difference("", &self.identity, &here),
            false => Some(format!(
                "of `symplint {}`, and this is `symplint {command}`",
                self.command
            )),
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

/// Whether a file is not a result: the lock of a run folder, and the files of a run that was refused or killed at once.
fn is_no_result(folder: &Path, name: &str) -> bool {
    let is_empty = || fs::metadata(folder.join(name)).is_ok_and(|file| file.len() == 0);
    let part = name
        .strip_prefix('.')
        .and_then(|name| name.strip_suffix(".part"));
    let is_written = |name: &str| {
        RECORDS.contains(&name) || ["config.toml", "claims.json", "claims.md"].contains(&name)
    };
    match name {
        LOCK => true,
        JOURNAL => is_empty(),
        "figures" => names_in(&folder.join(name)).is_ok_and(|names| names.is_empty()),
        _ => part.is_some_and(is_written),
    }
}

/// The names in a folder, sorted.
fn names_in(folder: &Path) -> io::Result<Vec<String>> {
    let names = fs::read_dir(folder)?;
    let names = names.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned()));
    let mut names = names.collect::<io::Result<Vec<String>>>()?;
    names.sort();
    Ok(names)
}

fn read(path: &Path) -> Result<String, OccupiedError> {
    fs::read_to_string(path).map_err(|error| unreadable(path, &error))
}

fn unreadable(path: &Path, error: &io::Error) -> OccupiedError {
    OccupiedError::Unreadable {
        path: path.to_owned(),
        reason: error.to_string(),
    }
}

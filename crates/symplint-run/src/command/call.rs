//! One call: writes the states, runs the program, reads what it made of them.

use std::fs;
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::Duration;

use symplint::{Coordinates, Ensemble, Snapshot, StepFailure};
use symplint_files::{LoopFile, LoopFileError};

use super::CallsError;
use super::process::{ProcessEnd, run};
use super::workspace::Workspace;

/// Why a call has no result.
pub enum CallFailure {
    /// The program failed: a failure of the map.
    Program(StepFailure),
    /// The call could not be made.
    Calls(CallsError),
}

impl From<CallsError> for CallFailure {
    fn from(error: CallsError) -> Self {
        CallFailure::Calls(error)
    }
}

/// The status of a shell whose last program was killed.
const OF_KILLED_SHELL: i32 = 128 + 9;

/// The program of a call, and its folder.
pub struct Program {
    /// The program and its arguments, with placeholders.
    pub command: Vec<String>,
    /// The folder in which it is run.
    pub folder: PathBuf,
    /// How it reads and writes states.
    pub format: FileFormat,
}

/// The format of the files that a program reads and writes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FileFormat {
    /// Archives of arrays, as numpy writes them.
    #[default]
    Npz,
    /// One line, and little-endian doubles: for programs without libraries.
    Raw,
    /// One line, and decimals.
    Text,
}

impl FileFormat {
    /// The names of the formats, in their order.
    pub const NAMES: [&str; 3] = ["npz", "raw", "text"];

    /// The format of this name.
    pub fn named(name: &str) -> Option<Self> {
        let formats = [FileFormat::Npz, FileFormat::Raw, FileFormat::Text];
        let mut named = Self::NAMES.into_iter().zip(formats);
        named
            .find(|(other, _)| *other == name)
            .map(|(_, format)| format)
    }

    /// The ending of the names of its files.
    fn extension(self) -> &'static str {
        match self {
            FileFormat::Npz => "npz",
            FileFormat::Raw => "raw",
            FileFormat::Text => "txt",
        }
    }
}

/// A call of a program with a step size.
pub struct Call<'a> {
    pub program: &'a Program,
    pub coordinates: &'a Coordinates,
    pub timeout: Duration,
    pub h: f64,
}

impl Call<'_> {
    /// The result of one call for `states`.
    ///
    /// # Errors
    /// If a file cannot be written or opened, or the program fails or writes anything but the same states advanced. The
    /// sample is the first of the call, unless another one is known.
    pub fn advance(
        &self,
        workspace: &Workspace,
        states: Ensemble,
    ) -> Result<Ensemble, CallFailure> {
        let folder = workspace.folder_of_call()?;
        let path = |name: &str| folder.path().join(name);
        let file = |name: &str| path(&format!("{name}.{}", self.program.format.extension()));
        let (before, after) = (self.before(file("before"), states), file("after"));
        let streams = [path("error.txt"), path("output.txt")];
        before.write().map_err(|error| match error {
            LoopFileError::Write { path, reason } => CallsError::of_file(&path, &reason),
            other => CallsError::of_file(&before.path, &other),
        })?;
        let mut ended = self.run(&before.path, &after, &streams)?;
        let is_killed = |ended: &ProcessEnd| match ended {
            ProcessEnd::Exited(status) => status.code().is_none_or(|code| code == OF_KILLED_SHELL),
            ProcessEnd::Killed => false,
        };
        if is_killed(&ended) {
            // As by a system whose memory runs out: that may pass.
            ended = self.run(&before.path, &after, &streams)?;
        }
        let wrong = match ended {
            ProcessEnd::Killed => Some(format!(
                "did not end within {} s and was stopped (system.timeout)",
                self.timeout.as_secs_f64()
            )),
            ProcessEnd::Exited(status) if !status.success() => Some(format!("ended with {status}")),
            // A FIFO would be waited for without a time limit.
            ProcessEnd::Exited(_) => match fs::metadata(&after) {
                Err(_) => Some("did not write {after}, the file that system.command names (--keep keeps the files of all calls)".to_owned()),
                Ok(there) if !there.is_file() => {
                    Some("wrote {after}, which is not a regular file".to_owned())
                }
                Ok(_) => None,
            },
        };
        if let Some(wrong) = wrong {
            if !before.path.exists() {
                let action = format!("read {}", before.path.display());
                return Err(CallsError::system(&action, &"it was removed meanwhile").into());
            }
            return Err(self.failed(0, &wrong, &streams));
        }
        fs::File::open(&after)
            .map_err(|error| CallsError::system(&format!("open {}", after.display()), &error))?;
        let read = LoopFile::read_states(&after).and_then(|read| {
            read.check_same_loop(&before)?;
            Ok(read.states)
        });
        read.map_err(|error| {
            let sample = match &error {
                LoopFileError::NotFinite { sample, .. } => *sample,
                _ => 0,
            };
            let words = in_words(&error, [(&*before.path, "{before}"), (&*after, "{after}")]);
            let wrong = format!("wrote a file that cannot be used: {words}");
            self.failed(sample, &wrong, &streams)
        })
    }

    /// Runs the program once.
    fn run(
        &self,
        before: &Path,
        after: &Path,
        [error, output]: &[PathBuf; 2],
    ) -> Result<ProcessEnd, CallsError> {
        let create = |path: &PathBuf| {
            let created = fs::File::create(path);
            created.map_err(|error| CallsError::of_file(path, &error))
        };
        let words = self.words(before, after)?;
        let files = [create(output)?, create(error)?];
        run(&words, &self.program.folder, files, self.timeout).map_err(|error| match error.kind() {
            ErrorKind::NotFound => CallsError::NoProgram {
                program: words[0].clone(),
            },
            ErrorKind::PermissionDenied => CallsError::NotExecutable {
                program: words[0].clone(),
            },
            _ => CallsError::system(&format!("run `{}`", words[0]), &error),
        })
    }

    fn before(&self, path: PathBuf, states: Ensemble) -> LoopFile {
        let of_each = |value: &dyn Fn(usize) -> f64| (0..states.dof()).map(value).collect();
        LoopFile {
            path,
            unit_roundoff: Snapshot::DOUBLE,
            step_size: Some(self.h),
            period: Some(of_each(&|i| self.coordinates.period(i))),
            momentum_period: None,
            weight: Some(of_each(&|i| self.coordinates.weight(i))),
            states,
        }
    }

    /// The command with the names of the files and the step size.
    fn words(&self, before: &Path, after: &Path) -> Result<Vec<String>, CallsError> {
        let text = |path: &Path| {
            let text = path.to_str().map(str::to_owned);
            text.ok_or_else(|| CallsError::of_file(path, &"its name is not Unicode"))
        };
        let (before, after) = (text(before)?, text(after)?);
        // The shortest digits that give the same double.
        let h = format!("{:?}", self.h);
        let values = [("{before}", &*before), ("{after}", &*after), ("{h}", &*h)];
        let words = self.program.command.iter();
        Ok(words.map(|word| substitute(word, &values)).collect())
    }

    /// The failure of a sample, with the last words of the program.
    fn failed(&self, sample: usize, wrong: &str, streams: &[PathBuf; 2]) -> CallFailure {
        let program = &self.program.command[0];
        let names = ["standard error", "standard output"].into_iter();
        let said = names.zip(streams).find_map(|(name, path)| {
            let text = last_lines(path)?;
            Some(format!("; its {name}:\n{text}"))
        });
        let reason = format!("`{program}` {wrong}{}", said.unwrap_or_default());
        CallFailure::Program(StepFailure { sample, reason })
    }
}

/// Replaces each name by its value, in one pass: values are not searched again.
fn substitute(word: &str, values: &[(&str, &str)]) -> String {
    let mut result = String::new();
    let mut rest = word;
    'search: while !rest.is_empty() {
        for (name, value) in values {
            if let Some(after) = rest.strip_prefix(name) {
                result += value;
                rest = after;
                continue 'search;
            }
        }
        let (first, after) = rest.split_at(rest.chars().next().map_or(0, char::len_utf8));
        result += first;
        rest = after;
    }
    result
}

/// The error of a file, by the names that files have in the command: they are removed when the call ends.
fn in_words(error: &LoopFileError, files: [(&Path, &str); 2]) -> String {
    let mut text = error.to_string();
    for (path, name) in files {
        text = text.replace(&path.display().to_string(), name);
    }
    format!("{text}; {}", error.remedy())
}

/// The last lines of a file, if there is anything in it.
fn last_lines(path: &Path) -> Option<String> {
    const LINES: usize = 20;
    const BYTES: u64 = 4000;
    let mut file = fs::File::open(path).ok()?;
    let length = file.metadata().ok()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(BYTES)))
        .ok()?;
    let mut bytes = Vec::new();
    file.take(BYTES).read_to_end(&mut bytes).ok()?;
    let text = String::from_utf8_lossy(&bytes);
    let lines: Vec<&str> = text.trim_end().lines().collect();
    let last = &lines[lines.len().saturating_sub(LINES)..];
    let shown: Vec<String> = last.iter().map(|line| format!("  {line}")).collect();
    (!last.is_empty()).then(|| shown.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn placeholders_are_replaced_anywhere_and_once() {
        let values = [("{before}", "/tmp/{h}"), ("{h}", "0.5")];
        assert_eq!(
            substitute("--in={before},{h}", &values),
            "--in=/tmp/{h},0.5"
        );
        assert_eq!(substitute("{x} {{h}}", &values), "{x} {0.5}");
        assert_eq!(substitute("α{h}", &values), "α0.5");
    }
}

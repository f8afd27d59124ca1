//! One call: writes the states, runs the program, reads what it made of them.

use std::fs;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::process::ExitStatus;
use std::time::Duration;

use symplint::{Coordinates, Ensemble, Snapshot, StepFailure};
use symplint_report::loop_file::{LoopFile, LoopFileError};

use crate::lack::{CallFailure, Lack, missing_space};
use crate::process::{Ended, NotRun, Streams, run};
use crate::workspace::{CallFolder, Workspace};

/// What is run, and where.
pub struct Program {
    /// The program and its arguments, with placeholders.
    pub command: Vec<String>,
    /// The folder in which it is run.
    pub folder: PathBuf,
}

/// A call of a program with a step size.
pub struct Call<'a> {
    pub program: &'a Program,
    pub coordinates: &'a Coordinates,
    pub timeout: Duration,
    pub h: f64,
}

impl Call<'_> {
    /// What one call makes of `states`.
    ///
    /// # Errors
    /// If a file cannot be written or read, or the program fails or writes anything but the same states advanced. The
    /// sample is the first of the call, unless another one is known.
    pub fn advance(
        &self,
        workspace: &Workspace,
        states: Ensemble,
    ) -> Result<Ensemble, CallFailure> {
        let folder = workspace.folder_of_call()?;
        let path = |name: &str| folder.path().join(name);
        let before = self.before(path("before.npz"), states);
        before.write().map_err(|error| match error {
            LoopFileError::Write { path, reason } => Lack::of_file(&path, &reason),
            other => Lack::of_file(&before.path, &other),
        })?;
        let bytes = || fs::metadata(&before.path).ok().map(|file| file.len());
        let written = bytes();
        self.run(&folder, &before).map_err(|failure| match failure {
            CallFailure::Program(failure) => match (written, bytes()) {
                (Some(written), Some(now)) if now == written => {
                    of_full_disk(failure, folder.path(), written)
                }
                _ => CallFailure::Lack(Lack::Removed {
                    failure: failure.reason,
                    path: before.path.clone(),
                }),
            },
            lack @ CallFailure::Lack(_) => lack,
        })
    }

    /// Runs the program on a file in the folder of the call.
    fn run(&self, folder: &CallFolder, before: &LoopFile) -> Result<Ensemble, CallFailure> {
        let refused = |reason: String| CallFailure::Program(StepFailure { sample: 0, reason });
        let path = |name: &str| folder.path().join(name);
        let after = path("after.npz");
        let streams = Streams {
            output: path("output.txt"),
            error: path("error.txt"),
        };
        let words = self.words(&before.path, &after)?;
        let run = || {
            let ended = run(&words, &self.program.folder, &streams, self.timeout);
            ended.map_err(|error| match error {
                NotRun::Command(reason) => refused(self.failed(&reason, &streams)),
                NotRun::Lack(lack) => lack.into(),
            })
        };
        let mut ended = run()?;
        // As by a system whose memory runs out: that may pass.
        if matches!(ended, Ended::Exited(status) if was_killed(status)) {
            ended = run()?;
        }
        let wrong = match ended {
            Ended::TimedOut => Some(format!(
                "did not end within {} s and was stopped (system.timeout)",
                self.timeout.as_secs_f64()
            )),
            Ended::Exited(status) if at_limit_of_files(status) => {
                return Err(Lack::Space {
                    failure: self.failed(&format!("ended with {status}"), &streams),
                    folder: None,
                    reason: "the limit of file sizes (`ulimit -f`)".to_owned(),
                }
                .into());
            }
            Ended::Exited(status) if !status.success() => Some(format!("ended with {status}")),
            // A FIFO would be waited for without a time limit.
            Ended::Exited(_) => match fs::metadata(&after) {
                Err(_) => Some("wrote no {after}".to_owned()),
                Ok(there) if !there.is_file() => {
                    Some("made something of {after} that is no regular file".to_owned())
                }
                Ok(_) => None,
            },
        };
        if let Some(wrong) = wrong {
            return Err(refused(self.failed(&wrong, &streams)));
        }
        let read = LoopFile::read_states(&after).and_then(|read| {
            read.check_same_loop(before)?;
            Ok(read.states)
        });
        read.map_err(|error| {
            if let LoopFileError::Read { path, reason } = &error
                && let Some(lack) = Lack::of_open_files(path, reason)
            {
                return lack.into();
            }
            CallFailure::Program(StepFailure {
                sample: match &error {
                    LoopFileError::NotFinite { sample, .. } => *sample,
                    _ => 0,
                },
                reason: {
                    let files = [(&*before.path, "{before}"), (&*after, "{after}")];
                    let words = in_words(&error, files);
                    self.failed(
                        &format!("wrote a file that cannot be used: {words}"),
                        &streams,
                    )
                },
            })
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
    fn words(&self, before: &Path, after: &Path) -> Result<Vec<String>, Lack> {
        let text = |path: &Path| {
            path.to_str().map(str::to_owned).ok_or_else(|| Lack::Name {
                path: path.to_owned(),
            })
        };
        let (before, after) = (text(before)?, text(after)?);
        // The shortest digits that give the same double.
        let h = format!("{:?}", self.h);
        Ok((self.program.command.iter())
            .map(|word| {
                substitute(
                    word,
                    &[("{before}", &before), ("{after}", &after), ("{h}", &h)],
                )
            })
            .collect())
    }

    /// What went wrong, with what the program said last.
    fn failed(&self, wrong: &str, streams: &Streams) -> String {
        let program = &self.program.command[0];
        let said = [
            ("standard error", &streams.error),
            ("standard output", &streams.output),
        ];
        let said = said.into_iter().find_map(|(name, path)| {
            let text = last_lines(path)?;
            Some(format!("; its {name}:\n{text}"))
        });
        format!("`{program}` {wrong}{}", said.unwrap_or_default())
    }
}

/// Whether a process was killed, or says so of the last one that it ran, as shells do.
fn was_killed(status: ExitStatus) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::process::ExitStatusExt;
        let kill = rustix::process::Signal::KILL.as_raw();
        status.signal() == Some(kill) || status.code() == Some(128 + kill)
    }
    #[cfg(not(unix))]
    {
        let _ = status;
        false
    }
}

/// Whether a process was ended because its files may not grow.
fn at_limit_of_files(status: ExitStatus) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::process::ExitStatusExt;
        status.signal() == Some(rustix::process::Signal::XFSZ.as_raw())
    }
    #[cfg(not(unix))]
    {
        let _ = status;
        false
    }
}

/// The failure of a program; that of the disk where it has no space for what the program had to write, about as much as what it
/// read.
fn of_full_disk(failure: StepFailure, folder: &Path, bytes: u64) -> CallFailure {
    match missing_space(folder, bytes.max(4096)) {
        Some(error) => CallFailure::Lack(Lack::Space {
            failure: failure.reason,
            folder: Some(folder.to_owned()),
            reason: error.to_string(),
        }),
        None => CallFailure::Program(failure),
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

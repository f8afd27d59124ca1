//! A process with a time limit, in a group of its own: what it starts ends with it.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

#[cfg(unix)]
use rustix::io::Errno;
#[cfg(unix)]
use rustix::process::{Pid, Signal, WaitId, WaitIdOptions, kill_process_group, waitid};

use crate::lack::{Lack, is_lack};
use crate::running::Running;

/// Files for what a process writes.
pub struct Streams {
    pub output: PathBuf,
    pub error: PathBuf,
}

/// How a process ended. What it had started and left behind was killed then.
pub enum Ended {
    /// By itself.
    Exited(ExitStatus),
    /// It was killed after the time limit.
    TimedOut,
}

/// Why a process did not run.
pub enum NotRun {
    /// It cannot be started, in words that follow its name.
    Command(String),
    /// The system could not do its part.
    Lack(Lack),
}

/// How long to sleep between two looks at a process: short at first, so that fast programs lose little, and never
/// much beside the limit of 200 ms a call.
const POLLS: [Duration; 2] = [Duration::from_micros(500), Duration::from_millis(2)];

/// Runs a command in `folder`.
///
/// # Errors
/// If it cannot be started, or not be waited for.
pub fn run(
    words: &[String],
    folder: &Path,
    streams: &Streams,
    timeout: Duration,
) -> Result<Ended, NotRun> {
    let create = |path: &Path| {
        let created = File::create(path);
        created.map_err(|error| NotRun::Lack(Lack::of_file(path, &error)))
    };
    let lack = |action: &str, error: &io::Error| {
        NotRun::Lack(Lack::Resource {
            action: format!("{action} `{}`", words[0]),
            reason: error.to_string(),
        })
    };
    let mut command = Command::new(&words[0]);
    command
        .args(&words[1..])
        .stdin(Stdio::null())
        .stdout(create(&streams.output)?)
        .stderr(create(&streams.error)?);
    if folder != Path::new("") {
        command.current_dir(folder);
    }
    own_group(&mut command);
    end_with_this_program(&mut command);
    let child = Running::spawn(&mut command).map_err(|error| match is_lack(&error) {
        true => lack("start", &error),
        false => NotRun::Command(format!(
            "could not be started: {error}; check system.command"
        )),
    })?;
    let started = Instant::now();
    let mut poll = POLLS[0];
    let ended = loop {
        match end(&mut child.process()) {
            Err(error) => break Err(lack("wait for", &error)),
            Ok(Some(status)) => break Ok(Ended::Exited(status)),
            Ok(None) => {}
        }
        let left = timeout.saturating_sub(started.elapsed());
        if left.is_zero() {
            kill_group(&mut child.process());
            let _ = child.process().wait();
            break Ok(Ended::TimedOut);
        }
        std::thread::sleep(poll.min(left));
        poll = (2 * poll).min(POLLS[1]);
    };
    drop(child);
    ended
}

/// Starts the process as the leader of a group.
fn own_group(command: &mut Command) {
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    #[cfg(not(unix))]
    let _ = command;
}

/// Ends the process where this program is killed, which otherwise nobody would wait for: by the kernel, on Linux.
fn end_with_this_program(command: &mut Command) {
    #[cfg(target_os = "linux")]
    {
        use std::os::unix::process::CommandExt;

        let here = rustix::process::getpid();
        let end = move || {
            rustix::process::set_parent_process_death_signal(Some(Signal::KILL))?;
            // Where this program was killed before, no signal comes.
            match rustix::process::getppid() {
                Some(parent) if parent == here => Ok(()),
                _ => Err(Errno::SRCH.into()),
            }
        };
        // SAFETY: the closure makes two system calls, which may be made between fork and exec, and takes no lock and no memory.
        // The signal comes when the thread that starts the process ends, and this thread waits for the process.
        unsafe { command.pre_exec(end) };
    }
    #[cfg(not(target_os = "linux"))]
    let _ = command;
}

/// The status of a process that has ended, whose group is killed then.
fn end(child: &mut Child) -> io::Result<Option<ExitStatus>> {
    // Before the process is waited for: then the number of its group may be that of another.
    #[cfg(unix)]
    if let Some(group) = group(child)
        && has_ended(group)? == Some(true)
    {
        let _ = kill_process_group(group, Signal::KILL);
    }
    child.try_wait()
}

/// Kills a process that was not waited for, with all that it started.
pub fn kill_group(child: &mut Child) {
    #[cfg(unix)]
    if let Some(group) = group(child)
        && matches!(has_ended(group), Ok(Some(_)))
    {
        let _ = kill_process_group(group, Signal::KILL);
    }
    // Also where there are no groups.
    let _ = child.kill();
}

/// The group of a process.
#[cfg(unix)]
fn group(child: &Child) -> Option<Pid> {
    i32::try_from(child.id()).ok().and_then(Pid::from_raw)
}

/// Whether a process has ended; nothing of one that was waited for.
#[cfg(unix)]
fn has_ended(process: Pid) -> io::Result<Option<bool>> {
    let look = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
    match waitid(WaitId::Pid(process), look) {
        Ok(found) => Ok(Some(found.is_some())),
        Err(Errno::CHILD) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

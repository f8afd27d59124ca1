//! A process with a time limit, in its own group: the processes that it starts end with it.

use std::fs::File;
use std::io;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use super::stop::is_stopped;

/// How a process ended. The processes that it left behind were killed then.
pub enum ProcessEnd {
    /// By itself.
    Exited(ExitStatus),
    /// It was killed after the time limit, or because this program ends.
    Killed,
}

/// Times to sleep between two looks at a process: short at first, so that fast programs lose little, and never much compared with
/// the limit of 200 ms a call.
const POLLS: [Duration; 2] = [Duration::from_micros(500), Duration::from_millis(2)];

/// Runs a command in `folder`, with files for its standard output and error.
///
/// # Errors
/// If it cannot be started, or not be waited for.
pub fn run(
    words: &[String],
    folder: &Path,
    [output, error]: [File; 2],
    timeout: Duration,
) -> io::Result<ProcessEnd> {
    let mut command = Command::new(&words[0]);
    command.args(&words[1..]).stdin(Stdio::null());
    command.stdout(output).stderr(error);
    if folder != Path::new("") {
        command.current_dir(folder);
    }
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    end_with_this_program(&mut command);
    let mut child = command.spawn()?;
    let started = Instant::now();
    let mut poll = POLLS[0];
    loop {
        if has_ended(&mut child)? {
            // Before the process is waited for: after that the number of its group may be that of another one.
            kill_group(&mut child);
            return Ok(ProcessEnd::Exited(child.wait()?));
        }
        let left = timeout.saturating_sub(started.elapsed());
        if left.is_zero() || is_stopped() {
            kill_group(&mut child);
            child.wait()?;
            return Ok(ProcessEnd::Killed);
        }
        std::thread::sleep(poll.min(left));
        poll = (2 * poll).min(POLLS[1]);
    }
}

/// Ends the process if this program is killed and can no longer wait for it: the kernel does this, on Linux.
fn end_with_this_program(command: &mut Command) {
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{Signal, getpid, getppid, set_parent_process_death_signal};
        use std::os::unix::process::CommandExt;

        let here = getpid();
        let end = move || {
            set_parent_process_death_signal(Some(Signal::KILL))?;
            // If this program was killed before, no signal comes.
            match getppid() {
                Some(parent) if parent == here => Ok(()),
                _ => Err(rustix::io::Errno::SRCH.into()),
            }
        };
        // SAFETY: the closure makes two system calls, which may be made between fork and exec, and takes no lock and no memory.
        // The signal comes when the thread that starts the process ends, and this thread waits for the process.
        unsafe { command.pre_exec(end) };
    }
    #[cfg(not(target_os = "linux"))]
    let _ = command;
}

/// Whether a process has ended; it is not waited for then.
fn has_ended(child: &mut Child) -> io::Result<bool> {
    #[cfg(unix)]
    {
        use rustix::process::{WaitId, WaitIdOptions, waitid};
        let look = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        Ok(waitid(WaitId::Pid(group(child)), look)?.is_some())
    }
    #[cfg(not(unix))]
    Ok(child.try_wait()?.is_some())
}

/// Kills a process that was not waited for, with all that it started.
fn kill_group(child: &mut Child) {
    #[cfg(unix)]
    let _ = rustix::process::kill_process_group(group(child), rustix::process::Signal::KILL);
    // Also on systems without groups.
    let _ = child.kill();
}

/// The group of a process, which has its number.
#[cfg(unix)]
fn group(child: &Child) -> rustix::process::Pid {
    rustix::process::Pid::from_child(child)
}

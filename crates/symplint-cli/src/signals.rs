//! What ends the program from outside: Ctrl-C, `kill`, a terminal that is closed.

use std::path::Path;
#[cfg(unix)]
use std::sync::{Arc, atomic::AtomicBool};
use std::sync::{OnceLock, mpsc};
use std::time::Duration;

use crate::output::{go_on, tell};

/// The exit status of a program that was interrupted.
const INTERRUPTED: i32 = 130;

/// How long to wait for standard error: a pipe without a reader accepts no text.
const TO_TELL: Duration = Duration::from_secs(1);

/// The results that a run keeps if a signal ends it, and how to continue.
static KEPT: OnceLock<String> = OnceLock::new();

/// From now on the run in this folder can be resumed.
pub fn note_folder(path: &Path) {
    let resume = go_on("resume", path);
    let _ = KEPT.set(format!(
        "all finished calls are kept: `{resume}` continues from them"
    ));
}

/// From now on the points of the run are written to a folder, and its evaluations are not.
pub fn note_points(path: &Path) {
    let _ = KEPT.set(format!(
        "the points measured so far are in {}; the same command starts again from the beginning",
        path.join("points.csv").display()
    ));
}

/// From now on the run has something to lose, and no folder to keep it in.
pub fn note_nothing() {
    let _ = KEPT.set("nothing is kept; with --out DIR, results are written as they come".into());
}

/// From now on this part of the round of calls in a folder can be continued.
pub fn note_part(path: &Path, (k, n): (usize, usize)) {
    let advance = go_on("advance", path);
    let _ = KEPT.set(format!(
        "`{advance} --part {k}/{n}` continues, and repeats no finished call"
    ));
}

/// Ends the programs that are called as maps and removes their files, then ends this program.
fn end() {
    symplint_run::stop_all();
    if let Some(kept) = KEPT.get() {
        let (said, heard) = mpsc::channel();
        let say = move || {
            tell(format!("\nstopped; {kept}"));
            let _ = said.send(());
        };
        if std::thread::Builder::new().spawn(say).is_ok() {
            let _ = heard.recv_timeout(TO_TELL);
        }
    }
    std::process::exit(INTERRUPTED);
}

/// Does so at signals, but for those that this program was started to ignore, as by `nohup`. If it cannot, the signals end
/// this program, which then cleans up at its next run.
#[cfg(unix)]
pub fn handle() {
    use signal_hook::consts::{SIGCHLD, SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    // At a limit of file sizes the write fails, with a message, and what was written before is kept.
    let _ = signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
    // If this signal is ignored, the system forgets how programs ended.
    if ignores(SIGCHLD) {
        let _ = signal_hook::flag::register(SIGCHLD, Arc::new(AtomicBool::new(false)));
    }
    let heeded = [SIGINT, SIGTERM, SIGHUP]
        .into_iter()
        .filter(|&signal| !ignores(signal));
    if let Ok(mut signals) = signal_hook::iterator::Signals::new(heeded) {
        std::thread::spawn(move || signals.forever().take(1).for_each(|_| end()));
    }
}

/// Whether this program was started to ignore a signal. If this cannot be determined, only SIGHUP and SIGCHLD count as ignored.
#[cfg(unix)]
fn ignores(signal: i32) -> bool {
    use signal_hook::consts::{SIGCHLD, SIGHUP};
    // Linux says it in hexadecimal digits, the signal 1 in the last bit.
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let digits = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    match digits.and_then(|digits| u64::from_str_radix(digits.trim(), 16).ok()) {
        Some(ignored) => ignored >> (signal - 1) & 1 == 1,
        None => matches!(signal, SIGHUP | SIGCHLD),
    }
}

/// Does so at Ctrl-C. If it cannot, Ctrl-C ends this program, which then cleans up at its next run.
#[cfg(not(unix))]
pub fn handle() {
    let _ = ctrlc::set_handler(end);
}

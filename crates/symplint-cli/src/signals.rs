//! What ends the program from outside: Ctrl-C, `kill`, a terminal that is closed.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;
#[cfg(unix)]
use std::sync::{Arc, atomic::AtomicBool};

/// The exit status of a program that was interrupted.
const INTERRUPTED: i32 = 130;

/// The folder of a run that can be resumed.
static FOLDER: OnceLock<PathBuf> = OnceLock::new();

/// From now on the run in this folder can be resumed.
pub fn note_folder(path: &Path) {
    let _ = FOLDER.set(path.to_owned());
}

/// Ends the programs that are called as maps and removes their files, then ends this program.
fn end() {
    symplint_command::stop_all();
    if let Some(folder) = FOLDER.get() {
        anstream::eprintln!("\nstopped; `symplint resume {}` goes on", folder.display());
    }
    std::process::exit(INTERRUPTED);
}

/// Does so at signals, but for those that this program was started to ignore, as by `nohup`. Where it cannot, the signals end
/// this program, which then cleans up at its next run.
#[cfg(unix)]
pub fn handle() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    // At a limit of file sizes the write fails, with a message, and what was written before is kept.
    let _ = signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
    let heeded = [SIGINT, SIGTERM, SIGHUP]
        .into_iter()
        .filter(|&signal| !ignores(signal));
    if let Ok(mut signals) = signal_hook::iterator::Signals::new(heeded) {
        std::thread::spawn(move || signals.forever().take(1).for_each(|_| end()));
    }
}

/// Whether this program was started to ignore a signal. What cannot be found out counts as ignored for SIGHUP alone.
#[cfg(unix)]
fn ignores(signal: i32) -> bool {
    // Linux says it in hexadecimal digits, the signal 1 in the last bit.
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let digits = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    match digits.and_then(|digits| u64::from_str_radix(digits.trim(), 16).ok()) {
        Some(ignored) => ignored >> (signal - 1) & 1 == 1,
        None => signal == signal_hook::consts::SIGHUP,
    }
}

/// Does so at Ctrl-C. Where it cannot, that ends this program, which then cleans up at its next run.
#[cfg(not(unix))]
pub fn handle() {
    let _ = ctrlc::set_handler(end);
}

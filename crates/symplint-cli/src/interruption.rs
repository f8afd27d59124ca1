//! What happens where the user, or the system, ends the program by a signal.

use std::path::{Path, PathBuf};
use std::process::exit;
use std::sync::OnceLock;

/// The exit status of a program that was interrupted.
const INTERRUPTED: i32 = 130;

/// The folder of a run that can be resumed.
static FOLDER: OnceLock<PathBuf> = OnceLock::new();

/// From now on the run in this folder can be resumed.
pub fn note_folder(path: &Path) {
    let _ = FOLDER.set(path.to_owned());
}

/// Ends the program by the signals that a user or a scheduler sends: programs that are called as maps are ended, and their
/// files removed. Without a handler the signals end this program, which then cleans up at its next run.
pub fn handle() {
    let _ = ctrlc::set_handler(|| {
        symplint_command::stop_all();
        if let Some(folder) = FOLDER.get() {
            anstream::eprintln!("\nstopped; `symplint resume {}` goes on", folder.display());
        }
        exit(INTERRUPTED);
    });
}

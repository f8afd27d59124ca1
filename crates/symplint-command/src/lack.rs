//! Why a call could not be made, where that is no failure of the program: it says nothing of the map.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use symplint::StepFailure;

/// What this program, or the system, could not do for a call. The run ends then: the next calls would fail likewise.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Lack {
    /// A file or folder of a call.
    #[error(
        "cannot write {}: {reason}; free space there, or name another folder by TMPDIR or --keep. The call says nothing of the \
         map: calls noted before are kept, and the same command goes on from them",
        path.display()
    )]
    File {
        /// The file, or the folder in which it could not be made.
        path: PathBuf,
        /// The error of the operating system.
        reason: String,
    },
    /// No space is left for what a program writes, which failed.
    #[error(
        "{failure}; files may not grow{}: {reason}. That says nothing of the map: calls noted before are kept, and the same \
         command goes on from them once the cause is gone",
        folder.as_ref().map_or(String::new(), |folder| format!(" in {}", folder.display()))
    )]
    Space {
        /// What became of the program.
        failure: String,
        /// The folder of its files, where it is that.
        folder: Option<PathBuf>,
        /// The error of the operating system.
        reason: String,
    },
    /// The file that a program had to read, which failed.
    #[error(
        "{failure}; meanwhile {} was removed or changed: leave it alone, or name another folder by TMPDIR or --keep, and let the \
         program write nothing but {{after}}. That says nothing of the map: calls noted before are kept, and the same command goes \
         on from them",
        path.display()
    )]
    Removed {
        /// What became of the program.
        failure: String,
        /// The file.
        path: PathBuf,
    },
    /// A process, or a file to be opened.
    #[error(
        "cannot {action}: {reason}; end other processes, set system.workers to less, or raise the limits (`ulimit -a`). The call \
         says nothing of the map: calls noted before are kept, and the same command goes on from them"
    )]
    Resource {
        /// What was tried.
        action: String,
        /// The error of the operating system.
        reason: String,
    },
    /// The program could not be told the names of the files.
    #[error("the name of the folder of calls is not Unicode: {}; set TMPDIR to another one", path.display())]
    Name {
        /// The folder.
        path: PathBuf,
    },
}

impl Lack {
    /// That of a file or folder that cannot be written.
    pub(crate) fn of_file(path: &Path, error: &impl ToString) -> Self {
        let reason = error.to_string();
        Lack::of_open_files(path, &reason).unwrap_or_else(|| Lack::File {
            path: path.to_owned(),
            reason,
        })
    }

    /// That of a file that cannot be opened, where the reason is that too many are open.
    pub(crate) fn of_open_files(path: &Path, reason: &str) -> Option<Self> {
        says_too_many_files(reason).then(|| Lack::Resource {
            action: format!("open {}", path.display()),
            reason: reason.to_owned(),
        })
    }
}

/// Why a call has no result.
pub enum CallFailure {
    /// The program failed: a failure of the map.
    Program(StepFailure),
    /// The call could not be made.
    Lack(Lack),
}

impl From<Lack> for CallFailure {
    fn from(lack: Lack) -> Self {
        CallFailure::Lack(lack)
    }
}

/// Whether the system has no more of something.
pub fn is_lack(error: &io::Error) -> bool {
    // Open files, of this program and of all, have no kind.
    #[cfg(unix)]
    if let Some(rustix::io::Errno::MFILE | rustix::io::Errno::NFILE) =
        rustix::io::Errno::from_io_error(error)
    {
        return true;
    }
    is_full(error) || matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::OutOfMemory)
}

/// Whether this is the text of the error of too many open files, of this program or of all: errors of loop files have no more.
fn says_too_many_files(reason: &str) -> bool {
    #[cfg(unix)]
    {
        let errors = [rustix::io::Errno::MFILE, rustix::io::Errno::NFILE];
        errors
            .into_iter()
            .any(|error| io::Error::from(error).to_string() == reason)
    }
    #[cfg(not(unix))]
    {
        let _ = reason;
        false
    }
}

/// Whether a file cannot grow.
fn is_full(error: &io::Error) -> bool {
    let kind = error.kind();
    matches!(
        kind,
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge
    )
}

/// Why no file of so many bytes can be written in a folder, where it has no space for it.
pub fn missing_space(folder: &Path, bytes: u64) -> Option<io::Error> {
    let probe = folder.join("probe");
    let written = fs::write(
        &probe,
        vec![1; usize::try_from(bytes).unwrap_or(usize::MAX / 2)],
    );
    let _ = fs::remove_file(&probe);
    written.err().filter(is_full)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn what_the_system_lacks_is_told_from_what_a_command_is() {
        // Of Linux: ENOENT, EAGAIN, ENOMEM, EACCES, ENFILE, EMFILE, EFBIG, ENOSPC.
        let lacks = [2, 11, 12, 13, 23, 24, 27, 28]
            .map(|number| is_lack(&io::Error::from_raw_os_error(number)));
        if cfg!(target_os = "linux") {
            assert_eq!(lacks, [false, true, true, false, true, true, true, true]);
        }
    }

    #[test]
    #[cfg(unix)]
    fn too_many_open_files_are_not_a_full_disk() {
        let of = |number| Lack::of_file(Path::new("f"), &io::Error::from_raw_os_error(number));
        let has_no_space = |lack| matches!(lack, Lack::File { .. });
        // Of Linux: EACCES, ENFILE, EMFILE, ENOSPC.
        if cfg!(target_os = "linux") {
            assert_eq!(
                [13, 23, 24, 28].map(|number| has_no_space(of(number))),
                [true, false, false, true]
            );
        }
    }

    #[test]
    fn a_folder_with_space_lacks_none_and_keeps_no_probe() {
        let folder = tempfile::TempDir::new().unwrap();
        assert!(missing_space(folder.path(), 4096).is_none());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        // A folder that is not there is none that is full.
        assert!(missing_space(&folder.path().join("nowhere"), 1).is_none());
    }
}

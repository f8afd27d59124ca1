//! The files that the program of a run is known by, which have to stay as they are while it goes on.

use std::fs::{self, Metadata};
use std::io::{self, ErrorKind};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use symplint_report::provenance::HashedFile;

use crate::CallsError;
use crate::lack::Lack;

/// A file that was hashed.
pub struct KnownFile {
    /// What the command names it by.
    pub word: String,
    pub path: PathBuf,
    pub sha256: String,
    /// What the system said of it before it was hashed last.
    stamp: Mutex<Option<Stamp>>,
}

/// What the system says of a file: where that stays, its contents do.
#[derive(PartialEq)]
struct Stamp {
    length: u64,
    modified: Option<SystemTime>,
    /// The file that has this name, and when anything of it changed: also where a copy got the old time.
    #[cfg(unix)]
    of_file: (u64, i64, i64),
}

impl Stamp {
    fn of(metadata: &Metadata) -> Self {
        Stamp {
            length: metadata.len(),
            modified: metadata.modified().ok(),
            #[cfg(unix)]
            of_file: {
                use std::os::unix::fs::MetadataExt;
                (metadata.ino(), metadata.ctime(), metadata.ctime_nsec())
            },
        }
    }
}

impl KnownFile {
    /// Hashes a file.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn read(word: &str, path: PathBuf) -> Result<Self, CallsError> {
        let stamp = fs::metadata(&path).ok();
        let stamp = Mutex::new(stamp.as_ref().map(Stamp::of));
        match HashedFile::read(&path) {
            Ok(HashedFile { sha256, .. }) => Ok(KnownFile {
                word: word.to_owned(),
                path,
                sha256,
                stamp,
            }),
            Err(error) => Err(unreadable(path, &error)),
        }
    }

    /// Whether it has other contents now, or is not there.
    ///
    /// # Errors
    /// If it is there and cannot be read.
    pub fn changed(&self) -> Result<bool, CallsError> {
        self.look().or_else(|error| match error.kind() {
            ErrorKind::NotFound | ErrorKind::NotADirectory => Ok(true),
            _ => Err(unreadable(self.path.clone(), &error)),
        })
    }

    fn look(&self) -> io::Result<bool> {
        let there = fs::metadata(&self.path)?;
        // A FIFO would be waited for.
        if !there.is_file() {
            return Ok(true);
        }
        let now = Some(Stamp::of(&there));
        let mut stamp = self.stamp.lock().unwrap_or_else(PoisonError::into_inner);
        if *stamp == now {
            return Ok(false);
        }
        let changed = HashedFile::read(&self.path)?.sha256 != self.sha256;
        if !changed {
            *stamp = now;
        }
        Ok(changed)
    }
}

fn unreadable(path: PathBuf, error: &io::Error) -> CallsError {
    let reason = error.to_string();
    match Lack::of_open_files(&path, &reason) {
        Some(lack) => lack.into(),
        None => CallsError::Unreadable { path, reason },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_changes_by_its_contents_alone() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("step.sh");
        fs::write(&path, "one").unwrap();
        let known = KnownFile::read("step.sh", path.clone()).unwrap();
        let time = fs::metadata(&path).unwrap().modified().unwrap();
        let changed = || known.changed().unwrap();
        assert!(!changed());
        // Another file with the same contents is the same program.
        fs::write(folder.path().join("copy"), "one").unwrap();
        fs::rename(folder.path().join("copy"), &path).unwrap();
        assert!(!changed());
        // As long, and with the time of the old one.
        fs::write(&path, "two").unwrap();
        let file = fs::File::options().write(true).open(&path).unwrap();
        file.set_modified(time).unwrap();
        assert_eq!(changed(), cfg!(unix));
        fs::write(&path, "three").unwrap();
        assert!(changed());
        fs::remove_file(&path).unwrap();
        assert!(changed());
        assert!(KnownFile::read("step.sh", path.clone()).is_err());
        fs::create_dir(&path).unwrap();
        assert!(changed());
    }

    #[test]
    #[cfg(unix)]
    fn a_file_that_cannot_be_read_did_not_change() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("step.sh");
        fs::write(&path, "one").unwrap();
        let known = KnownFile::read("step.sh", path.clone()).unwrap();
        fs::remove_file(&path).unwrap();
        // A link that leads to itself: also the superuser cannot read it.
        std::os::unix::fs::symlink(&path, &path).unwrap();
        assert!(matches!(
            known.changed(),
            Err(CallsError::Unreadable { .. })
        ));
        fs::remove_file(&path).unwrap();
        fs::write(&path, "one").unwrap();
        assert_eq!(known.changed(), Ok(false));
    }
}

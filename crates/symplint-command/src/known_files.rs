//! The files that the program of a run is known by, which have to stay as they are while it goes on.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use symplint_report::provenance::HashedFile;

use crate::CallsError;

/// A file that was hashed.
pub struct KnownFile {
    /// The word of the command that names it.
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
    fn of(path: &Path) -> Option<Self> {
        let metadata = fs::metadata(path).ok()?;
        Some(Stamp {
            length: metadata.len(),
            modified: metadata.modified().ok(),
            #[cfg(unix)]
            of_file: {
                use std::os::unix::fs::MetadataExt;
                (metadata.ino(), metadata.ctime(), metadata.ctime_nsec())
            },
        })
    }
}

impl KnownFile {
    /// Hashes a file.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn read(word: &str, path: PathBuf) -> Result<Self, CallsError> {
        let stamp = Mutex::new(Stamp::of(&path));
        match HashedFile::read(&path) {
            Ok(HashedFile { sha256, .. }) => Ok(KnownFile {
                word: word.to_owned(),
                path,
                sha256,
                stamp,
            }),
            Err(error) => Err(CallsError::Unreadable {
                reason: error.to_string(),
                path,
            }),
        }
    }

    /// Whether it has other contents now, or none.
    pub fn changed(&self) -> bool {
        let mut stamp = self.stamp.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Stamp::of(&self.path);
        if *stamp == now && now.is_some() {
            return false;
        }
        let changed = HashedFile::read(&self.path).map_or(true, |file| file.sha256 != self.sha256);
        if !changed {
            *stamp = now;
        }
        changed
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
        assert!(!known.changed());
        // Another file with the same contents is the same program.
        fs::write(folder.path().join("copy"), "one").unwrap();
        fs::rename(folder.path().join("copy"), &path).unwrap();
        assert!(!known.changed());
        // As long, and with the time of the old one.
        fs::write(&path, "two").unwrap();
        let file = fs::File::options().write(true).open(&path).unwrap();
        file.set_modified(time).unwrap();
        assert_eq!(known.changed(), cfg!(unix));
        fs::write(&path, "three").unwrap();
        assert!(known.changed());
        fs::remove_file(&path).unwrap();
        assert!(known.changed());
        assert!(KnownFile::read("step.sh", path).is_err());
    }
}

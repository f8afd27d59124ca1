//! The files whose contents identify the program of a run.

use std::fs;
use std::path::PathBuf;
use std::time::SystemTime;

use symplint_files::HashedFile;

use super::CallsError;

/// A file that was hashed.
pub struct ProgramFile {
    /// Its name in the configuration.
    pub name: String,
    path: PathBuf,
    pub sha256: String,
    stamp: Option<Stamp>,
}

/// Length and time of a file: if they stay, its contents do.
type Stamp = (u64, Option<SystemTime>);

impl ProgramFile {
    /// Hashes a file.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn read(name: &str, path: PathBuf) -> Result<Self, CallsError> {
        let mut file = ProgramFile {
            name: name.to_owned(),
            path,
            sha256: String::new(),
            stamp: None,
        };
        file.stamp = file.stamp_now();
        match HashedFile::read(&file.path) {
            Ok(HashedFile { sha256, .. }) => Ok(ProgramFile { sha256, ..file }),
            Err(error) => Err(CallsError::Unreadable {
                path: file.path,
                reason: error.to_string(),
            }),
        }
    }

    /// Checks that the file has the contents that were hashed.
    ///
    /// # Errors
    /// If it has not, or cannot be read.
    pub fn check_same(&self) -> Result<(), CallsError> {
        let same = || HashedFile::read(&self.path).is_ok_and(|now| now.sha256 == self.sha256);
        match self.stamp_now() == self.stamp || same() {
            true => Ok(()),
            false => Err(CallsError::Changed {
                path: self.path.clone(),
            }),
        }
    }

    fn stamp_now(&self) -> Option<Stamp> {
        let there = fs::metadata(&self.path).ok()?;
        Some((there.len(), there.modified().ok()))
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
        let file = ProgramFile::read("step.sh", path.clone()).unwrap();
        let is_same = || file.check_same().is_ok();
        assert!(is_same());
        // Another file with the same contents is the same program.
        fs::write(folder.path().join("copy"), "one").unwrap();
        fs::rename(folder.path().join("copy"), &path).unwrap();
        assert!(is_same());
        fs::write(&path, "three").unwrap();
        assert!(!is_same());
        fs::remove_file(&path).unwrap();
        assert!(!is_same());
        assert!(ProgramFile::read("step.sh", path.clone()).is_err());
    }
}

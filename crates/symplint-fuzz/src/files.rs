//! Bytes as files, for readers that take a path.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

/// A file system in memory, if there is one: disks take milliseconds to keep a journal.
const IN_MEMORY: &str = "/dev/shm";

/// Calls `read` with the path of a file of these bytes, in a separate folder that is removed afterwards.
pub fn with_file<R>(name: &str, bytes: &[u8], read: impl FnOnce(&Path) -> R) -> R {
    let folder = match Path::new(IN_MEMORY).is_dir() {
        true => TempDir::new_in(IN_MEMORY),
        false => TempDir::new(),
    };
    let folder = folder.expect("a temporary folder");
    let path = folder.path().join(name);
    fs::write(&path, bytes).expect("a temporary file");
    read(&path)
}

//! Archives of arrays: `.npz`.

use symplint_files::LoopFile;

use crate::files::with_file;
use crate::loops::compare_with_itself;

/// Reads the bytes as a loop, and as single states.
pub fn npz(data: &[u8]) {
    with_file("fuzz.npz", data, |path| {
        match LoopFile::read(path) {
            Ok(file) => compare_with_itself(&file),
            Err(error) => drop((error.to_string(), error.remedy())),
        }
        let _ = LoopFile::read_states(path);
    });
}

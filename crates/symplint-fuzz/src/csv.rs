//! Tables: `.csv`.

use symplint_files::LoopFile;

use crate::files::with_file;
use crate::loops::compare_with_itself;

/// Reads the bytes as a loop.
pub fn csv(data: &[u8]) {
    with_file("fuzz.csv", data, |path| match LoopFile::read(path) {
        Ok(file) => compare_with_itself(&file),
        Err(error) => drop((error.to_string(), error.remedy())),
    });
}

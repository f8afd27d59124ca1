//! Arrays: `.npy`.

use std::path::Path;

use symplint_files::loop_file::{Array, LoopFile, NumberKind};

use crate::files::with_file;

/// Decodes the bytes as an array, and reads them as both files of a pair.
pub fn npy(data: &[u8]) {
    for kind in [NumberKind::Floats, NumberKind::Numbers] {
        if let Ok(array) = Array::decode(data, kind, Path::new("fuzz.npy"), "") {
            let bytes = array.encode();
            let again = Array::decode(&bytes, kind, Path::new("again.npy"), "");
            let again = again.unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(again.shape, array.shape);
            assert_eq!(again.values.len(), array.values.len());
        }
    }
    with_file("q.npy", data, |path| {
        let _ = std::fs::copy(path, path.with_file_name("p.npy"));
        if let Err(error) = LoopFile::read(path) {
            let _ = (error.to_string(), error.remedy());
        }
    });
}

//! Pairs of arrays: `loop_q.npy` and `loop_p.npy`.

use std::fs;
use std::path::{Path, PathBuf};

use super::array::{Array, NumberKind};
use super::{LoopFile, LoopFileError, MIN_SAMPLES};

/// The files of positions and momenta that a name stands for: `loop_q.npy`, `loop_p.npy` or `loop.npy`
/// for the pair `loop_q.npy` and `loop_p.npy`; `q.npy` or `p.npy` for these two.
pub fn pair_of(path: &Path) -> (PathBuf, PathBuf) {
    let stem = path.file_stem().and_then(|s| s.to_str()).unwrap_or("");
    let named = |name: String| path.with_file_name(format!("{name}.npy"));
    let bare = match stem {
        "q" | "p" => Some(""),
        _ => (stem.strip_suffix("_q"))
            .or_else(|| stem.strip_suffix("_p"))
            .map(|s| &stem[..=s.len()]),
    };
    match bare {
        Some(start) => (named(format!("{start}q")), named(format!("{start}p"))),
        None => (named(format!("{stem}_q")), named(format!("{stem}_p"))),
    }
}

/// Whether two names are the positions and the momenta of one loop, in this order.
pub fn is_partner(first: &Path, second: &Path) -> bool {
    let is_npy = |path: &Path| path.extension().is_some_and(|e| e == "npy");
    let pair = pair_of(first);
    is_npy(first) && is_npy(second) && pair.0 == first && pair.1 == second
}

pub fn read(path: &Path) -> Result<LoopFile, LoopFileError> {
    let load = |path: &Path| {
        let bytes = fs::read(path).map_err(|error| LoopFileError::Read {
            path: path.to_owned(),
            reason: error.to_string(),
        })?;
        Array::decode(&bytes, NumberKind::Floats, path, "")
    };
    let (q, p) = pair_of(path);
    LoopFile::from_arrays(path, &load(&q)?, &load(&p)?, MIN_SAMPLES)
}

pub fn write(file: &LoopFile) -> Result<Vec<PathBuf>, LoopFileError> {
    let (q, p) = pair_of(&file.path);
    for (path, momenta) in [(&q, false), (&p, true)] {
        let bytes = file.array(momenta).encode();
        fs::write(path, bytes).map_err(|error| LoopFileError::Write {
            path: path.clone(),
            reason: error.to_string(),
        })?;
    }
    Ok(vec![q, p])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_pairs() {
        let names = |name: &str| {
            let (q, p) = pair_of(Path::new(name));
            (
                q.to_str().unwrap().to_owned(),
                p.to_str().unwrap().to_owned(),
            )
        };
        let expected = ("a/loop_q.npy".to_owned(), "a/loop_p.npy".to_owned());
        for name in ["a/loop.npy", "a/loop_q.npy", "a/loop_p.npy"] {
            assert_eq!(names(name), expected, "{name}");
        }
        assert_eq!(names("a/p.npy"), ("a/q.npy".into(), "a/p.npy".into()));
        assert!(is_partner(Path::new("x_q.npy"), Path::new("x_p.npy")));
        assert!(!is_partner(Path::new("x.npy"), Path::new("x_p.npy")));
        assert!(!is_partner(Path::new("x_q.npy"), Path::new("y_p.npy")));
    }
}

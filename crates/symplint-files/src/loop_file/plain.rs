//! Files for codes without libraries: one line `symplint h dof samples`, then numbers.
//!
//! All positions come first, then all momenta, each by degree of freedom: the samples of q_0, those of q_1, and so on. In `.raw` files the
//! numbers are little-endian doubles, in `.txt` files decimals between blanks or line ends.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use symplint::{Ensemble, Snapshot};

use super::{LoopFile, LoopFileError};

/// The first word of such a file.
const NAME: &str = "symplint";

/// How the numbers are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Numbers {
    /// Little-endian doubles.
    Raw,
    /// Decimals.
    Text,
}

/// The first line.
struct Header {
    h: f64,
    dof: usize,
    samples: usize,
}

impl Header {
    /// From a line; `None` if it is another one.
    fn of(line: &str) -> Option<Self> {
        let mut words = line.split_whitespace();
        if words.next() != Some(NAME) {
            return None;
        }
        let (h, dof, samples) = (words.next()?, words.next()?, words.next()?);
        // Fortran writes 1.5D0 and 1.5E+00.
        let h = h.replace(['d', 'D'], "e").parse().ok()?;
        let header = Header {
            h,
            dof: dof.parse().ok()?,
            samples: samples.parse().ok()?,
        };
        words.next().is_none().then_some(header)
    }

    /// How many numbers follow it.
    fn numbers(&self) -> Option<usize> {
        self.dof.checked_mul(self.samples)?.checked_mul(2)
    }
}

pub fn read(path: &Path, numbers: Numbers, fewest: usize) -> Result<LoopFile, LoopFileError> {
    let bytes = fs::read(path).map_err(|error| LoopFileError::Read {
        path: path.to_owned(),
        reason: error.to_string(),
    })?;
    let end = bytes.iter().position(|&byte| byte == b'\n');
    let (line, rest) = bytes.split_at(end.unwrap_or(bytes.len()));
    let header = std::str::from_utf8(line).ok().and_then(Header::of);
    let Some((header, count)) = header.and_then(|header| {
        let count = header.numbers()?;
        Some((header, count))
    }) else {
        return Err(LoopFileError::Header {
            path: path.to_owned(),
        });
    };
    if header.dof == 0 || header.samples < fewest {
        return Err(LoopFileError::TooSmall {
            path: path.to_owned(),
            samples: header.samples,
            dof: header.dof,
        });
    }
    let values = match numbers {
        Numbers::Raw => doubles(rest.get(1..).unwrap_or_default()),
        Numbers::Text => decimals(rest).map_err(|word| LoopFileError::Number {
            path: path.to_owned(),
            word,
        })?,
    };
    if values.len() != count {
        return Err(LoopFileError::Numbers {
            path: path.to_owned(),
            dof: header.dof,
            samples: header.samples,
            promised: count,
            there: values.len(),
        });
    }
    let mut states = Ensemble::zeros(header.dof, header.samples);
    let block = states.block();
    let mut rows_of_values = values.chunks_exact(header.samples);
    for mut rows in [block.q, block.p] {
        for (i, values) in rows_of_values.by_ref().take(header.dof).enumerate() {
            rows.row_mut(i).copy_from_slice(values);
        }
    }
    Ok(LoopFile {
        path: path.to_owned(),
        states,
        unit_roundoff: Snapshot::DOUBLE,
        step_size: Some(header.h).filter(|h| h.is_finite()),
        period: None,
        momentum_period: None,
        weight: None,
    })
}

/// Numbers of eight bytes; a rest of fewer counts as one that is not there.
fn doubles(bytes: &[u8]) -> Vec<f64> {
    let (numbers, _) = bytes.as_chunks();
    numbers
        .iter()
        .map(|bytes| f64::from_le_bytes(*bytes))
        .collect()
}

/// Numbers between blanks, or the first word that is not a number.
fn decimals(bytes: &[u8]) -> Result<Vec<f64>, String> {
    let text = String::from_utf8_lossy(bytes);
    let number = |word: &str| {
        let value = word
            .parse()
            .or_else(|_| word.replace(['d', 'D'], "e").parse());
        value.map_err(|_| word.chars().take(40).collect())
    };
    text.split_whitespace().map(number).collect()
}

pub fn write(file: &LoopFile, numbers: Numbers) -> Result<Vec<PathBuf>, LoopFileError> {
    let states = &file.states;
    let h = file.step_size.unwrap_or(f64::NAN);
    let header = format!("{NAME} {h} {} {}\n", states.dof(), states.samples());
    let rows = [states.q(), states.p()];
    let rows = rows
        .iter()
        .flat_map(|rows| (0..rows.count()).map(|i| rows.row(i)));
    let bytes = match numbers {
        Numbers::Raw => {
            let mut bytes = header.into_bytes();
            bytes.extend(rows.flatten().flat_map(|value| value.to_le_bytes()));
            bytes
        }
        Numbers::Text => {
            let mut text = header;
            for value in rows.flatten() {
                // Writing to a string cannot fail.
                let _ = writeln!(text, "{value:e}");
            }
            text.into_bytes()
        }
    };
    fs::write(&file.path, bytes).map_err(|error| LoopFileError::Write {
        path: file.path.clone(),
        reason: error.to_string(),
    })?;
    Ok(vec![file.path.clone()])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(name: &str) -> (tempfile::TempDir, LoopFile) {
        let folder = tempfile::TempDir::new().unwrap();
        let mut states = Ensemble::zeros(2, 3);
        let block = states.block();
        for (mut rows, first) in [(block.q, 0.1), (block.p, -0.7)] {
            for i in 0..2 {
                for (k, value) in rows.row_mut(i).iter_mut().enumerate() {
                    *value = first / 3.0 + 10.0 * i as f64 + k as f64;
                }
            }
        }
        let file = LoopFile {
            path: folder.path().join(name),
            states,
            unit_roundoff: Snapshot::DOUBLE,
            step_size: Some(0.1),
            period: None,
            momentum_period: None,
            weight: None,
        };
        (folder, file)
    }

    #[test]
    fn what_is_written_is_read_to_the_last_bit() {
        for (name, numbers) in [("a.raw", Numbers::Raw), ("a.txt", Numbers::Text)] {
            let (_folder, written) = file(name);
            write(&written, numbers).unwrap();
            let found = read(&written.path, numbers, 3).unwrap();
            for i in 0..2 {
                assert_eq!(found.states.q().row(i), written.states.q().row(i), "{name}");
                assert_eq!(found.states.p().row(i), written.states.p().row(i), "{name}");
            }
            assert_eq!(found.step_size, Some(0.1));
        }
    }

    #[test]
    fn numbers_stand_by_degree_of_freedom() {
        let (_folder, written) = file("a.raw");
        write(&written, Numbers::Raw).unwrap();
        let bytes = fs::read(&written.path).unwrap();
        let line = b"symplint 0.1 2 3\n";
        assert_eq!(&bytes[..line.len()], line);
        assert_eq!(bytes.len(), line.len() + 12 * 8);
        let at = line.len() + 4 * 8;
        let value = f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
        assert_eq!(value, written.states.q().row(1)[1]);
    }

    #[test]
    fn numbers_as_fortran_writes_them_are_read() {
        let (_folder, written) = file("a.txt");
        let text = "symplint  5.0000D-01 1 3\r\n 1.0D0 2.5E+00 -3\r\n 4.d-2\t5 6\r\n";
        fs::write(&written.path, text).unwrap();
        let found = read(&written.path, Numbers::Text, 3).unwrap();
        assert_eq!(found.step_size, Some(0.5));
        assert_eq!(found.states.q().row(0), [1.0, 2.5, -3.0]);
        assert_eq!(found.states.p().row(0), [0.04, 5.0, 6.0]);
    }

    #[test]
    fn bad_files_are_errors() {
        let (_folder, written) = file("a.txt");
        for (text, words) in [
            ("", "does not begin with a line"),
            ("loop 0.1 1 3\n1 2 3 4 5 6\n", "does not begin with a line"),
            ("symplint 0.1 1 3 4\n", "does not begin with a line"),
            (
                "symplint 0.1 99999999999 99999999999\n",
                "does not begin with a line",
            ),
            (
                "symplint 0.1 1 3\n1 2 3 4 5\n",
                "has 5 numbers, and its first line promises 6",
            ),
            (
                "symplint 0.1 1 3\n1 2 3 4 5 x6\n",
                "`x6`, which is not a number",
            ),
            ("symplint 0.1 1 2\n1 2 3 4\n", "too few"),
            ("symplint 0.1 0 3\n", "too few"),
        ] {
            fs::write(&written.path, text).unwrap();
            let error = read(&written.path, Numbers::Text, 3).err().unwrap();
            assert!(error.to_string().contains(words), "{text}: {error}");
            assert!(!error.remedy().is_empty());
        }
    }
}

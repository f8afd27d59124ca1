//! Loops in files, for and from other codes: `.npz`, pairs of `.npy`, `.csv`, and `.raw` and `.txt` for codes without libraries.

mod array;
mod error;
mod npz;
mod pair;
mod plain;
mod table;

use std::fs;
use std::path::{Path, PathBuf};

use symplint::{Ensemble, Snapshot};

use crate::hashed_file::HashedFile;
use plain::Numbers;

pub use array::{Array, NumberKind};
pub use error::LoopFileError;
pub use pair::is_partner;
pub use table::is_header;

/// A loop as a file holds it.
pub struct LoopFile {
    /// The file, for messages.
    pub path: PathBuf,
    /// The states.
    pub states: Ensemble,
    /// Relative rounding error of the values as they were stored.
    pub unit_roundoff: f64,
    /// The step that made the states, if the file says it.
    pub step_size: Option<f64>,
    /// Period of each position, 0 for none, if the file says them; one for all is allowed.
    pub period: Option<Vec<f64>>,
    /// Period of each momentum, in the same form.
    pub momentum_period: Option<Vec<f64>>,
    /// Weight of each momentum, in the same form.
    pub weight: Option<Vec<f64>>,
}

/// Samples of a loop at least.
const MIN_SAMPLES: usize = 3;

/// How a loop is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Npz,
    NpyPair,
    Csv,
    Plain(Numbers),
}

impl Format {
    fn of(path: &Path) -> Result<Self, LoopFileError> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        match extension.to_ascii_lowercase().as_str() {
            "npz" => Ok(Format::Npz),
            "npy" => Ok(Format::NpyPair),
            "csv" => Ok(Format::Csv),
            "raw" => Ok(Format::Plain(Numbers::Raw)),
            "txt" => Ok(Format::Plain(Numbers::Text)),
            _ => Err(LoopFileError::Format {
                path: path.to_owned(),
            }),
        }
    }
}

/// The files that a name stands for.
fn paths_of(path: &Path, format: Format) -> Vec<PathBuf> {
    match format {
        Format::NpyPair => {
            let (q, p) = pair::pair_of(path);
            vec![q, p]
        }
        Format::Npz | Format::Csv | Format::Plain(_) => vec![path.to_owned()],
    }
}

/// Refuses what would wait for ever when it is opened or read. A missing file is reported when it is opened.
fn check_regular(path: impl AsRef<Path>) -> Result<(), LoopFileError> {
    let path = path.as_ref();
    match fs::metadata(path) {
        Ok(there) if !there.is_file() => Err(LoopFileError::NotRegular {
            path: path.to_owned(),
        }),
        _ => Ok(()),
    }
}

impl LoopFile {
    /// Reads a loop; the name says in which format.
    ///
    /// # Errors
    /// The first thing that is wrong, with the file and the remedy.
    pub fn read(path: &Path) -> Result<Self, LoopFileError> {
        let format = Format::of(path)?;
        paths_of(path, format).iter().try_for_each(check_regular)?;
        let file = match format {
            Format::Npz => npz::read(path, MIN_SAMPLES),
            Format::NpyPair => pair::read(path),
            Format::Csv => table::read(path),
            Format::Plain(numbers) => plain::read(path, numbers, MIN_SAMPLES),
        }?;
        file.check_finite()?;
        Ok(file)
    }

    /// Reads states from an `.npz`, `.raw` or `.txt` file that need not be a loop: one or more.
    ///
    /// # Errors
    /// The first thing that is wrong, with the file and the remedy.
    pub fn read_states(path: &Path) -> Result<Self, LoopFileError> {
        check_regular(path)?;
        let file = match Format::of(path)? {
            Format::Plain(numbers) => plain::read(path, numbers, 1),
            _ => npz::read(path, 1),
        }?;
        file.check_finite()?;
        Ok(file)
    }

    /// Writes the loop in the format that the name says; returns the files.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write(&self) -> Result<Vec<PathBuf>, LoopFileError> {
        match Format::of(&self.path)? {
            Format::Npz => npz::write(self),
            Format::NpyPair => pair::write(self),
            Format::Csv => table::write(self),
            Format::Plain(numbers) => plain::write(self, numbers),
        }
    }

    /// The files that hold it: two where it is a pair.
    ///
    /// # Errors
    /// If the name does not end in that of a format.
    pub fn paths(&self) -> Result<Vec<PathBuf>, LoopFileError> {
        Ok(paths_of(&self.path, Format::of(&self.path)?))
    }

    /// The hashes of its files.
    ///
    /// # Errors
    /// If one cannot be read.
    pub fn hashes(&self) -> Result<Vec<HashedFile>, LoopFileError> {
        let hash = |path: PathBuf| {
            HashedFile::read(&path).map_err(|error| LoopFileError::Read {
                path,
                reason: error.to_string(),
            })
        };
        self.paths()?.into_iter().map(hash).collect()
    }

    /// Whether the format of the file can hold period, weight and step size.
    pub fn carries_settings(&self) -> bool {
        Format::of(&self.path) == Ok(Format::Npz)
    }

    /// From arrays q and p of shape (samples, dof), or (samples) for one degree of freedom, with at least `fewest`
    /// samples.
    fn from_arrays(
        path: &Path,
        q: &Array,
        p: &Array,
        fewest: usize,
    ) -> Result<Self, LoopFileError> {
        if q.shape != p.shape {
            return Err(LoopFileError::ShapesDiffer {
                path: path.to_owned(),
                q: q.shape.clone(),
                p: p.shape.clone(),
            });
        }
        let (samples, dof) = match q.shape[..] {
            [samples] => (samples, 1),
            [samples, dof] => (samples, dof),
            _ => {
                return Err(LoopFileError::Shape {
                    path: path.to_owned(),
                    shape: q.shape.clone(),
                });
            }
        };
        if dof == 0 || samples < fewest {
            return Err(LoopFileError::TooSmall {
                path: path.to_owned(),
                samples,
                dof,
            });
        }
        let mut states = Ensemble::zeros(dof, samples);
        let block = states.block();
        for (mut rows, array) in [(block.q, q), (block.p, p)] {
            for i in 0..dof {
                for (k, value) in rows.row_mut(i).iter_mut().enumerate() {
                    *value = array.values[k * dof + i];
                }
            }
        }
        Ok(LoopFile {
            path: path.to_owned(),
            states,
            unit_roundoff: if q.single || p.single {
                Snapshot::SINGLE
            } else {
                Snapshot::DOUBLE
            },
            step_size: None,
            period: None,
            momentum_period: None,
            weight: None,
        })
    }

    /// The positions (`momenta`: momenta) as an array of shape (samples, dof).
    fn array(&self, momenta: bool) -> Array {
        let rows = if momenta {
            self.states.p()
        } else {
            self.states.q()
        };
        let (samples, dof) = (self.states.samples(), self.states.dof());
        let values = (0..samples)
            .flat_map(|k| (0..dof).map(move |i| rows.row(i)[k]))
            .collect();
        Array {
            shape: vec![samples, dof],
            values,
            single: false,
        }
    }

    /// Checks that this can be `before` after a step.
    ///
    /// # Errors
    /// If they differ in samples or degrees of freedom.
    pub fn check_same_loop(&self, before: &LoopFile) -> Result<(), LoopFileError> {
        let shape = |file: &LoopFile| (file.states.samples(), file.states.dof());
        if shape(self) == shape(before) {
            return Ok(());
        }
        Err(LoopFileError::OtherLoop {
            path: self.path.clone(),
            shape: shape(self),
            before: before.path.clone(),
            shape_before: shape(before),
        })
    }

    fn check_finite(&self) -> Result<(), LoopFileError> {
        for (coordinate, rows) in [("q", self.states.q()), ("p", self.states.p())] {
            for dof in 0..rows.count() {
                let row = rows.row(dof);
                if let Some(sample) = row.iter().position(|value| !value.is_finite()) {
                    return Err(LoopFileError::NotFinite {
                        path: self.path.clone(),
                        coordinate,
                        dof,
                        sample,
                        value: row[sample],
                    });
                }
            }
        }
        Ok(())
    }
}

//! The folder that a run leaves behind.

mod point_log;
mod record_table;

use std::fs::{self, File, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::Serialize;
use symplint::Ensemble;

pub use point_log::PointLog;
pub use record_table::RecordTable;

use crate::report::to_json;
use symplint_files::write_whole;

/// A file or folder of a run that cannot be written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("cannot write {}: {reason}", path.display())]
pub struct WriteError {
    /// Which.
    pub path: PathBuf,
    /// Why.
    pub reason: String,
}

/// The folder of figures in that of a run.
const FIGURES: &str = "figures";

/// An empty file, which is locked while a run writes to the folder.
pub const LOCK: &str = ".lock";

/// A folder for what a run leaves behind. No other run can have it at the same time, if the file system has locks.
pub struct RunFolder {
    path: PathBuf,
    /// Locked until it is closed.
    _lock: File,
}

impl RunFolder {
    /// Makes the folder with `figures/` in it if they are not there, and locks it.
    ///
    /// # Errors
    /// If files cannot be written in it, or another run has it.
    pub fn create(path: &Path) -> Result<Self, WriteError> {
        let figures = path.join(FIGURES);
        fs::create_dir_all(&figures).map_err(|error| cannot_write(&figures, &error))?;
        let mut options = File::options();
        let lock = options.write(true).create(true).truncate(false);
        let lock = lock.open(path.join(LOCK));
        let lock = lock.map_err(|error| cannot_write(path, &error))?;
        if let Err(TryLockError::WouldBlock) = lock.try_lock() {
            return Err(cannot_write(
                path,
                &"another run writes to it; wait for its end",
            ));
        }
        Ok(RunFolder {
            path: path.to_owned(),
            _lock: lock,
        })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where figures go.
    pub fn figures(&self) -> PathBuf {
        self.path.join(FIGURES)
    }

    /// Where evaluations of costly maps go.
    pub fn journal(&self) -> PathBuf {
        self.path.join("journal")
    }

    /// Where points go.
    pub fn points(&self) -> PathBuf {
        self.path.join("points.csv")
    }

    /// Writes `config.toml`.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write_config(&self, config: &str) -> Result<(), WriteError> {
        self.write_text("config.toml", config)
    }

    /// Begins a diagnosis: `config.toml` says what runs, `points.csv` gets what it measures, and no report of another
    /// configuration stays next to them. That of the same one stays until the new one takes its place: a run that fails does not
    /// lose it.
    ///
    /// # Errors
    /// If one of these files cannot be written.
    pub fn begin(&self, config: &str) -> Result<RecordTable, WriteError> {
        let report = self.path.join("report.json");
        let there = fs::read_to_string(self.path.join("config.toml"));
        if there.ok().as_deref() != Some(config) {
            remove(&report).map_err(|error| cannot_write(&report, &error))?;
        }
        self.write_config(config)?;
        let points = self.points();
        RecordTable::create(&points).map_err(|error| cannot_write(&points, &error))
    }

    /// Writes a text.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_text(&self, name: &str, text: &str) -> Result<(), WriteError> {
        let path = self.path.join(name);
        write_whole(&path, text.as_bytes()).map_err(|error| cannot_write(&path, &error))
    }

    /// Writes JSON.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_json(&self, name: &str, value: &impl Serialize) -> Result<(), WriteError> {
        self.write_text(name, &(to_json(value) + "\n"))
    }

    /// Writes records as CSV with a header; what is not given is an empty field.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_csv<T: Serialize>(&self, name: &str, records: &[T]) -> Result<(), WriteError> {
        let path = self.path.join(name);
        let write = || -> csv::Result<()> {
            let mut table = RecordTable::create(&path)?;
            for record in records {
                table.push(record)?;
            }
            table.flush()
        };
        write().map_err(|error| cannot_write(&path, &error))
    }

    /// Writes the samples of a loop as CSV: s, then q and p of each degree of freedom.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_samples(&self, name: &str, ensemble: &Ensemble) -> Result<(), WriteError> {
        let path = self.path.join(name);
        let write = || -> csv::Result<()> {
            let mut writer = csv::Writer::from_path(&path)?;
            let dof = ensemble.dof();
            // The names of columns of loop files, which can be read as such.
            let columns = |c: &str| (0..dof).map(|i| format!("{c}_{i}")).collect::<Vec<_>>();
            writer.write_record([vec!["s".to_owned()], columns("q"), columns("p")].concat())?;
            for k in 0..ensemble.samples() {
                let s = k as f64 / ensemble.samples() as f64;
                let q = (0..dof).map(|i| ensemble.q().row(i)[k]);
                let p = (0..dof).map(|i| ensemble.p().row(i)[k]);
                let record = std::iter::once(s).chain(q).chain(p);
                writer.write_record(record.map(|value| format!("{value:?}")))?;
            }
            Ok(writer.flush()?)
        };
        write().map_err(|error| cannot_write(&path, &error))
    }
}

/// Removes a file that may not be there.
fn remove(path: &Path) -> std::io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

fn cannot_write(path: &Path, error: &impl ToString) -> WriteError {
    WriteError {
        path: path.to_owned(),
        reason: error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_stays_beside_its_configuration_alone() {
        let folder = tempfile::TempDir::new().unwrap();
        let run = RunFolder::create(folder.path()).unwrap();
        let report = folder.path().join("report.json");
        run.write_config("a = 1\n").unwrap();
        run.write_text("report.json", "{}").unwrap();
        run.begin("a = 1\n").unwrap();
        assert!(report.exists());
        run.begin("a = 2\n").unwrap();
        assert!(!report.exists());
    }
}

//! The folder of `--out`.
//!
//! Only a new or empty folder and the folder of a run of the same configuration are written to, and with
//! `--force` those of other runs. A folder with files that symplint did not write, or with a `config.toml` that
//! was edited, is never written to.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use symplint_report::figure::Figure;
use symplint_report::run_folder::RunFolder;

use super::Failure;
use super::earlier_run::{EarlierRun, RECORDS, config_text, figure_files, loop_file};
use crate::cli::Run;

/// The folder of a run, and the text of its `config.toml`.
pub struct RunOutput {
    /// The folder.
    pub folder: RunFolder,
    /// `config.toml`: the configuration with all defaults.
    pub config: String,
    earlier: Option<EarlierRun>,
}

impl RunOutput {
    /// The folder of a run, if `--out` gives one.
    ///
    /// # Errors
    /// If it must not or cannot be written to.
    pub fn of_run(command: &str, config: &toml::Table, run: &Run) -> Result<Option<Self>, Failure> {
        (run.out.as_deref())
            .map(|path| Self::open(path, command, config, run.force))
            .transpose()
    }

    /// The folder `path` for a run of `command`.
    ///
    /// # Errors
    /// If it must not or cannot be written to.
    pub fn open(
        path: &Path,
        command: &str,
        config: &toml::Table,
        force: bool,
    ) -> Result<Self, Failure> {
        let earlier = EarlierRun::in_folder(path)?;
        if let Some(earlier) = earlier.as_ref().filter(|_| !force) {
            earlier.check_same(path, command, config)?;
        }
        Ok(RunOutput {
            folder: RunFolder::create(path)?,
            config: config_text(command, config),
            earlier,
        })
    }

    /// Writes the figures of a run with `report.json`, `points.csv` and loops at the steps `snapshots`, and
    /// removes what an earlier run wrote and this one does not.
    ///
    /// # Errors
    /// If a file cannot be written or removed.
    pub fn write_figures(
        &self,
        figures: Vec<(&'static str, Figure)>,
        snapshots: &[usize],
    ) -> Result<(), Failure> {
        let mut kept: Vec<String> = RECORDS.iter().map(|&name| name.into()).collect();
        kept.extend(figures.iter().flat_map(|(name, _)| figure_files(name)));
        kept.extend(snapshots.iter().map(|step| loop_file(*step)));
        self.remove_earlier(&kept)?;
        for (name, figure) in figures {
            figure.save(&self.folder.figures(), name)?;
        }
        Ok(())
    }

    /// Removes what an earlier run wrote, except the files `kept`.
    ///
    /// # Errors
    /// If a file cannot be removed.
    pub fn remove_earlier(&self, kept: &[String]) -> Result<(), Failure> {
        let files = self.earlier.as_ref().map_or(Vec::new(), EarlierRun::files);
        for file in files.into_iter().filter(|file| !kept.contains(file)) {
            let path = self.folder.path().join(file);
            match fs::remove_file(&path) {
                Err(error) if error.kind() != ErrorKind::NotFound => {
                    let reason = error.to_string();
                    return Err(Failure::Write { path, reason });
                }
                _ => {}
            }
        }
        Ok(())
    }
}

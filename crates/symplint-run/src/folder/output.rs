//! The folder of `--out`.
//!
//! Only a new or empty folder and the folder of a run of the same configuration are written to, and with
//! `--force` the folders of other runs. A folder with files that symplint did not write, or with a `config.toml` that
//! was edited, is never written to.

use std::path::Path;
use std::sync::Arc;

use serde::Serialize;
use serde_json::{Value, json};
use symplint::Diagnosis;
use symplint_report::figure::Figure;
use symplint_report::page::{Page, Repeat};
use symplint_report::report::Report;
use symplint_report::run_folder::RunFolder;

use super::earlier::{EarlierRun, JOURNAL, RECORDS, config_text, identity};
use super::{Round, RunError, remove};
use crate::command::CommandMap;
use crate::journal::Journal;

/// The folder of a run, and the text of its `config.toml`.
pub struct RunOutput {
    /// The folder.
    pub folder: RunFolder,
    /// `config.toml`: the configuration with all defaults.
    pub config: String,
    /// The evaluations of a costly map.
    pub journal: Option<Arc<Journal>>,
    identity: Value,
    /// Whether the folder has a run of the same configuration, which resumes.
    resumes: bool,
    earlier: Option<EarlierRun>,
}

impl RunOutput {
    /// The folder `path` for a run of `command`. `number` reads strings that are numbers, which are compared by value.
    ///
    /// # Errors
    /// If it must not or cannot be written to.
    pub fn open(
        path: &Path,
        command: &str,
        config: &toml::Table,
        force: bool,
        number: fn(&str) -> Option<f64>,
    ) -> Result<Self, RunError> {
        let identity = identity(config, number);
        let find = || {
            let earlier = EarlierRun::in_folder(path, number)?;
            if let Some(earlier) = earlier.as_ref().filter(|_| !force) {
                earlier.check_same(path, command, &identity)?;
            }
            Ok::<_, RunError>(earlier)
        };
        find()?;
        let folder = RunFolder::create(path)?;
        // Another run may have ended before this one had the folder.
        let earlier = find()?;
        Ok(RunOutput {
            folder,
            config: config_text(command, config),
            journal: None,
            resumes: earlier.is_some() && !force,
            identity,
            earlier,
        })
    }

    /// Stores the calls of a program from now on in the folder, and replays those that a stopped run, or its jobs, made.
    ///
    /// # Errors
    /// If the journal is of another version of the program or of symplint, or a file cannot be read or written.
    pub fn keep_journal(&mut self, map: &CommandMap) -> Result<(), RunError> {
        let (journal, round) = self.open_journal(map)?;
        round.end()?;
        map.keep_journal(journal);
        Ok(())
    }

    /// Replays the calls of a program that the journal has, and plans the others for jobs.
    ///
    /// # Errors
    /// Those of [`keep_journal`](Self::keep_journal).
    pub fn plan_calls(&mut self, map: &CommandMap) -> Result<Round, RunError> {
        let (journal, round) = self.open_journal(map)?;
        map.plan_only(journal, round.failed()?);
        Ok(round)
    }

    /// The journal of this run with all results of jobs, and the round. A run that is refused changes nothing in the folder.
    fn open_journal(&mut self, map: &CommandMap) -> Result<(Arc<Journal>, Round), RunError> {
        let path = self.folder.journal();
        let run = run_of(map, &self.identity)?;
        let round = Round::of_run(self.folder.path(), &run);
        let journal = if self.resumes {
            let journal = Journal::open(&path, &run)?;
            self.folder.write_config(&self.config)?;
            journal
        } else {
            map.check_keeps_no_earlier_calls()?;
            // First, as a folder with a journal alone is not a run folder.
            self.folder.write_config(&self.config)?;
            let journal = Journal::replace(&path, &run)?;
            round.remove()?;
            remove(&self.folder.path().join("report.json"))?;
            journal
        };
        round.collect(&journal)?;
        let journal = Arc::new(journal);
        self.journal = Some(Arc::clone(&journal));
        Ok((journal, round))
    }

    /// Writes the figures of a run with `report.json`, `points.csv` and loops at the steps `snapshots`, and
    /// removes the other files of an earlier run.
    ///
    /// # Errors
    /// If a file cannot be written or removed.
    pub fn write_figures(
        &self,
        figures: Vec<(&'static str, Figure)>,
        snapshots: &[usize],
    ) -> Result<(), RunError> {
        let mut kept: Vec<String> = RECORDS.iter().map(|&name| name.into()).collect();
        kept.extend(self.journal.is_some().then(|| JOURNAL.to_owned()));
        kept.extend(figures.iter().flat_map(|(name, _)| figure_files(name)));
        kept.extend(snapshots.iter().map(|step| loop_file(*step)));
        self.remove_earlier(&kept)?;
        for (name, figure) in figures {
            figure.save(&self.folder.figures(), name)?;
        }
        Ok(())
    }

    /// Writes `report.html`, which also shows these figures and how to repeat the run.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write_page<C: Serialize>(
        &self,
        title: &str,
        diagnosis: &Diagnosis,
        report: &Report<'_, C>,
        figures: &[(&'static str, Figure)],
        repeat: Repeat<'_>,
    ) -> Result<(), RunError> {
        let figures: Vec<(&'static str, String)> = (figures.iter())
            .map(|(name, figure)| (*name, figure.clone().without_titles()))
            .filter_map(|(name, figure)| Some((name, figure.to_svg().ok()?)))
            .collect();
        let page = Page {
            title,
            diagnosis,
            figures: &figures,
            config: &self.config,
            provenance: report.provenance(),
            json: &report.to_json(),
            repeat,
        };
        Ok(self.folder.write_text("report.html", &page.to_html())?)
    }

    /// Removes the files of an earlier run, except the files `kept`.
    ///
    /// # Errors
    /// If a file cannot be removed.
    pub fn remove_earlier(&self, kept: &[String]) -> Result<(), RunError> {
        // A round belongs to a journal.
        if self.journal.is_none() && self.folder.journal().exists() {
            Round::of_run(self.folder.path(), &self.identity).remove()?;
        }
        let files = self.earlier.as_ref().map_or(Vec::new(), EarlierRun::files);
        for file in files.into_iter().filter(|file| !kept.contains(file)) {
            remove(&self.folder.path().join(file))?;
        }
        Ok(())
    }
}

/// The files of a figure.
pub(super) fn figure_files(name: &str) -> [String; 3] {
    ["svg", "pdf", "png"].map(|extension| format!("figures/{name}.{extension}"))
}

/// The file of the loop of a trace after this number of steps.
pub fn loop_file(step: usize) -> String {
    format!("loop_{step}.csv")
}

impl Round {
    /// The round of the run with this configuration in a folder.
    ///
    /// # Errors
    /// If a file of the program cannot be read.
    pub fn of_config(
        folder: &Path,
        map: &CommandMap,
        config: &toml::Table,
        number: fn(&str) -> Option<f64>,
    ) -> Result<Self, RunError> {
        Ok(Self::of_run(
            folder,
            &run_of(map, &identity(config, number))?,
        ))
    }
}

/// The run of a journal: the version of symplint, the configuration, and the files of the program.
fn run_of(map: &CommandMap, config: &Value) -> Result<Value, RunError> {
    let files = map.identity()?.into_iter();
    let files: serde_json::Map<_, _> = files
        .map(|(name, sha256)| (name.to_owned(), sha256.into()))
        .collect();
    let version = env!("CARGO_PKG_VERSION");
    Ok(json!({ "symplint": version, "config": config, "program": files }))
}

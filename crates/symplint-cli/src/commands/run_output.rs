//! The folder of `--out`.
//!
//! Only a new or empty folder and the folder of a run of the same configuration are written to, and with
//! `--force` those of other runs. A folder with files that symplint did not write, or with a `config.toml` that
//! was edited, is never written to.

use std::path::Path;
use std::sync::Arc;

use symplint_command::CommandMap;
use symplint_journal::Journal;
use symplint_report::figure::Figure;
use symplint_report::run_folder::RunFolder;

use super::earlier_run::{
    EarlierRun, JOURNAL, RECORDS, config_text, figure_files, identity, loop_file,
};
use super::round::{Round, check_idle, remove};
use crate::cli::Run;
use crate::failure::Failure;

/// The folder of a run, and the text of its `config.toml`.
pub struct RunOutput {
    /// The folder.
    pub folder: RunFolder,
    /// `config.toml`: the configuration with all defaults.
    pub config: String,
    /// What the run is known by.
    identity: serde_json::Value,
    /// Whether a run of the same is in the folder, and goes on.
    goes_on: bool,
    /// The evaluations, where the map is one that costs.
    pub journal: Option<Arc<Journal>>,
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
        let folder = RunFolder::create(path)?;
        // Jobs have locks of their own.
        if earlier.is_some() {
            check_idle(path)?;
        }
        Ok(RunOutput {
            folder,
            config: config_text(command, config),
            identity: identity(config),
            goes_on: earlier.is_some() && !force,
            journal: None,
            earlier,
        })
    }

    /// Notes the calls of a program from now on in the folder, and replays those that a run of the same made before it was
    /// stopped, also by jobs, which are not waited for any more.
    ///
    /// # Errors
    /// If the journal is of another version of the program or of this one, or a job is under way, or a file cannot be written.
    pub fn keep_journal(&mut self, map: &CommandMap) -> Result<(), Failure> {
        let (journal, round) = self.open_journal(map)?;
        round.collect(&journal)?;
        round.end()?;
        map.keep_journal(journal);
        Ok(())
    }

    /// Replays the calls of a program that the journal has, and those that jobs made, which it takes in first: jobs make the others.
    ///
    /// # Errors
    /// Those of [`keep_journal`](Self::keep_journal), and of files that jobs wrote.
    pub fn plan_calls(&mut self, map: &CommandMap) -> Result<Round, Failure> {
        let (journal, round) = self.open_journal(map)?;
        round.collect(&journal)?;
        map.plan_only(journal, round.failed()?);
        Ok(round)
    }

    /// The journal and the round of calls of this run. Nothing in the folder changes before it is known that both are of this run,
    /// or are to be replaced, and that nobody writes to them.
    fn open_journal(&mut self, map: &CommandMap) -> Result<(Arc<Journal>, Round), Failure> {
        let path = self.folder.journal();
        let run = run_of(map, &self.identity)?;
        let round = Round::of_run(self.folder.path(), &run);
        if !self.goes_on {
            map.check_keeps_no_earlier_calls()
                .map_err(Failure::of_command)?;
        }
        let journal = match &self.earlier {
            Some(_) if self.goes_on => Journal::open(&path, &run)?,
            Some(_) => Journal::anew(&path, &run)?,
            None => {
                // Of two runs that are begun at once, the one that has the journal writes its configuration; before that a journal is
                // empty, as a folder with another one alone would be none of a run.
                let claimed = Journal::claim(&path)?;
                self.folder.write_config(&self.config)?;
                claimed.begin(&run)?
            }
        };
        if !self.goes_on {
            round.remove()?;
            // The report of the run that was replaced would not fit the configuration.
            remove(&self.folder.path().join("report.json"))?;
        }
        // The run can be resumed from here on.
        self.folder.write_config(&self.config)?;
        let journal = Arc::new(journal);
        self.journal = Some(Arc::clone(&journal));
        Ok((journal, round))
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
        kept.extend(self.journal.is_some().then(|| JOURNAL.to_owned()));
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
        // What jobs made belongs to a journal.
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

/// What the journal of the run in a folder is of.
///
/// # Errors
/// If a file of the program cannot be read.
pub fn run_of_config(map: &CommandMap, config: &toml::Table) -> Result<serde_json::Value, Failure> {
    run_of(map, &identity(config))
}

/// What a journal is of: the version of this program, the configuration, and the program that is called.
fn run_of(map: &CommandMap, config: &serde_json::Value) -> Result<serde_json::Value, Failure> {
    let files = map.know_program()?.into_iter();
    let files: serde_json::Map<_, _> = files
        .map(|(word, sha256)| (word.to_owned(), sha256.into()))
        .collect();
    Ok(serde_json::json!({
        "symplint": env!("CARGO_PKG_VERSION"),
        "config": config,
        "program": files,
    }))
}

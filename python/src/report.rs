//! The report of a diagnosis, as Python sees it.

use std::path::PathBuf;

use pyo3::prelude::*;
use serde::Deserialize;
use symplint::Diagnosis;
use symplint_report::figures::figures;
use symplint_report::page::{Page, Repeat};
use symplint_report::provenance::{Provenance, Run};
use symplint_report::report::{Report as JsonReport, read_evidence};
use symplint_report::run_folder::RunFolder;
use symplint_report::text::{DisplayOptions, diagnosis_text, reasons};

use crate::error::{input_error, other_error};

/// The width of tables and paragraphs, in characters.
const WIDTH: usize = 100;

/// A report: the verdict, all points, and where they come from.
#[pyclass(frozen, module = "symplint._native")]
pub struct Report {
    diagnosis: Diagnosis,
    title: String,
    config: serde_json::Value,
    provenance: Provenance,
}

/// The parts of a report besides evidence and its consequences.
#[derive(Deserialize)]
struct Rest {
    config: serde_json::Value,
    provenance: Provenance,
}

impl Report {
    /// The report on what `run` found, on this number of threads.
    pub fn new(
        diagnosis: Diagnosis,
        title: String,
        config: serde_json::Value,
        run: &Run,
        threads: usize,
    ) -> Self {
        let mut provenance = run.provenance(threads);
        if let Some(seed) = config
            .pointer("/check/seed")
            .and_then(serde_json::Value::as_u64)
        {
            provenance.seeds.insert("check.seed".into(), seed);
        }
        Report {
            diagnosis,
            title,
            config,
            provenance,
        }
    }

    /// The same of a run that took this number of evaluations from a journal.
    pub fn replaying(mut self, evaluations: usize) -> Self {
        self.provenance.replayed = evaluations;
        self
    }

    /// The same of a run whose steps were taken by this number of processes.
    pub fn by_workers(mut self, count: usize) -> Self {
        self.provenance.workers = count;
        self
    }

    fn json(&self) -> String {
        JsonReport::new(&self.config, &self.diagnosis, self.provenance.clone()).to_json()
    }

    /// Calls `write` with what a page of HTML shows.
    fn with_page<R>(&self, write: impl FnOnce(&Page<'_>) -> R) -> R {
        let figures: Vec<(&'static str, String)> = figures(&self.title, &self.diagnosis)
            .into_iter()
            // The page has their titles. Without a figure the table has the same numbers.
            .filter_map(|(name, figure)| Some((name, figure.without_titles().to_svg().ok()?)))
            .collect();
        write(&Page {
            title: &self.title,
            diagnosis: &self.diagnosis,
            figures: &figures,
            config: &config_text(&self.config),
            provenance: &self.provenance,
            json: &self.json(),
            repeat: Repeat::Python,
        })
    }
}

/// Starts a run now.
pub fn start() -> Run {
    Run::start(env!("CARGO_PKG_VERSION"), None)
}

#[pymethods]
impl Report {
    #[getter]
    fn kind(&self) -> String {
        self.diagnosis.verdict.kind.to_string()
    }

    #[getter]
    fn digits(&self) -> Option<f64> {
        self.diagnosis.verdict.digits
    }

    #[getter]
    fn order(&self) -> Option<f64> {
        self.diagnosis.verdict.order
    }

    #[getter]
    fn headline(&self) -> String {
        self.diagnosis.verdict.headline()
    }

    #[getter]
    fn summary(&self) -> String {
        self.diagnosis.verdict.summary()
    }

    #[getter]
    fn sentences(&self) -> Vec<String> {
        self.diagnosis.verdict.sentences()
    }

    #[getter]
    fn advice(&self) -> Vec<String> {
        self.diagnosis.verdict.advice()
    }

    #[getter]
    fn evaluations(&self) -> usize {
        self.diagnosis.evidence.evaluations.made
    }

    #[getter]
    fn title(&self) -> &str {
        &self.title
    }

    /// The report that `to_json` wrote.
    #[staticmethod]
    fn from_json(py: Python<'_>, text: &str, title: String) -> PyResult<Self> {
        let evidence = read_evidence(text).map_err(|error| input_error(py, &error.to_string()))?;
        let Rest { config, provenance } =
            serde_json::from_str(text).map_err(|error| input_error(py, &error.to_string()))?;
        Ok(Report {
            diagnosis: Diagnosis::of(evidence),
            title,
            config,
            provenance,
        })
    }

    /// The report as JSON, schema `symplint/report/3`.
    fn to_json(&self) -> String {
        self.json()
    }

    /// The verdict, a table of the given loop, and the findings; `all` of them, or what fits one screen.
    fn text(&self, all: bool) -> String {
        let shown = DisplayOptions {
            width: Some(WIDTH),
            all,
        };
        let text = diagnosis_text(&self.title, &self.diagnosis, shown);
        format!("{}\n{text}", self.diagnosis.verdict.headline())
    }

    /// The verdict with its reasons.
    fn reasons(&self) -> String {
        let verdict = &self.diagnosis.verdict;
        let shown = DisplayOptions {
            width: Some(WIDTH),
            all: false,
        };
        reasons(verdict, shown)
    }

    /// A part of a page.
    fn fragment(&self) -> String {
        self.with_page(|page| page.fragment())
    }

    /// A page.
    fn to_html(&self) -> String {
        self.with_page(|page| page.to_html())
    }

    /// Writes report.json, report.html, points.csv, config.toml and figures into a folder.
    fn save(&self, py: Python<'_>, folder: PathBuf) -> PyResult<()> {
        py.detach(|| self.write(&folder))
            .map_err(|error| other_error(py, &error))
    }
}

impl Report {
    fn write(&self, folder: &std::path::Path) -> Result<(), String> {
        let folder = RunFolder::create(folder).map_err(|error| error.to_string())?;
        let files = || {
            folder.write_config(&config_text(&self.config))?;
            folder.write_text("report.json", &(self.json() + "\n"))?;
            folder.write_text("report.html", &self.with_page(|page| page.to_html()))?;
            folder.write_csv("points.csv", &self.diagnosis.points())
        };
        files().map_err(|error| error.to_string())?;
        for (name, figure) in figures(&self.title, &self.diagnosis) {
            (figure.save(&folder.figures(), name)).map_err(|error| error.to_string())?;
        }
        Ok(())
    }
}

/// The configuration as TOML, which has no null.
fn config_text(config: &serde_json::Value) -> String {
    fn without_null(value: &serde_json::Value) -> serde_json::Value {
        match value {
            serde_json::Value::Object(entries) => (entries.iter())
                .filter(|(_, value)| !value.is_null())
                .map(|(key, value)| (key.clone(), without_null(value)))
                .collect(),
            other => other.clone(),
        }
    }
    toml::to_string(&without_null(config)).unwrap_or_default()
}

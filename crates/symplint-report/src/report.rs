//! Reports as JSON, and evidence read from them.

use serde::Serialize;
use symplint::evidence::{Evaluations, Point};
use symplint::trace::TracePoint;
use symplint::verdict::{Fit, Property};
use symplint::{Diagnosis, Evidence, Verdict};

use crate::provenance::Provenance;

/// The schema of the report on a diagnosis.
const SCHEMA: &str = "symplint/report/3";

/// The result of a diagnosis: schema `symplint/report/3`. `C` is the configuration that it belongs to.
#[derive(Serialize)]
pub struct Report<'a, C> {
    schema: &'static str,
    symplint: &'static str,
    config: &'a C,
    evaluations: &'a Evaluations,
    verdict: &'a Verdict,
    properties: &'a [Property],
    points: Vec<Point>,
    fits: &'a [Fit],
    evidence: &'a Evidence,
    /// Last, and all in one place: everything before it is a result, the same to the last bit in every run.
    provenance: Provenance,
}

impl<'a, C: Serialize> Report<'a, C> {
    /// The report on a configuration.
    pub fn new(config: &'a C, diagnosis: &'a Diagnosis, provenance: Provenance) -> Self {
        Report {
            schema: SCHEMA,
            symplint: env!("CARGO_PKG_VERSION"),
            config,
            evaluations: &diagnosis.evidence.evaluations,
            verdict: &diagnosis.verdict,
            properties: &diagnosis.verdict.properties,
            points: diagnosis.points(),
            fits: diagnosis.fits(),
            evidence: &diagnosis.evidence,
            provenance,
        }
    }

    /// Its origin.
    pub fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// As text.
    pub fn to_json(&self) -> String {
        to_json(self)
    }
}

/// Why a text holds no evidence.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// It is not JSON.
    #[error("it is not JSON: {0}; give the report.json of a run folder, or what --json printed")]
    NotJson(String),
    /// It is JSON, and not a report of symplint.
    #[error(
        "it is not a report of symplint: it has no key \"schema\" that begins with \"symplint/report/\""
    )]
    NotAReport,
    /// It is a report of another version.
    #[error(
        "its schema is \"{schema}\", which has no evidence; make a report of schema \"{SCHEMA}\" by running the diagnosis again"
    )]
    OtherSchema {
        /// Its schema.
        schema: String,
    },
    /// Its evidence cannot be read.
    #[error(
        "its evidence cannot be read: {0}; it may be of another version, or have been changed: run the diagnosis again"
    )]
    BadEvidence(String),
}

/// The evidence in the text of a report.
///
/// # Errors
/// If the text is not a report of this schema, or its evidence is damaged.
pub fn read_evidence(text: &str) -> Result<Evidence, ReportError> {
    let mut report: serde_json::Value =
        serde_json::from_str(text).map_err(|error| ReportError::NotJson(error.to_string()))?;
    let schema = (report.get("schema").and_then(serde_json::Value::as_str))
        .filter(|schema| schema.starts_with("symplint/report/"))
        .ok_or(ReportError::NotAReport)?;
    if schema != SCHEMA {
        return Err(ReportError::OtherSchema {
            schema: schema.to_owned(),
        });
    }
    let evidence = report["evidence"].take();
    serde_json::from_value(evidence).map_err(|error| ReportError::BadEvidence(error.to_string()))
}

/// The result of a trace: schema `symplint/trace/1`.
#[derive(Serialize)]
pub struct TraceReport<'a, C> {
    schema: &'static str,
    symplint: &'static str,
    config: &'a C,
    points: &'a [TracePoint],
    provenance: Provenance,
}

impl<'a, C: Serialize> TraceReport<'a, C> {
    /// The report on a trace.
    pub fn new(config: &'a C, points: &'a [TracePoint], provenance: Provenance) -> Self {
        TraceReport {
            schema: "symplint/trace/1",
            symplint: env!("CARGO_PKG_VERSION"),
            config,
            points,
            provenance,
        }
    }

    /// As text.
    pub fn to_json(&self) -> String {
        to_json(self)
    }
}

/// Pretty JSON; numbers that are not finite become `null`.
pub fn to_json(value: &impl Serialize) -> String {
    serde_json::to_string_pretty(value).expect("reports are trees of numbers and texts")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::provenance::Run;
    use symplint::{Circle, Diagnostic, PerSample};

    #[test]
    fn the_verdict_follows_from_the_report_alone() {
        let map = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
            p[0] -= h * q[0].signum();
            q[0] += h * p[0];
        });
        let circle = Circle::new(vec![0.1], vec![0.2], 1.0).unwrap();
        let diagnosis = Diagnostic::halving(-1, -3).run(&map, &circle).unwrap();
        let provenance = Run::start("1.2.3", None).provenance(1);
        let text = Report::new(&(), &diagnosis, provenance).to_json();
        let evidence = read_evidence(&text).unwrap();
        assert_eq!(evidence, diagnosis.evidence);
        assert_eq!(symplint::judge(&evidence), diagnosis.verdict);
    }

    #[test]
    fn what_is_no_report_is_refused_with_the_reason() {
        for (text, words) in [
            ("", "not JSON"),
            ("{", "not JSON"),
            ("[1, 2]", "not a report"),
            ("{\"schema\": \"other/1\"}", "not a report"),
            ("{\"schema\": \"symplint/report/1\"}", "report/1"),
            ("{\"schema\": \"symplint/report/3\"}", "cannot be read"),
            (
                "{\"schema\": \"symplint/report/3\", \"evidence\": 3}",
                "cannot be read",
            ),
        ] {
            let error = read_evidence(text).unwrap_err().to_string();
            assert!(error.contains(words), "{text}: {error}");
        }
    }
}

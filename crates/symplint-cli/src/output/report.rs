//! Reports as JSON.

use serde::Serialize;
use symplint::{Diagnosis, TracePoint};

/// What `check` found: schema `symplint/report/1`.
#[derive(Serialize)]
pub struct Report<'a> {
    schema: &'static str,
    symplint: &'static str,
    config: &'a toml::Table,
    #[serde(flatten)]
    diagnosis: &'a Diagnosis,
}

impl<'a> Report<'a> {
    /// The report on a configuration.
    pub fn new(config: &'a toml::Table, diagnosis: &'a Diagnosis) -> Self {
        Report {
            schema: "symplint/report/1",
            symplint: env!("CARGO_PKG_VERSION"),
            config,
            diagnosis,
        }
    }

    /// As text.
    pub fn to_json(&self) -> String {
        to_json(self)
    }
}

/// What `trace` followed: schema `symplint/trace/1`.
#[derive(Serialize)]
pub struct TraceReport<'a> {
    schema: &'static str,
    symplint: &'static str,
    config: &'a toml::Table,
    points: &'a [TracePoint],
}

impl<'a> TraceReport<'a> {
    /// The report on a trace.
    pub fn new(config: &'a toml::Table, points: &'a [TracePoint]) -> Self {
        TraceReport {
            schema: "symplint/trace/1",
            symplint: env!("CARGO_PKG_VERSION"),
            config,
            points,
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

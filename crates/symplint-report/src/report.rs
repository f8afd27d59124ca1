//! Reports as JSON.

use serde::Serialize;
use symplint::{Diagnosis, TracePoint};

/// What a diagnosis found: schema `symplint/report/1`. `C` is the configuration that it belongs to.
#[derive(Serialize)]
pub struct Report<'a, C> {
    schema: &'static str,
    symplint: &'static str,
    config: &'a C,
    #[serde(flatten)]
    diagnosis: &'a Diagnosis,
}

impl<'a, C: Serialize> Report<'a, C> {
    /// The report on a configuration.
    pub fn new(config: &'a C, diagnosis: &'a Diagnosis) -> Self {
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

/// What a trace followed: schema `symplint/trace/1`.
#[derive(Serialize)]
pub struct TraceReport<'a, C> {
    schema: &'static str,
    symplint: &'static str,
    config: &'a C,
    points: &'a [TracePoint],
}

impl<'a, C: Serialize> TraceReport<'a, C> {
    /// The report on a trace.
    pub fn new(config: &'a C, points: &'a [TracePoint]) -> Self {
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

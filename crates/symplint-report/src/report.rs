//! Reports as JSON.

use serde::Serialize;
use symplint::{Diagnosis, TracePoint};

use crate::provenance::Provenance;

/// What a diagnosis found: schema `symplint/report/1`. `C` is the configuration that it belongs to.
#[derive(Serialize)]
pub struct Report<'a, C> {
    schema: &'static str,
    symplint: &'static str,
    config: &'a C,
    #[serde(flatten)]
    diagnosis: &'a Diagnosis,
    /// Last, and all in one place: everything before it is a result, the same to the last bit in every run.
    provenance: Provenance,
}

impl<'a, C: Serialize> Report<'a, C> {
    /// The report on a configuration.
    pub fn new(config: &'a C, diagnosis: &'a Diagnosis, provenance: Provenance) -> Self {
        Report {
            schema: "symplint/report/1",
            symplint: env!("CARGO_PKG_VERSION"),
            config,
            diagnosis,
            provenance,
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

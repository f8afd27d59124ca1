//! `[trace]`: settings of `symplint trace`.

use super::document::Node;
use super::error::ConfigError;
use super::section::{Key, NumberRange, Section};
use symplint::request::MAX_SAMPLES;

/// The keys of `[trace]`.
pub const KEYS: &[Key] = &[
    Key::new("step_size", "0.1", "step size h"),
    Key::new("steps", "1000", "number of steps"),
    Key::new("samples", "2048", "samples of the loop"),
    Key::new(
        "snapshots",
        "[0, 10, 20, 40, 80]",
        "steps at which the loop is drawn (one degree of freedom) and written",
    ),
];

/// Steps at most: each is a row of the report.
const MAX_STEPS: u64 = 10_000_000;

/// Settings of `trace`.
pub struct TraceSettings {
    /// Step size h.
    pub step_size: f64,
    /// Number of steps.
    pub steps: usize,
    /// Samples N_s.
    pub samples: usize,
    /// Steps at which the loop is kept.
    pub snapshots: Vec<usize>,
}

/// Reads `[trace]`.
pub fn read(node: Option<&Node>) -> Result<(TraceSettings, Section), ConfigError> {
    let section = Section::new("trace", node, KEYS.to_vec())?;
    let steps = section.whole_between("steps", 1, MAX_STEPS)?;
    let mut snapshots = section.optional_wholes("snapshots", 0)?.unwrap_or_default();
    // Defaults beyond the last step are dropped. Those that were written are refused by `trace`.
    if section.written_place("snapshots").is_none() {
        snapshots.retain(|&step| step <= steps);
        let kept = snapshots.iter().map(|&step| step as i64);
        section.record("snapshots", kept.collect::<Vec<_>>());
    }
    let settings = TraceSettings {
        step_size: section.number("step_size", NumberRange::Positive)?,
        steps: steps as usize,
        samples: section.whole_between("samples", 3, MAX_SAMPLES)? as usize,
        snapshots: snapshots.into_iter().map(|step| step as usize).collect(),
    };
    Ok((settings, section))
}

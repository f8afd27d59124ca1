//! What is known of the map apart from loop integrals.

use serde::{Deserialize, Serialize};

/// What was learnt of the map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Survey {
    /// How coarsely the map rounds the states that it returns, if it does more than double precision does.
    pub output_precision: Option<OutputPrecision>,
}

/// Returned states that have fewer digits than double precision, where those before the step have not.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OutputPrecision {
    /// `'q'` or `'p'`.
    pub coordinate: char,
    /// Degree of freedom.
    pub dof: usize,
    /// The numbers that it returns.
    pub format: OutputFormat,
    /// The distance of neighbouring values.
    pub unit: f64,
}

/// Formats of numbers with few digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutputFormat {
    /// Decimal numbers of so many significant digits.
    Decimal {
        /// Digits.
        digits: usize,
    },
    /// Single precision.
    Single,
}

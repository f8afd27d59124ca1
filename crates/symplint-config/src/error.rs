//! Errors of a configuration, with their position in the source and the remedy.

use std::ops::Range;
use std::sync::Arc;

/// A mistake in a configuration, its place, and the remedy.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct ConfigError {
    /// The mistake.
    pub message: String,
    /// The place and its label; `None` for a missing key.
    pub position: Option<(Place, String)>,
    /// The remedy, if the message does not name it.
    pub remedy: Option<String>,
    /// The other errors of the same configuration, in their order in the file.
    pub others: Vec<ConfigError>,
}

impl ConfigError {
    /// An error without a position.
    pub fn new(message: impl Into<String>, remedy: impl Into<String>) -> Self {
        ConfigError {
            message: message.into(),
            position: None,
            remedy: Some(remedy.into()),
            others: Vec::new(),
        }
    }

    /// An error whose message names the remedy.
    pub fn with_its_remedy(message: impl Into<String>) -> Self {
        ConfigError {
            message: message.into(),
            position: None,
            remedy: None,
            others: Vec::new(),
        }
    }

    /// The first of several errors, with the others.
    pub(crate) fn joined(errors: Vec<ConfigError>) -> Option<Self> {
        let mut errors = errors.into_iter();
        let mut first = errors.next()?;
        first.others.extend(errors);
        Some(first)
    }

    /// Adds the position.
    pub fn at(mut self, place: &Place, label: impl Into<String>) -> Self {
        self.position = Some((place.clone(), label.into()));
        self
    }
}

/// A text that settings are read from.
#[derive(Debug)]
pub struct Source {
    /// Its file, or `--set`.
    pub name: String,
    /// The text, as TOML.
    pub text: String,
}

/// The position of a setting.
#[derive(Clone, Debug)]
pub struct Place {
    /// The source.
    pub source: Arc<Source>,
    /// Byte range in its text.
    pub span: Range<usize>,
}

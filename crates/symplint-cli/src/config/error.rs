//! Errors of a configuration, with their position in the source and the remedy.

use std::sync::Arc;

use miette::{Diagnostic, NamedSource, SourceSpan};

/// What is wrong with a configuration, where, and what to do.
#[derive(Debug, thiserror::Error, Diagnostic)]
#[error("{message}")]
pub struct ConfigError {
    /// What is wrong.
    pub message: String,
    #[source_code]
    source_code: Option<Arc<NamedSource<String>>>,
    #[label("{label}")]
    span: Option<SourceSpan>,
    label: String,
    #[help]
    help: Option<String>,
}

impl ConfigError {
    /// An error without a position.
    pub fn new(message: impl Into<String>, help: impl Into<String>) -> Self {
        ConfigError {
            message: message.into(),
            source_code: None,
            span: None,
            label: String::new(),
            help: Some(help.into()),
        }
    }

    /// Adds the position.
    pub fn at(mut self, place: &Place, label: impl Into<String>) -> Self {
        self.source_code = Some(Arc::clone(&place.source));
        self.span = Some(place.span.clone().into());
        self.label = label.into();
        self
    }
}

/// The position of a setting.
#[derive(Clone, Debug)]
pub struct Place {
    /// The source, named after its file or `--set`.
    pub source: Arc<NamedSource<String>>,
    /// Byte range in the source.
    pub span: std::ops::Range<usize>,
}

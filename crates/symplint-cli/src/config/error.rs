//! Errors of a configuration: they point at the place and name the remedy.

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
    /// An error that belongs to no place in a text.
    pub fn new(message: impl Into<String>, help: impl Into<String>) -> Self {
        ConfigError {
            message: message.into(),
            source_code: None,
            span: None,
            label: String::new(),
            help: Some(help.into()),
        }
    }

    /// Points at a place.
    pub fn at(mut self, place: &Place, label: impl Into<String>) -> Self {
        self.source_code = Some(Arc::clone(&place.source));
        self.span = Some(place.span.clone().into());
        self.label = label.into();
        self
    }
}

/// Where in which text a setting stands.
#[derive(Clone, Debug)]
pub struct Place {
    /// The text, with the name of its file, or `--set`.
    pub source: Arc<NamedSource<String>>,
    /// Bytes of it.
    pub span: std::ops::Range<usize>,
}

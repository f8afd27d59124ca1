//! A diagnosis as a value: its settings by name, in one table.
//!
//! The keys of `[diagnostic]` in configurations, the arguments of Python, the options of C and the starter configurations are
//! made from [`SETTINGS`] or read by it. A new setting is a row here and a field of [`Diagnostic`].

mod number;
mod settings;
mod value;

use std::collections::BTreeMap;

pub use number::parse as parse_number;
pub use settings::{MAX_SAMPLES, SETTINGS};
pub use value::{MAX_WHOLE_NUMBER, NumberRange, Refusal, Value, ValuePart};

use crate::diagnosis::Diagnostic;
use crate::rules::Rule;

/// A setting of a diagnosis.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Its name: the key of `[diagnostic]` in a configuration.
    pub name: &'static str,
    /// The default, as TOML; for a setting that may be left out, an example.
    pub value: &'static str,
    /// Whether it has no default.
    pub is_optional: bool,
    /// The keys of its table, if it may be one.
    pub keys: &'static [&'static str],
    /// One line of documentation.
    pub help: &'static str,
    /// Reads a value into a diagnostic.
    set: fn(&mut Diagnostic, &Value) -> Result<(), Refusal>,
}

/// Why settings are refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RequestError {
    /// No setting has this name.
    #[error("unknown setting \"{name}\"; available: {}", available())]
    Unknown {
        /// The name that was given.
        name: String,
    },
    /// A setting cannot have this value.
    #[error("{name}{refused}")]
    Refused {
        /// The setting.
        name: &'static str,
        /// Why.
        refused: Refusal,
    },
}

fn available() -> String {
    let names: Vec<&str> = SETTINGS.iter().map(|setting| setting.name).collect();
    names.join(", ")
}

impl Diagnostic {
    /// The diagnostic with these settings, and defaults for the rest.
    ///
    /// # Errors
    /// If a name is unknown, or a value is refused: the first in the order of [`SETTINGS`].
    ///
    /// ```
    /// use std::collections::BTreeMap;
    /// use symplint::Diagnostic;
    /// use symplint::request::Value;
    ///
    /// let mut settings = BTreeMap::from([("loops".to_owned(), Value::Whole(4))]);
    /// assert_eq!(Diagnostic::from_settings(&settings)?.loops, 4);
    ///
    /// settings.insert("loops".to_owned(), Value::Whole(0));
    /// let error = Diagnostic::from_settings(&settings).unwrap_err();
    /// assert_eq!(error.to_string(), "loops is 0; give a whole number of at least 1");
    /// # Ok::<(), symplint::request::RequestError>(())
    /// ```
    pub fn from_settings(given: &BTreeMap<String, Value>) -> Result<Self, RequestError> {
        let is_known = |name: &String| SETTINGS.iter().any(|setting| setting.name == name);
        if let Some(name) = given.keys().find(|name| !is_known(name)) {
            let name = name.clone();
            return Err(RequestError::Unknown { name });
        }
        let mut diagnostic = Diagnostic::default();
        for setting in SETTINGS {
            if let Some(value) = given.get(setting.name) {
                let name = setting.name;
                (setting.set)(&mut diagnostic, value)
                    .map_err(|refused| RequestError::Refused { name, refused })?;
            }
        }
        // A rule that is named has the settings of its kind.
        diagnostic.rule = match diagnostic.rule {
            Rule::Piecewise(_) => Rule::Piecewise(diagnostic.piecewise),
            Rule::Streaming(_) => Rule::Streaming(diagnostic.streaming),
            rule => rule,
        };
        Ok(diagnostic)
    }
}

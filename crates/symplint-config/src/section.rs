//! One section of a configuration: typed keys with defaults.

use std::cell::RefCell;

pub use symplint::request::NumberRange;
use symplint::request::{self, MAX_WHOLE_NUMBER, Refusal, ValuePart};

use super::document::{Node, SETTING, Table, Value};
use super::error::{ConfigError, Place};

/// The sections of a configuration.
pub const NAMES: [&str; 5] = ["system", "integrator", "loop", "diagnostic", "trace"];

/// A key of a section.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// The default, as TOML; for a key without one, an example.
    pub value: &'static str,
    /// Whether the key has no default and may be left out.
    pub optional: bool,
    /// Whether it has no default and must be given.
    pub required: bool,
    /// The values that it takes.
    pub kind: Kind,
    /// One line of documentation.
    pub help: &'static str,
}

/// The values that a key takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Values of the type of its default; numbers if it has none.
    Plain,
    /// A number, or a list of numbers.
    Numbers,
    /// A text, one of these.
    Choice(&'static [&'static str]),
    /// The same, or a file: `{ file = "state.npy" }`.
    ChoiceOrFile(&'static [&'static str]),
}

impl Key {
    /// The same for a number or a list.
    #[must_use]
    pub const fn numbers(self) -> Self {
        Key {
            kind: Kind::Numbers,
            ..self
        }
    }

    /// The same for one of these texts.
    #[must_use]
    pub const fn choice(self, texts: &'static [&'static str]) -> Self {
        Key {
            kind: Kind::Choice(texts),
            ..self
        }
    }

    /// The same for one of these texts, or a file.
    #[must_use]
    pub const fn choice_or_file(self, texts: &'static [&'static str]) -> Self {
        Key {
            kind: Kind::ChoiceOrFile(texts),
            ..self
        }
    }

    /// A key with a default.
    pub const fn new(name: &'static str, default: &'static str, help: &'static str) -> Self {
        Key {
            name,
            value: default,
            optional: false,
            required: false,
            kind: Kind::Plain,
            help,
        }
    }

    /// A key that may be left out; `help` says what that means.
    pub const fn optional(name: &'static str, example: &'static str, help: &'static str) -> Self {
        Key {
            name,
            value: example,
            optional: true,
            required: false,
            kind: Kind::Plain,
            help,
        }
    }

    /// A key that must be given.
    pub const fn required(name: &'static str, example: &'static str, help: &'static str) -> Self {
        Key {
            name,
            value: example,
            optional: false,
            required: true,
            kind: Kind::Plain,
            help,
        }
    }
}

/// Reads the keys of one table and records their values, defaults included.
pub struct Section {
    /// Dotted path, empty for the top.
    path: String,
    table: Table,
    place: Option<Place>,
    keys: Vec<Key>,
    resolved: RefCell<toml::Table>,
}

impl Section {
    /// The section `path`; `node` is what the user wrote for it, if anything.
    ///
    /// # Errors
    /// If it is not a table or holds a key that `keys` does not list.
    pub fn new(path: &str, node: Option<&Node>, keys: Vec<Key>) -> Result<Self, ConfigError> {
        let (table, place) = match node {
            None => (Table::default(), None),
            Some(Node {
                value: Value::Table(table),
                place,
            }) => (table.clone(), Some(place.clone())),
            Some(node) => {
                return Err(wrong(
                    path,
                    node,
                    "a table",
                    "write its keys under [section] or in { }",
                ));
            }
        };
        check_keys(path, &table, keys.iter().map(|key| key.name))?;
        Ok(Section {
            path: path.to_owned(),
            table,
            place,
            keys,
            resolved: RefCell::default(),
        })
    }

    /// The keys with their values: as written, and defaults for the rest.
    pub fn resolved(self) -> toml::Table {
        self.resolved.into_inner()
    }

    /// The keys that were read so far, with their values.
    pub fn recorded(&self) -> toml::Table {
        self.resolved.borrow().clone()
    }

    /// The dotted name of a key.
    fn dotted(&self, key: &str) -> String {
        format!("{}.{key}", self.path)
    }

    /// The position of a key, or else of the section, for error messages.
    pub fn place(&self, key: &str) -> Option<Place> {
        let of_key = self
            .table
            .entries
            .get(key)
            .map(|(_, node)| node.place.clone());
        of_key.or_else(|| self.place.clone())
    }

    /// The position of a key, if it was written.
    pub fn written_place(&self, key: &str) -> Option<&Place> {
        self.table.entries.get(key).map(|(_, node)| &node.place)
    }

    /// Whether `key` is from the file, and `chosen`, which decides whether it applies, from `--set`.
    pub fn is_overruled(&self, key: &str, chosen: &str) -> bool {
        let is_set = |key| {
            self.written_place(key)
                .is_some_and(|place| place.source.name == SETTING)
        };
        is_set(chosen) && !is_set(key)
    }

    /// The value of a key, if it was written and is a string.
    pub fn written_text(&self, key: &str) -> Option<&str> {
        match self.table.entries.get(key).map(|(_, node)| &node.value) {
            Some(Value::Text(text)) => Some(text),
            _ => None,
        }
    }

    /// An error about the value of a key.
    pub fn error(
        &self,
        key: &str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> ConfigError {
        let message = format!("{}: {}", self.dotted(key), message.into());
        self.placed(key, ConfigError::new(message, help))
    }

    /// The error of a library that refuses the value of a key. It names its remedy.
    pub fn refused_by(&self, key: &str, error: &impl std::error::Error) -> ConfigError {
        let message = format!("{}: {error}", self.dotted(key));
        self.placed(key, ConfigError::with_its_remedy(message))
    }

    fn placed(&self, key: &str, error: ConfigError) -> ConfigError {
        match self.place(key) {
            Some(place) => error.at(&place, "set here"),
            None => error,
        }
    }

    /// The written value of a key, or its default; `None` for a key without a default that is left out.
    pub fn node(&self, key: &str) -> Result<Option<Node>, ConfigError> {
        let spec = (self.keys.iter().find(|spec| spec.name == key))
            .unwrap_or_else(|| panic!("section {} reads the unlisted key {key}", self.path));
        let node = match self.table.entries.get(key) {
            Some((_, node)) => node.clone(),
            None => {
                if spec.optional || spec.required {
                    return Ok(None);
                }
                let default = format!("{key} = {}", spec.value);
                let table = super::document::parse("default", default)?;
                table.entries[key].1.clone()
            }
        };
        self.resolved
            .borrow_mut()
            .insert(key.to_owned(), node.value.to_toml());
        Ok(Some(node))
    }

    /// The written value of a key, or its default.
    ///
    /// # Errors
    /// If it has none and was left out.
    pub fn required(&self, key: &str) -> Result<Node, ConfigError> {
        self.node(key)?.ok_or_else(|| {
            self.error(
                key,
                "missing",
                match self
                    .keys
                    .iter()
                    .find(|spec| spec.name == key && spec.required)
                {
                    Some(spec) => {
                        format!("add it to [{}], as in `{key} = {}`", self.path, spec.value)
                    }
                    None => format!("add `{key} = …` to [{}]", self.path),
                },
            )
        })
    }

    /// What `read` makes of the value of a key.
    fn read<T>(
        &self,
        key: &str,
        of: impl FnOnce(&request::Value) -> Result<T, Refusal>,
    ) -> Result<T, ConfigError> {
        read(&self.dotted(key), &self.required(key)?, of)
    }

    /// The error about the value of a key.
    pub fn refused(&self, key: &str, refused: Refusal) -> ConfigError {
        match self.table.entries.get(key) {
            Some((_, node)) => refused_at(&self.dotted(key), node, refused),
            None => self.error(key, refused.message, refused.remedy),
        }
    }

    /// Refuses unknown keys of a table inside this one, if the value of the key is one.
    pub fn check_subsection(&self, key: &str, known: &[&'static str]) -> Result<(), ConfigError> {
        match self.table.entries.get(key).map(|(_, node)| &node.value) {
            Some(Value::Table(table)) => {
                check_keys(&self.dotted(key), table, known.iter().copied())
            }
            _ => Ok(()),
        }
    }

    /// A number.
    pub fn number(&self, key: &str, range: NumberRange) -> Result<f64, ConfigError> {
        read_number(&self.dotted(key), &self.required(key)?, range)
    }

    /// A number that may be left out.
    pub fn optional_number(
        &self,
        key: &str,
        range: NumberRange,
    ) -> Result<Option<f64>, ConfigError> {
        (self.node(key)?)
            .map(|node| read_number(&self.dotted(key), &node, range))
            .transpose()
    }

    /// One number for each degree of freedom: a list, or one number for all.
    pub fn numbers(&self, key: &str, count: usize) -> Result<Vec<f64>, ConfigError> {
        let node = self.required(key)?;
        let path = self.dotted(key);
        let Value::List(list) = &node.value else {
            return Ok(vec![read_number(&path, &node, NumberRange::Finite)?; count]);
        };
        if list.len() != count {
            return Err(self.error(
                key,
                format!("{} numbers for {count} degrees of freedom", list.len()),
                "give one number for each degree of freedom, or a single one for all",
            ));
        }
        (list
            .iter()
            .map(|item| read_number(&path, item, NumberRange::Finite)))
        .collect()
    }

    /// A list of numbers, or a single one.
    pub fn some_numbers(&self, key: &str) -> Result<Vec<f64>, ConfigError> {
        let node = self.required(key)?;
        let path = self.dotted(key);
        match &node.value {
            Value::List(list) => (list.iter())
                .map(|item| read_number(&path, item, NumberRange::Finite))
                .collect(),
            _ => Ok(vec![read_number(&path, &node, NumberRange::Finite)?]),
        }
    }

    /// A list of numbers, that may be left out.
    pub fn optional_numbers(
        &self,
        key: &str,
        range: NumberRange,
    ) -> Result<Option<Vec<f64>>, ConfigError> {
        self.optional_list(
            key,
            |path, item| read_number(path, item, range),
            |path, node| Err(wrong(path, node, "a list", "write [1.0, 2.0]")),
        )
    }

    /// A list, that may be left out; `other` reads a value that is not a list.
    fn optional_list<T>(
        &self,
        key: &str,
        read: impl Fn(&str, &Node) -> Result<T, ConfigError>,
        other: impl Fn(&str, &Node) -> Result<Vec<T>, ConfigError>,
    ) -> Result<Option<Vec<T>>, ConfigError> {
        let path = self.dotted(key);
        let Some(node) = self.node(key)? else {
            return Ok(None);
        };
        match &node.value {
            Value::List(list) => list.iter().map(|item| read(&path, item)).collect(),
            _ => other(&path, &node),
        }
        .map(Some)
    }

    /// A whole number of at least `least`.
    pub fn whole(&self, key: &str, least: u64) -> Result<u64, ConfigError> {
        read_whole(&self.dotted(key), &self.required(key)?, least)
    }

    /// A whole number from `least` to `most`.
    pub fn whole_between(&self, key: &str, least: u64, most: u64) -> Result<u64, ConfigError> {
        self.read(key, |value| value.whole(least, most))
    }

    /// A list of whole numbers of at least `least`, that may be left out.
    pub fn optional_wholes(&self, key: &str, least: u64) -> Result<Option<Vec<u64>>, ConfigError> {
        let read = |path: &str, item: &Node| read_whole(path, item, least);
        self.optional_list(key, read, |path, node| Ok(vec![read(path, node)?]))
    }

    /// True or false.
    pub fn flag(&self, key: &str) -> Result<bool, ConfigError> {
        self.read(key, request::Value::flag)
    }

    /// A string.
    pub fn text(&self, key: &str) -> Result<String, ConfigError> {
        self.read(key, |value| value.text().map(str::to_owned))
    }

    /// A string that may be left out.
    pub fn optional_text(&self, key: &str) -> Result<Option<String>, ConfigError> {
        (self.node(key)?)
            .map(|node| {
                read(&self.dotted(key), &node, |value| {
                    value.text().map(str::to_owned)
                })
            })
            .transpose()
    }

    /// One of several strings.
    pub fn choice(&self, key: &str, choices: &[&'static str]) -> Result<&'static str, ConfigError> {
        let text = self.text(key)?;
        (choices.iter().copied().find(|choice| *choice == text)).ok_or_else(|| {
            self.error(
                key,
                format!("unknown value \"{text}\""),
                suggestion(&text, choices.iter().copied()),
            )
        })
    }

    /// Records the value of a key, if it differs from what was written.
    pub fn record(&self, key: &str, value: impl Into<toml::Value>) {
        self.resolved
            .borrow_mut()
            .insert(key.to_owned(), value.into());
    }

    /// Records the values of a table inside this one.
    pub fn adopt(&self, key: &str, inner: Section) {
        self.record(key, inner.resolved());
    }

    /// A list of strings.
    pub fn texts(&self, key: &str) -> Result<Vec<String>, ConfigError> {
        let node = self.required(key)?;
        let path = self.dotted(key);
        let expected = |node: &Node, what| wrong(&path, node, what, "write [\"one\", \"two\"]");
        let Value::List(list) = &node.value else {
            return Err(expected(&node, "a list of strings"));
        };
        (list.iter())
            .map(|item| match &item.value {
                Value::Text(text) => Ok(text.clone()),
                _ => Err(expected(item, "a string")),
            })
            .collect()
    }

    /// A table inside this one, or `None` if it was left out.
    pub fn subsection(&self, key: &str, keys: &[Key]) -> Result<Option<Section>, ConfigError> {
        (self.node(key)?)
            .map(|node| Section::new(&self.dotted(key), Some(&node), keys.to_vec()))
            .transpose()
    }
}

/// What `read` makes of a value.
fn read<T>(
    path: &str,
    node: &Node,
    read: impl FnOnce(&request::Value) -> Result<T, Refusal>,
) -> Result<T, ConfigError> {
    read(&node.plain()).map_err(|refused| refused_at(path, node, refused))
}

/// Reads a number, also one written as a string such as `2^-1` or `pi/2`.
pub fn read_number(path: &str, node: &Node, range: NumberRange) -> Result<f64, ConfigError> {
    read(path, node, |value| value.number(range))
}

/// Reads a whole number, also one written as a string such as `2^15`.
pub fn read_whole(path: &str, node: &Node, least: u64) -> Result<u64, ConfigError> {
    read(path, node, |value| value.whole(least, MAX_WHOLE_NUMBER))
}

/// The error about a value that is refused, or a part of it, at its place.
fn refused_at(path: &str, node: &Node, refused: Refusal) -> ConfigError {
    let part = match (&refused.part, &node.value) {
        (Some(ValuePart::Item(k)), Value::List(list)) => list.get(*k),
        (Some(ValuePart::Key(name)), Value::Table(table)) => {
            table.entries.get(name).map(|(_, node)| node)
        }
        _ => None,
    };
    let path = match &refused.part {
        Some(ValuePart::Key(name)) => format!("{path}.{name}"),
        _ => path.to_owned(),
    };
    let label = (refused.expected).map_or("set here".to_owned(), |what| format!("must be {what}"));
    ConfigError::new(format!("{path} {}", refused.message), refused.remedy)
        .at(&part.unwrap_or(node).place, label)
}

fn wrong(path: &str, node: &Node, expected: &str, help: &str) -> ConfigError {
    let message = format!("{path} is {}, not {expected}", node.plain().kind());
    ConfigError::new(message, help).at(&node.place, format!("must be {expected}"))
}

/// Refuses unknown keys.
pub fn check_keys(
    path: &str,
    table: &Table,
    known: impl Iterator<Item = &'static str> + Clone,
) -> Result<(), ConfigError> {
    for (key, (place, _)) in &table.entries {
        if !known.clone().any(|name| name == key) {
            let what = if path.is_empty() {
                format!("unknown section [{key}]")
            } else {
                format!("[{path}] has no key \"{key}\"")
            };
            return Err(ConfigError::new(what, suggestion(key, known)).at(place, "unknown"));
        }
    }
    Ok(())
}

/// Former names of keys that are not similar enough for a suggestion: the old name and the new one.
const RENAMED: [(&str, &str); 1] = [("stages", "localise")];

/// The known name that is most similar, and all of them.
pub fn suggestion(name: &str, known: impl Iterator<Item = &'static str> + Clone) -> String {
    let renamed = (RENAMED.iter())
        .find(|(old, new)| *old == name && known.clone().any(|one| one == *new))
        .map(|(_, new)| (1.0, *new));
    let nearest = (known.clone())
        .map(|candidate| {
            (
                strsim::normalized_damerau_levenshtein(name, candidate),
                candidate,
            )
        })
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let all = known.collect::<Vec<_>>().join(", ");
    match renamed.or(nearest) {
        Some((similarity, candidate)) if similarity > 0.4 => {
            format!("did you mean \"{candidate}\"? Available: {all}")
        }
        _ => format!("available: {all}"),
    }
}

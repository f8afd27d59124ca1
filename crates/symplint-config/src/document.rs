//! The settings as written: a tree of values with their positions in the source.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use symplint::request;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::error::{ConfigError, Place, Source};

/// The source name of settings from the command line.
pub const SETTING: &str = "--set";

/// A value and its position.
#[derive(Clone, Debug)]
pub struct Node {
    /// The value.
    pub value: Value,
    /// The place of the value.
    pub place: Place,
}

/// A TOML value, other than a date.
#[derive(Clone, Debug)]
pub enum Value {
    /// A string.
    Text(String),
    /// A whole number.
    Integer(i64),
    /// Any other number.
    Float(f64),
    /// True or false.
    Boolean(bool),
    /// A list.
    List(Vec<Node>),
    /// A table.
    Table(Table),
}

/// The keys of a table with their positions.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// By name: where the key is written, and its value.
    pub entries: BTreeMap<String, (Place, Node)>,
}

impl Node {
    /// The value without positions.
    pub fn plain(&self) -> request::Value {
        match &self.value {
            Value::Text(text) => request::Value::Text(text.clone()),
            Value::Integer(number) => match u64::try_from(*number) {
                Ok(whole) => request::Value::Whole(whole),
                Err(_) => request::Value::Number(*number as f64),
            },
            Value::Float(number) => request::Value::Number(*number),
            Value::Boolean(flag) => request::Value::Flag(*flag),
            Value::List(list) => request::Value::List(list.iter().map(Node::plain).collect()),
            Value::Table(table) => request::Value::Table(
                (table.entries.iter())
                    .map(|(key, (_, node))| (key.clone(), node.plain()))
                    .collect(),
            ),
        }
    }
}

impl Value {
    /// The value as TOML.
    pub fn to_toml(&self) -> toml::Value {
        match self {
            Value::Text(text) => toml::Value::String(text.clone()),
            Value::Integer(number) => toml::Value::Integer(*number),
            Value::Float(number) => toml::Value::Float(*number),
            Value::Boolean(flag) => toml::Value::Boolean(*flag),
            Value::List(list) => {
                toml::Value::Array(list.iter().map(|node| node.value.to_toml()).collect())
            }
            Value::Table(table) => (table.entries.iter())
                .map(|(key, (_, node))| (key.clone(), node.value.to_toml()))
                .collect::<toml::Table>()
                .into(),
        }
    }
}

/// The text of a configuration, a file or standard input (`-`), and its name.
pub fn read(path: &Path) -> Result<(String, String), ConfigError> {
    let is_input = path == Path::new("-");
    let name = match is_input {
        true => "standard input".to_owned(),
        false => path.display().to_string(),
    };
    let text = match is_input {
        true => std::io::read_to_string(std::io::stdin()),
        false => std::fs::read_to_string(path),
    };
    match text {
        Ok(text) => Ok((name, text)),
        Err(error) => Err(ConfigError::new(
            format!("cannot read {name}: {error}"),
            "give the path of a configuration, or the name of a system (`symplint list systems`); `symplint init SYSTEM` prints a \
             configuration to start from",
        )),
    }
}

/// Parses a configuration and applies `--set` settings in their order; later ones replace earlier ones.
pub fn load((name, text): (String, String), settings: &[String]) -> Result<Table, ConfigError> {
    let mut table = parse(&name, text)?;
    for setting in settings {
        overlay(&mut table, parse_setting(setting)?);
    }
    Ok(table)
}

/// The `--set` settings alone, for commands without a configuration file.
pub fn settings_only(settings: &[String]) -> Result<Table, ConfigError> {
    let mut table = Table::default();
    for setting in settings {
        overlay(&mut table, parse_setting(setting)?);
    }
    Ok(table)
}

/// Parses TOML.
pub fn parse(name: &str, text: String) -> Result<Table, ConfigError> {
    let source = Arc::new(Source {
        name: name.to_owned(),
        text,
    });
    let parsed = DeTable::parse(&source.text).map_err(|error| {
        let place = Place {
            source: Arc::clone(&source),
            span: error.span().unwrap_or(0..0),
        };
        ConfigError::new(
            format!("{name} is not valid TOML: {}", error.message()),
            "write keys as `name = value` under their [section], and strings in quotes",
        )
        .at(&place, "here")
    })?;
    convert_table(parsed.get_ref(), &source)
}

/// `KEY=VALUE` with a dotted key; a value that is not valid TOML is taken as a string.
fn parse_setting(setting: &str) -> Result<Table, ConfigError> {
    let Some((key, value)) = setting.split_once('=') else {
        return Err(ConfigError::new(
            format!("--set {setting} has no value"),
            "write --set KEY=VALUE, for example --set integrator.name=rk2",
        ));
    };
    let (key, value) = (key.trim(), value.trim());
    let as_written = format!("{key} = {value}");
    if DeTable::parse(&as_written).is_ok() {
        return parse(SETTING, as_written);
    }
    let quoted = toml::Value::String(value.to_owned());
    parse(SETTING, format!("{key} = {quoted}"))
}

/// Puts the entries of `over` into `table`, recursively for tables.
fn overlay(table: &mut Table, over: Table) {
    for (key, (place, node)) in over.entries {
        match (table.entries.get_mut(&key), node.value) {
            (Some((_, old)), Value::Table(new)) if matches!(old.value, Value::Table(_)) => {
                old.place = node.place;
                if let Value::Table(old) = &mut old.value {
                    overlay(old, new);
                }
            }
            (_, value) => {
                let node = Node {
                    value,
                    place: node.place,
                };
                table.entries.insert(key, (place, node));
            }
        }
    }
}

fn convert_table(table: &DeTable<'_>, source: &Arc<Source>) -> Result<Table, ConfigError> {
    let place = |span| Place {
        source: Arc::clone(source),
        span,
    };
    let mut entries = BTreeMap::new();
    for (key, value) in table {
        let node = convert(value, source)?;
        entries.insert(key.get_ref().to_string(), (place(key.span()), node));
    }
    Ok(Table { entries })
}

fn convert(value: &Spanned<DeValue<'_>>, source: &Arc<Source>) -> Result<Node, ConfigError> {
    let place = Place {
        source: Arc::clone(source),
        span: value.span(),
    };
    let unreadable = |what: &str| {
        ConfigError::new(
            format!("{what} cannot be represented"),
            "write a smaller number",
        )
        .at(&place, "here")
    };
    let value = match value.get_ref() {
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Integer(number) => Value::Integer(
            i64::from_str_radix(number.as_str(), number.radix())
                .map_err(|_| unreadable("this whole number"))?,
        ),
        DeValue::Float(number) => Value::Float(
            number
                .as_str()
                .parse()
                .map_err(|_| unreadable("this number"))?,
        ),
        DeValue::Boolean(flag) => Value::Boolean(*flag),
        DeValue::Array(list) => {
            Value::List((list.iter().map(|item| convert(item, source))).collect::<Result<_, _>>()?)
        }
        DeValue::Table(table) => Value::Table(convert_table(table, source)?),
        DeValue::Datetime(_) => {
            return Err(
                ConfigError::new("dates are not accepted", "write a number or a string")
                    .at(&place, "a date"),
            );
        }
    };
    Ok(Node { value, place })
}

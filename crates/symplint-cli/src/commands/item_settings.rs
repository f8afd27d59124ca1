//! Settings of an item of the paper: `--set` over its defaults.

use symplint_config::ConfigError;
use symplint_config::document::{self, Table, Value as Written};
use symplint_config::section::{self, NumberRange, read_number, suggestion};
use symplint_paper::{Item, Kind, SettingError, Settings, Value};

/// All settings of an item: its defaults, changed by `--set` settings.
///
/// # Errors
/// If one cannot be read, is not a setting of the item, or is not accepted.
pub fn item_settings(item: &Item, settings: &[String]) -> Result<Settings, ConfigError> {
    let table = document::settings_only(settings)?;
    section::check_keys(item.id, &table, item.keys.iter().map(|key| key.name))?;
    let refused = |error: SettingError| refused(item, &table, &error);
    let mut settings = Settings::new(item.keys);
    for key in item.keys {
        let Some((_, node)) = table.entries.get(key.name) else {
            continue;
        };
        let value = match (&node.value, key.kind) {
            (Written::Text(word), Kind::Choice { .. }) => Value::Word(word.clone()),
            _ => {
                let path = format!("{}.{}", item.id, key.name);
                Value::Number(read_number(&path, node, NumberRange::Finite)?)
            }
        };
        settings.set(key.name, value).map_err(refused)?;
    }
    if let Some(check) = item.check {
        check(&settings).map_err(refused)?;
    }
    Ok(settings)
}

/// The error of a setting that was refused, at its position.
fn refused(item: &Item, table: &Table, error: &SettingError) -> ConfigError {
    let help = match error {
        SettingError::Word { given, words, .. } => suggestion(given, words.iter().copied()),
        _ => error.remedy(),
    };
    let label = match error {
        SettingError::Value { expected, .. } => format!("must be {expected}"),
        _ => "set here".to_owned(),
    };
    let refused = ConfigError::new(format!("{}.{error}", item.id), help);
    match table.entries.get(error.key()) {
        Some((_, node)) => refused.at(&node.place, label),
        None => refused,
    }
}

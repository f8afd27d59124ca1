//! Settings of an item of the paper: `--set` over its defaults.

use symplint_paper::{Item, Kind, SettingError, Settings, Value};

use super::document::{self, Table, Value as Written};
use super::error::ConfigError;
use super::section::{self, Accept, read_number, suggestion};

/// The `--set` settings of an item, with their positions.
pub struct ItemSettings {
    item: &'static Item,
    table: Table,
}

impl ItemSettings {
    /// Reads the settings.
    ///
    /// # Errors
    /// If one cannot be read, or is not a setting of the item.
    pub fn read(item: &'static Item, settings: &[String]) -> Result<Self, ConfigError> {
        let table = document::settings_only(settings)?;
        section::check_keys(item.id, &table, item.keys.iter().map(|key| key.name))?;
        Ok(ItemSettings { item, table })
    }

    /// All settings of the item: its defaults, changed by these.
    ///
    /// # Errors
    /// If the item does not accept a value.
    pub fn resolved(&self) -> Result<Settings, ConfigError> {
        let mut settings = Settings::new(self.item.keys);
        for key in self.item.keys {
            let Some((_, node)) = self.table.entries.get(key.name) else {
                continue;
            };
            let value = match (&node.value, key.kind) {
                (Written::Text(word), Kind::Choice { .. }) => Value::Word(word.clone()),
                _ => {
                    let path = format!("{}.{}", self.item.id, key.name);
                    Value::Number(read_number(&path, node, Accept::Finite)?)
                }
            };
            settings
                .set(key.name, value)
                .map_err(|error| self.refused(&error))?;
        }
        Ok(settings)
    }

    /// The error of a setting that was refused, at its position.
    pub fn refused(&self, error: &SettingError) -> ConfigError {
        let help = match error {
            SettingError::Word { given, words, .. } => suggestion(given, words.iter().copied()),
            _ => error.remedy(),
        };
        let label = match error {
            SettingError::Value { expected, .. } => format!("must be {expected}"),
            _ => "set here".to_owned(),
        };
        let refused = ConfigError::new(format!("{}.{error}", self.item.id), help);
        match self.table.entries.get(error.key()) {
            Some((_, node)) => refused.at(&node.place, label),
            None => refused,
        }
    }
}

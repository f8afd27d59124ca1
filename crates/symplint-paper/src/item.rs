//! Figures, tables and formulas of the paper as values.

use symplint_report::run_folder::RunFolder;

use super::claim::Claim;
use super::error::PaperError;
use super::settings::{Key, SettingError, Settings};

/// Refuses settings that are valid one by one but not together.
pub type SettingsCheck = fn(&Settings) -> Result<(), SettingError>;

/// One figure, table or set of formulas of the paper.
pub struct Item {
    /// Its name.
    pub id: &'static str,
    /// Its contents.
    pub title: &'static str,
    /// About how much processor time it takes, as `time` counts it.
    pub cost: &'static str,
    /// What can be set.
    pub keys: &'static [Key],
    /// The check of all settings together, if there is one.
    pub check: Option<SettingsCheck>,
    /// Measures, draws and judges.
    pub run: fn(&Settings, &RunFolder) -> Result<Vec<Claim>, PaperError>,
}

//! `symplint reproduce`.

use std::path::Path;
use std::process::ExitCode;

use symplint_paper::{ITEMS, Item, PaperError, claims_summary};
use symplint_report::report::to_json;
use symplint_report::run_folder::RunFolder;

use super::Failure;
use super::list::list;
use crate::cli::{Common, What};
use crate::config::{ItemSettings, suggestion};
use crate::output::{Progress, say};
use crate::provenance;

/// Where results go unless `--out` says otherwise.
const FOLDER: &str = "symplint-paper";

/// Reproduces items of the paper.
pub fn reproduce(ids: &[String], only_list: bool, common: &Common) -> Result<ExitCode, Failure> {
    if only_list {
        return list(What::Figures, common);
    }
    let run = provenance::start();
    let items = chosen(ids)?;
    if !common.set.is_empty() && items.len() != 1 {
        return Err(Failure::Usage {
            message: "--set changes the settings of one item".into(),
            remedy: "name the item, for example: symplint reproduce fig2 --set samples=4096".into(),
        });
    }
    let settings = (items.iter())
        .map(|item| ItemSettings::read(item, &common.set))
        .collect::<Result<Vec<_>, _>>()?;
    let runs = (items.into_iter().zip(&settings))
        .map(|(item, settings)| Ok((item, settings.resolved()?)))
        .collect::<Result<Vec<_>, Failure>>()?;
    let folder = RunFolder::create(common.out.as_deref().unwrap_or(Path::new(FOLDER)))?;
    let progress = Progress::new("items", common.quiet || common.json);
    progress.plan(runs.len());
    let claims = symplint_paper::reproduce(&runs, &folder, &run, &|event| progress.item(event));
    progress.finish();
    let claims = claims.map_err(|error| match (error, &settings[..]) {
        // Several items run with their defaults, and these are all right.
        (PaperError::Setting(error), [settings]) => settings.refused(&error).into(),
        (error, _) => Failure::from(error),
    })?;
    if common.json {
        say(to_json(&claims))?;
    } else {
        say(claims_summary(&claims))?;
        say(format!(
            "\nFigures, data and claims.md are in {}",
            folder.path().display()
        ))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn chosen(ids: &[String]) -> Result<Vec<&'static Item>, Failure> {
    if ids.is_empty() {
        return Ok(ITEMS.iter().collect());
    }
    (ids.iter())
        .map(|id| {
            (ITEMS.iter().find(|item| item.id == id)).ok_or_else(|| Failure::Unknown {
                what: "item",
                name: id.clone(),
                suggestion: suggestion(id, ITEMS.iter().map(|item| item.id)),
            })
        })
        .collect()
}

//! `symplint reproduce`.

use std::path::Path;
use std::process::ExitCode;

use rayon::prelude::*;

use super::Failure;
use super::list::list;
use crate::cli::{Common, What};
use crate::config::{settings, suggestion};
use crate::output::{Progress, RunFolder, say, to_json};
use crate::paper::{self, Claim, ITEMS, Item};

/// Where results go unless `--out` says otherwise.
const FOLDER: &str = "symplint-paper";

/// Reproduces items of the paper.
pub fn reproduce(ids: &[String], only_list: bool, common: &Common) -> Result<ExitCode, Failure> {
    if only_list {
        return list(What::Figures, common);
    }
    let items = chosen(ids)?;
    if !common.set.is_empty() && items.len() != 1 {
        return Err(Failure::Usage {
            message: "--set changes the settings of one item".into(),
            remedy: "name the item, for example: symplint reproduce fig2 --set samples=4096".into(),
        });
    }
    let folder = RunFolder::create(common.out.as_deref().unwrap_or(Path::new(FOLDER)))?;
    let progress = Progress::new("items", common.quiet || common.json);
    progress.plan(items.len());
    // Beside each other: drawing and writing of one fill the gaps of another.
    let claims: Vec<Vec<Claim>> = (items.into_par_iter())
        .map(|item| {
            progress.say(item.id);
            let section = settings(item.id, &common.set, item.keys)?;
            let claims = (item.run)(&section, &folder)?;
            progress.step();
            Ok(claims)
        })
        .collect::<Result<_, Failure>>()?;
    let claims = claims.concat();
    progress.finish();
    folder.write_json("claims.json", &claims)?;
    folder.write_text("claims.md", &paper::claims_markdown(&claims))?;
    if common.json {
        say(to_json(&claims))?;
    } else {
        say(paper::claims_summary(&claims))?;
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

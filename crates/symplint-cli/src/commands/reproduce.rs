//! `symplint reproduce`.

use symplint_config::{parse_number, suggestion};
use symplint_paper::{ITEMS, Item, Settings, Value, claims_summary};
use symplint_report::report::to_json;
use symplint_run::RunOutput;

use super::item_settings::item_settings;
use super::list::list;
use crate::cli::{ListTopic, ReproduceArgs};
use crate::failure::Failure;
use crate::output::{Progress, say};
use crate::provenance;
use crate::status::{SUCCESS, Status};

/// Reproduces items of the paper.
pub fn reproduce(arguments: &ReproduceArgs) -> Result<Status, Failure> {
    if arguments.list {
        return list(ListTopic::Figures);
    }
    let started = provenance::start();
    let items = chosen(&arguments.ids)?;
    let set = &arguments.set;
    if !set.is_empty() && items.len() != 1 {
        return Err(Failure::Usage {
            message: "--set changes the settings of one item".into(),
            remedy: "name the item, for example: symplint reproduce fig2 --set samples=4096".into(),
        });
    }
    let runs = (items.into_iter())
        .map(|item| Ok((item, item_settings(item, set)?)))
        .collect::<Result<Vec<_>, Failure>>()?;
    let config = (runs.iter())
        .map(|(item, settings)| (item.id.to_owned(), table(settings).into()))
        .collect();
    let (out, force) = (&arguments.out, arguments.force);
    let output = RunOutput::open(out, "reproduce", &config, force, parse_number)?;
    let folder = &output.folder;
    output.remove_earlier(&[])?;
    folder.write_config(&output.config)?;
    let progress = Progress::new("items", arguments.quiet || arguments.json);
    progress.plan(runs.len());
    let claims = symplint_paper::reproduce(&runs, folder, &started, &|event| progress.item(event));
    progress.finish();
    let claims = claims?;
    if arguments.json {
        say(to_json(&claims))?;
    } else {
        say(claims_summary(&claims, arguments.quiet))?;
        if !arguments.quiet {
            let path = folder.path().display();
            say(format!("\nFigures, data and claims.md are in {path}"))?;
        }
    }
    Ok(SUCCESS)
}

/// The settings of an item as TOML.
fn table(settings: &Settings) -> toml::Table {
    (settings.values())
        .map(|(key, value)| {
            let value = match value {
                Value::Number(number) if number.fract() == 0.0 && number.abs() < 1e15 => {
                    (*number as i64).into()
                }
                Value::Number(number) => (*number).into(),
                Value::Word(word) => word.clone().into(),
            };
            (key.to_owned(), value)
        })
        .collect()
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

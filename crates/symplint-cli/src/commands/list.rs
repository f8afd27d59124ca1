//! `symplint list`.

use symplint::rules::RuleKind;
use symplint_config::SYSTEMS;
use symplint_models::integrators::aliases::ALIASES;
use symplint_models::integrators::catalogue::IntegratorInfo;
use symplint_paper::ITEMS;
use symplint_plasma::CATALOGUE;
use symplint_report::table::definitions;

use crate::cli::ListTopic;
use crate::failure::Failure;
use crate::output::{say, width};
use crate::status::{SUCCESS, Status};

/// Prints the systems, integrators, rules or items of the paper.
pub fn list(what: ListTopic) -> Result<Status, Failure> {
    let rows: Vec<(String, String)> = match what {
        ListTopic::Systems => (SYSTEMS.iter())
            .map(|info| {
                let keys: Vec<&str> = info.keys.iter().map(|key| key.name).collect();
                let text = format!("{}. Keys: {}", info.summary, keys.join(", "));
                (info.name.to_owned(), text)
            })
            .collect(),
        ListTopic::Integrators => (CATALOGUE.iter())
            .map(|info| (info.name.to_owned(), integrator(info)))
            .collect(),
        ListTopic::Rules => (RuleKind::CHOICES.iter())
            .map(|rule| (rule.name().to_owned(), rule.summary().to_owned()))
            .collect(),
        ListTopic::Figures => (ITEMS.iter())
            .map(|item| {
                (
                    item.id.to_owned(),
                    format!("{}; about {}", item.title, item.cost),
                )
            })
            .collect(),
    };
    say(definitions(&rows, width()))?;
    Ok(SUCCESS)
}

/// The line of an integrator in the list.
fn integrator(info: &IntegratorInfo) -> String {
    let symplectic = if info.symplectic {
        "symplectic"
    } else {
        "not symplectic"
    };
    let mut text = match info.order {
        0 => format!("Order not defined, {symplectic}. "),
        order => format!("Order {order}, {symplectic}. "),
    };
    text += info.summary;
    text += &match info.reference {
        "none" => ".".to_owned(),
        reference => format!(" ({reference})."),
    };
    if let [default, others @ ..] = info.variants {
        text += &format!(" Variants: {default} (default), {}.", others.join(", "));
    }
    let aliases: Vec<String> = (ALIASES.iter())
        .filter(|alias| alias.integrator == info.name)
        .map(|alias| match alias.variants {
            [] => alias.name.to_owned(),
            variants => format!("{} ({})", alias.name, variants.join(", ")),
        })
        .collect();
    if !aliases.is_empty() {
        text += &format!(" Other names: {}.", aliases.join(", "));
    }
    text
}

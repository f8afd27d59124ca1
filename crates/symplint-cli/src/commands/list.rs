//! `symplint list`.

use std::process::ExitCode;

use symplint_models::integrators::aliases::ALIASES;
use symplint_models::integrators::catalogue::{CATALOGUE, IntegratorInfo};
use symplint_paper::ITEMS;
use symplint_report::table::definitions;

use super::Failure;
use crate::cli::What;
use crate::config::SYSTEMS;
use crate::output::{say, width};

/// Prints the systems, integrators, rules or items of the paper.
pub fn list(what: What) -> Result<ExitCode, Failure> {
    let rows: Vec<(String, String)> = match what {
        What::Systems => (SYSTEMS.iter())
            .map(|info| {
                let keys: Vec<&str> = info.keys.iter().map(|key| key.name).collect();
                let text = format!("{}. Keys: {}", info.summary, keys.join(", "));
                (info.name.to_owned(), text)
            })
            .collect(),
        What::Integrators => (CATALOGUE.iter())
            .map(|info| (info.name.to_owned(), integrator(info)))
            .collect(),
        What::Rules => (RULES.iter())
            .map(|(name, text)| (name.to_string(), text.to_string()))
            .collect(),
        What::Figures => (ITEMS.iter())
            .map(|item| {
                (
                    item.id.to_owned(),
                    format!("{}; about {}", item.title, item.cost),
                )
            })
            .collect(),
    };
    say(definitions(&rows, width()))?;
    Ok(ExitCode::SUCCESS)
}

/// What the list says of an integrator.
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

const RULES: [(&str, &str); 5] = [
    (
        "auto",
        "Pseudospectral; piecewise where the advanced loop is broken or has kinks; streaming where ensembles \
         do not fit into memory. The default.",
    ),
    (
        "pseudospectral",
        "Differentiates q by Fourier transform (paper, section 2.3 and appendix A). Exact to round-off on \
         smooth loops; on loops with kinks the error is a power of the number of samples.",
    ),
    (
        "piecewise",
        "Chebyshev interpolation between the breaks, each of which is located and closed. For broken loops \
         and loops with kinks, nearly to round-off.",
    ),
    (
        "streaming",
        "Differences of order 16 along the loop, of samples that are made, advanced and dropped one after \
         another. For ensembles that do not fit into memory: a few dozen states are kept.",
    ),
    (
        "finite-difference",
        "Increments of q over the cells that the cut-offs keep (paper, appendix B). For broken loops as in \
         the paper, to a few digits.",
    ),
];

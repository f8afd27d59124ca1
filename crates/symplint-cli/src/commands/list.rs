//! `symplint list`.

use std::process::ExitCode;

use symplint_models::integrators::catalogue::CATALOGUE;
use symplint_paper::ITEMS;
use symplint_report::table::plain_table;

use super::Failure;
use crate::cli::What;
use crate::config::SYSTEMS;
use crate::output::{say, width};

/// Prints the systems, integrators, rules or items of the paper.
pub fn list(what: What) -> Result<ExitCode, Failure> {
    let (header, rows): (&[&str], Vec<Vec<String>>) = match what {
        What::Systems => (
            &["system", "what it is", "keys"],
            (SYSTEMS.iter())
                .map(|info| {
                    let keys: Vec<&str> = info.keys.iter().map(|key| key.name).collect();
                    vec![info.name.into(), info.summary.into(), keys.join(", ")]
                })
                .collect(),
        ),
        What::Integrators => (
            &[
                "integrator",
                "variants",
                "order",
                "symplectic",
                "what it is",
            ],
            (CATALOGUE.iter())
                .map(|info| {
                    vec![
                        info.name.into(),
                        info.variants.join(", "),
                        info.order.to_string(),
                        if info.symplectic { "yes" } else { "no" }.into(),
                        format!("{} ({})", info.summary, info.reference),
                    ]
                })
                .collect(),
        ),
        What::Rules => (
            &["rule", "what it is", "use it for"],
            vec![
                vec![
                    "auto".into(),
                    "pseudospectral; piecewise where the advanced loop is broken or has kinks; streaming \
                     where ensembles would not fit into memory"
                        .into(),
                    "everything".into(),
                ],
                vec![
                    "pseudospectral".into(),
                    "q differentiated by Fourier transform (paper, section 2.3, appendix A)".into(),
                    "smooth loops, and kinked ones to a power of the samples".into(),
                ],
                vec![
                    "piecewise".into(),
                    "Chebyshev pieces between the breaks, each of them found and closed".into(),
                    "broken and kinked loops, to near round-off".into(),
                ],
                vec![
                    "streaming".into(),
                    "differences of order 16 along the loop, of samples that pass by".into(),
                    "ensembles that do not fit into memory: a few dozen states are enough".into(),
                ],
                vec![
                    "finite-difference".into(),
                    "increments of q over the cells that cut-offs retain (appendix B)".into(),
                    "broken loops as the paper does, to a few digits".into(),
                ],
            ],
        ),
        What::Figures => (
            &["item", "what it shows", "cost"],
            (ITEMS.iter())
                .map(|item| vec![item.id.into(), item.title.into(), item.cost.into()])
                .collect(),
        ),
    };
    say(plain_table(header, rows, width()))?;
    Ok(ExitCode::SUCCESS)
}

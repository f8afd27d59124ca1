//! Which particle-in-cell schemes are symplectic: the schemes that people use, one by one.

mod claims;
mod conservation;
mod figure;
mod plasma;
mod scheme_result;
mod schemes;
mod small_loops;
mod table;

use rayon::prelude::*;
use symplint_report::run_folder::RunFolder;

use super::claim::Claim;
use super::error::PaperError;
use super::item::Item;
use super::settings::{Key, SettingError, Settings, check_steps};
use scheme_result::SchemeResult;

pub const ITEM: Item = Item {
    id: "census",
    title: "particle-in-cell schemes: which are symplectic, and what else they conserve",
    cost: "25 s",
    keys: &[
        Key::whole(
            "budget",
            100_000,
            2000,
            "evaluations of each explicit scheme for its verdict; implicit ones have a fifth",
        ),
        Key::positive(
            "step_size",
            0.2,
            "h of the run over which energy, Gauss' law and momentum are watched",
        ),
        Key::positive("time", 20.0, "length of that run"),
        Key::whole("seed", 11, 0, "seed of the initial states and the loops"),
    ],
    check: Some(check),
    run,
};

/// Steps of a run, of every scheme: its halves are compared.
const STEPS: [f64; 2] = [10.0, 1e5];

fn check(settings: &Settings) -> Result<(), SettingError> {
    let time = ("time", settings.number("time"));
    check_steps(time, settings.number("step_size"), STEPS)
}

fn run(settings: &Settings, folder: &RunFolder) -> Result<Vec<Claim>, PaperError> {
    let schemes = schemes::all(settings.whole("seed"))?;
    let rows: Vec<SchemeResult> = (schemes.par_iter())
        .map(|scheme| SchemeResult::of(scheme, settings))
        .collect::<Result<_, PaperError>>()?;
    let records: Vec<_> = rows.iter().map(|row| &row.record).collect();
    folder.write_csv("census.csv", &records)?;
    folder.write_text(
        "census.md",
        &table::markdown(&rows, settings.number("step_size")),
    )?;
    figure::draw(&rows).save(&folder.figures(), "census")?;
    Ok(claims::claims(&rows))
}

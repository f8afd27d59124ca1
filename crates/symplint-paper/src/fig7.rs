//! Figure 7: particle-in-cell against the step size.

use symplint_report::run_folder::RunFolder;

use super::claim::Claim;
use super::error::PaperError;
use super::fig7_claims;
use super::item::Item;
use super::pic::{DEGREES, LAMBDA, MAX_PARTICLES, RK2, SEED, STRANG, Setup, SweepRange};
use super::pic_panels::{measure_panels, plain_panels};
use super::settings::{Key, Settings};
use super::sweep::{chosen_halvings, halvings_to};

pub const ITEM: Item = Item {
    id: "fig7",
    title: "particle-in-cell: defect against the step size",
    cost: "1 s",
    keys: &[
        Key::whole_between("particles", 2, (1, MAX_PARTICLES), "number of particles"),
        Key::whole("samples", 1 << 15, 3, "samples of the loop"),
        halvings_to(10),
        LAMBDA,
        STRANG,
        RK2,
        SEED,
    ],
    check: None,
    run,
};

fn run(settings: &Settings, folder: &RunFolder) -> Result<Vec<Claim>, PaperError> {
    let setup = Setup::read(settings);
    let samples = settings.count("samples");
    let over = SweepRange::Steps {
        samples,
        step_sizes: chosen_halvings(settings),
    };
    let panels = plain_panels(DEGREES.map(|(degree, _)| degree), |degree| {
        Some((if degree == 1 { 2.0 } else { 4.0 }, "RK2"))
    });
    let (curves, figure) = measure_panels(&setup, &panels, &over)?;
    figure.save(&folder.figures(), "fig7")?;
    folder.write_csv("fig7.csv", &curves.records())?;
    Ok(fig7_claims::claims(&curves, &setup, samples))
}

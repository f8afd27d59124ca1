//! Figure 7: particle-in-cell against the step size.

use super::Item;
use super::claim::Claim;
use super::fig7_claims;
use super::pic::{DEGREES, LAMBDA, Over, RK2, SEED, STRANG, Setup};
use super::pic_panels::{measure_panels, plain_panels};
use super::sweep::chosen_halvings;
use crate::commands::Failure;
use crate::config::{Key, Section};
use crate::output::RunFolder;

pub const ITEM: Item = Item {
    id: "fig7",
    title: "particle-in-cell: defect against the step size",
    cost: "1 s",
    keys: &[
        Key::new("particles", "2", "number of particles"),
        Key::new("samples", "\"2^15\"", "samples of the loop"),
        Key::new("halvings", "10", "step sizes 2^-1 … 2^-halvings"),
        LAMBDA,
        STRANG,
        RK2,
        SEED,
    ],
    run,
};

fn run(settings: &Section, folder: &RunFolder) -> Result<Vec<Claim>, Failure> {
    let setup = Setup::read(settings)?;
    let samples = settings.whole("samples", 3)? as usize;
    let over = Over::Steps {
        samples,
        step_sizes: chosen_halvings(settings)?,
    };
    let panels = plain_panels(DEGREES.map(|(degree, _)| degree), |degree| {
        Some((if degree == 1 { 2.0 } else { 4.0 }, "RK2"))
    });
    let (curves, figure) = measure_panels(&setup, &panels, &over)?;
    figure.save(&folder.figures(), "fig7")?;
    folder.write_csv("fig7.csv", &curves.records())?;
    Ok(fig7_claims::claims(&curves, &setup, samples))
}

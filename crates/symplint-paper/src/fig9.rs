//! Figure 9: particle-in-cell with binary filtering.

use symplint_report::run_folder::RunFolder;

use super::claim::Claim;
use super::error::PaperError;
use super::fig9_claims::{self, PASSES, filtered};
use super::item::Item;
use super::pic::{
    Curves, DEGREES, INTEGRATORS, LAMBDA, MAX_PARTICLES, RK2, SEED, STRANG, Setup, SweepRange,
};
use super::pic_panels::{PanelCases, measure_panels};
use super::settings::{Key, Settings};
use super::sweep::{chosen_halvings, doublings, halvings_to};

pub const ITEM: Item = Item {
    id: "fig9",
    title: "particle-in-cell with binary filtering",
    cost: "1 s",
    keys: &[
        Key::whole_between("particles", 2, (1, MAX_PARTICLES), "number of particles"),
        Key::whole("samples", 1 << 15, 3, "samples of the loop"),
        halvings_to(10),
        Key::positive(
            "step_size",
            0.1,
            "h of the sweep over the number of samples, which is not drawn",
        ),
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
    let over_steps = SweepRange::Steps {
        samples,
        step_sizes: chosen_halvings(settings),
    };
    let over_samples = SweepRange::Samples {
        counts: doublings(64, samples as u64),
        step_size: settings.number("step_size"),
    };
    let panels: Vec<PanelCases> = (DEGREES[..2].iter())
        .map(|&(degree, name)| PanelCases {
            title: format!("two-stream, {name} interpolation"),
            cases: PASSES.map(|passes| filtered(degree, passes)).to_vec(),
            reference: None,
        })
        .collect();
    let (mut steps, figure) = measure_panels(&setup, &panels, &over_steps)?;
    figure.save(&folder.figures(), "fig9")?;
    // The paper leaves the cubic case out, as analogous: measured, but not drawn.
    let mut counts = Curves(Vec::new());
    for passes in PASSES {
        for integrator in INTEGRATORS {
            steps
                .0
                .push(setup.measure(filtered(3, passes), integrator, &over_steps)?);
        }
        for degree in [2, 3] {
            counts
                .0
                .push(setup.measure(filtered(degree, passes), "Strang", &over_samples)?);
        }
    }
    folder.write_csv("fig9.csv", &steps.records())?;
    folder.write_csv("fig9_samples.csv", &counts.records())?;
    fig9_claims::claims(&steps, &counts, &setup, samples)
}

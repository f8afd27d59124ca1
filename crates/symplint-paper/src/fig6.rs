//! Figure 6: particle-in-cell against the number of samples.

use symplint_report::run_folder::RunFolder;

use super::claim::Claim;
use super::error::PaperError;
use super::item::Item;
use super::pic::{DEGREES, LAMBDA, MAX_PARTICLES, RK2, SEED, STRANG, Setup, SweepRange};
use super::pic_panels::{measure_panels, plain_panels};
use super::settings::{Key, Settings};
use super::sweep::doublings;
use super::{fig6_claims, particle_scaling};

pub const ITEM: Item = Item {
    id: "fig6",
    title: "particle-in-cell: defect against the number of samples",
    cost: "9 s",
    keys: &[
        Key::whole_between("particles", 128, (1, MAX_PARTICLES), "number of particles"),
        Key::positive("step_size", 0.1, "h"),
        Key::whole("from", 1 << 6, 3, "fewest samples"),
        Key::whole("to", 1 << 15, 3, "most samples"),
        Key::whole(
            "scaling_to",
            1 << 18,
            3,
            "most samples for the error against the number of particles",
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
    let step_size = settings.number("step_size");
    let (from, to) = (settings.whole("from"), settings.whole("to"));
    let scaling_to = settings.whole("scaling_to");
    let over = SweepRange::Samples {
        counts: doublings(from, to),
        step_size,
    };
    let panels = plain_panels(DEGREES.map(|(degree, _)| degree), |degree| {
        (degree > 1).then_some((-(degree as f64), "Strang"))
    });
    let (curves, figure) = measure_panels(&setup, &panels, &over)?;
    figure.save(&folder.figures(), "fig6")?;
    folder.write_csv("fig6.csv", &curves.records())?;
    let mut claims = fig6_claims::claims(&curves, &setup, step_size);
    let paper = fig6_claims::of_the_paper(&setup, step_size);
    let scaling = particle_scaling::claims(&setup, step_size, scaling_to, folder)?;
    claims.extend(scaling.into_iter().map(|claim| claim.resolved_if(paper)));
    Ok(claims)
}

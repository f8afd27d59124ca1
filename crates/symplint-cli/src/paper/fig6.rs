//! Figure 6: particle-in-cell against the number of samples.

use super::Item;
use super::claim::Claim;
use super::pic::{DEGREES, LAMBDA, Over, RK2, SEED, STRANG, Setup};
use super::pic_panels::{measure_panels, plain_panels};
use super::sweep::doublings;
use super::{fig6_claims, particle_scaling};
use crate::commands::Failure;
use crate::config::{Accept, Key, Section};
use crate::output::RunFolder;

pub const ITEM: Item = Item {
    id: "fig6",
    title: "particle-in-cell: defect against the number of samples",
    cost: "9 s",
    keys: &[
        Key::new("particles", "128", "number of particles"),
        Key::new("step_size", "0.1", "h"),
        Key::new("from", "\"2^6\"", "fewest samples"),
        Key::new("to", "\"2^15\"", "most samples"),
        Key::new(
            "scaling_to",
            "\"2^18\"",
            "most samples for the error against the number of particles",
        ),
        LAMBDA,
        STRANG,
        RK2,
        SEED,
    ],
    run,
};

fn run(settings: &Section, folder: &RunFolder) -> Result<Vec<Claim>, Failure> {
    let setup = Setup::read(settings)?;
    let step_size = settings.number("step_size", Accept::Positive)?;
    let (from, to) = (settings.whole("from", 3)?, settings.whole("to", 3)?);
    let scaling_to = settings.whole("scaling_to", 3)?;
    let over = Over::Samples {
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

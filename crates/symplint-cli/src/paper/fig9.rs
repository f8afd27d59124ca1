//! Figure 9: particle-in-cell with binary filtering.

use symplint::Rule;
use symplint_models::pic::ShapeFamily;

use super::Item;
use super::claim::{Claim, Judgement};
use super::pic::{LAMBDA, MOST_PARTICLES, RK2, SEED, STRANG, Steps, plasma, rule, sweep_plasma};
use super::sweep::{Record, halvings, worst};
use crate::commands::Failure;
use crate::config::{Key, Section};
use crate::figure::{Figure, Panel};
use crate::output::{RunFolder, error_axis, step_axis};

pub const ITEM: Item = Item {
    id: "fig9",
    title: "particle-in-cell with binary filtering",
    cost: "8 s",
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

/// Filter passes.
const PASSES: [u32; 3] = [0, 2, 4];

fn run(settings: &Section, folder: &RunFolder) -> Result<Vec<Claim>, Failure> {
    let particles = settings.whole_between("particles", 1, MOST_PARTICLES)? as usize;
    let samples = settings.whole("samples", 3)? as usize;
    let step_sizes = halvings(-1, -(settings.whole("halvings", 2)?.min(40) as i32));
    let seed = settings.whole("seed", 0)?;
    let steps = Steps::read(settings)?;
    let mut records: Vec<Record> = Vec::new();
    let mut panels = Vec::new();
    for (degree, name) in [(1, "linear"), (2, "quadratic")] {
        let rule: Rule = rule(degree, settings)?;
        let mut drawn = Vec::new();
        for (index, passes) in PASSES.into_iter().enumerate() {
            let plasma = plasma(
                "two-stream",
                particles,
                ShapeFamily::BSpline,
                degree,
                passes,
                seed,
            )?;
            let swept = sweep_plasma(
                &format!("{name}, s = {passes}"),
                &plasma,
                &steps,
                rule,
                |study| study.over_steps(samples, &step_sizes),
                Record::over_step,
            )?;
            for (offset, mut curve) in swept.curves.into_iter().enumerate() {
                curve.label = format!("{}, s = {passes}", curve.label);
                curve.color = 2 * index + offset;
                drawn.push(curve);
            }
            records.extend(swept.records);
        }
        panels.push(Panel {
            title: format!("two-stream, {name} interpolation"),
            x: step_axis(),
            y: error_axis(),
            series: drawn,
            equal_aspect: false,
        });
    }
    Figure {
        title: None,
        panels,
        columns: 2,
    }
    .save(&folder.figures(), "fig9")?;
    folder.write_csv("fig9.csv", &records)?;

    let strang = |name: &str, passes: u32| -> Vec<&Record> {
        let case = format!("{name}, s = {passes}");
        (records.iter())
            .filter(|r| r.case == case && r.integrator == "Strang")
            .collect()
    };
    let quadratic = PASSES.map(|passes| worst(strang("quadratic", passes).into_iter()));
    let floor = (PASSES
        .iter()
        .flat_map(|&passes| strang("quadratic", passes)))
    .map(Record::floor)
    .fold(0.0, f64::max);
    // The largest steps are where the defects of broken loops stand clear of the quadrature.
    let linear = PASSES.map(|passes| worst(strang("linear", passes).into_iter()));
    Ok(vec![
        Claim {
            item: "fig9",
            place: "section 5.3",
            says: "linear: filtering has almost no effect on the defect".into(),
            measured: format!(
                "largest defect of Strang {:.1e}, {:.1e}, {:.1e} for s = 0, 2, 4: of the same order, but smaller",
                linear[0], linear[1], linear[2]
            ),
            judgement: Judgement::with_correction(
                linear[2] > 0.5 * linear[0],
                linear[2] > 0.1 * linear[0],
            ),
        },
        Claim {
            item: "fig9",
            place: "section 5.3",
            says: "quadratic: filtering reduces the defect slightly".into(),
            measured: format!(
                "largest defect of Strang {:.1e}, {:.1e}, {:.1e} for s = 0, 2, 4, below the floor {floor:.1e}",
                quadratic[0], quadratic[1], quadratic[2]
            ),
            judgement: Judgement::with_correction(
                quadratic[2] <= quadratic[0] && quadratic[2] > 0.1 * quadratic[0],
                quadratic[2] <= quadratic[0],
            ),
        },
    ])
}

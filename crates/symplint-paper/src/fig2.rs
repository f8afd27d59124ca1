//! Figure 2: the loop integral of the nonlinear pendulum against time.

use std::f64::consts::PI;
use std::sync::Arc;

use symplint::{Circle, Rule, Trace};
use symplint_models::Separable;
use symplint_models::systems::{Pendulum, PendulumPotential};
use symplint_report::figure::{Figure, Panel, Scale, Style};
use symplint_report::plot::{axis, error_axis, series, uncertainty_in_time};
use symplint_report::run_folder::RunFolder;

use super::claim::{Claim, Judgement, Origin};
use super::error::PaperError;
use super::item::Item;
use super::settings::{Key, Settings};
use super::sweep::step_of;

pub const ITEM: Item = Item {
    id: "fig2",
    title: "nonlinear pendulum: loop integral against time, two loops",
    cost: "1 s",
    keys: &[
        Key::positive("step_size", 0.1, "h of position-first Strang splitting"),
        Key::whole("steps", 1000, 1, "number of steps"),
        Key::whole("samples", 2048, 3, "samples of each loop"),
    ],
    check: None,
    run,
};

/// Largest defect that can be rounding error.
const MAX_ROUNDING_ERROR: f64 = 1e-12;

fn run(settings: &Settings, folder: &RunFolder) -> Result<Vec<Claim>, PaperError> {
    let trace = Trace {
        rule: Rule::Pseudospectral,
        samples: settings.count("samples"),
        step_size: settings.number("step_size"),
        steps: settings.count("steps"),
        snapshots: vec![],
    };
    let pendulum: Arc<dyn Separable> = Arc::new(Pendulum::new(PendulumPotential::Cos));
    let map = step_of("strang", "position-first", &pendulum)?;
    let mut panels = Vec::new();
    let mut onset = Vec::new();
    for (name, title, centre) in [
        ("stable", "loop around (π, ½)", (PI, 0.5)),
        ("x_point", "loop around (0, 0)", (0.0, 0.0)),
    ] {
        let circle = Circle::new(vec![centre.0], vec![centre.1], 1.0)?;
        let record = trace.run(&*map, &circle, None)?;
        folder.write_csv(&format!("fig2_{name}.csv"), &record.points)?;
        let lost = record
            .points
            .iter()
            .find(|point| point.defect > MAX_ROUNDING_ERROR);
        onset.push(lost.map(|point| point.time));
        let defects = record
            .points
            .iter()
            .map(|point| (point.time, point.defect))
            .collect();
        panels.push(Panel {
            title: title.into(),
            x: axis("time t", Scale::Linear),
            y: error_axis(),
            series: vec![
                series("defect", defects, Style::Line, 0),
                uncertainty_in_time(&record.points),
            ],
            equal_aspect: false,
        });
    }
    Figure::new(panels, 2).save(&folder.figures(), "fig2")?;

    let describe = |time: Option<f64>| match time {
        None => "never".to_owned(),
        Some(time) => format!("at t = {time:.1}"),
    };
    let both = format!(
        "the defect leaves round-off (1e-12) {} round (π, ½) and {} round (0, 0)",
        describe(onset[0]),
        describe(onset[1])
    );
    Ok(vec![
        Claim {
            item: "fig2",
            origin: Origin::Paper,
            place: "section 3.2, figure 2",
            says: "a loop that is well resolved stays so for at least a few steps, how long depends on where it lies"
                .into(),
            measured: both.clone(),
            judgement: Judgement::of(
                onset[1].is_none_or(|time| time > 5.0 * trace.step_size) && onset[0] != onset[1],
            ),
        },
        Claim {
            item: "fig2",
            origin: Origin::Paper,
            place: "section 3.2, text against figures",
            says: "H = p²/2 + sin q has its loops round (π, ½) and (0, 0)".into(),
            measured: format!("with cos q, for which q = π is stable and q = 0 an x-point, {both}"),
            judgement: Judgement::with_correction(
                false,
                onset[0].is_none() && onset[1].is_some_and(|time| time < 10.0),
            ),
        },
    ])
}

//! Figure 3: the interpolated pendulum against the number of samples.

use symplint::rules::Cutoffs;
use symplint_report::figure::{Figure, Panel, Scale};
use symplint_report::plot::{axis, error_axis, reference_slope};
use symplint_report::run_folder::RunFolder;

use super::claim::{Claim, Judgement, Origin};
use super::error::PaperError;
use super::interpolated::{CASES, circle_round, sweep_case};
use super::item::Item;
use super::settings::{Key, Settings};
use super::sweep::{Record, doublings, power_law, trend_text};

pub const ITEM: Item = Item {
    id: "fig3",
    title: "interpolated pendulum: defect against the number of samples",
    cost: "2 s",
    keys: &[
        Key::positive("step_size", 0.1, "h"),
        Key::whole("from", 1 << 4, 3, "fewest samples"),
        Key::whole("to", 1 << 20, 3, "most samples"),
        Key::number("p0", 0.0, "centre of the loop, momentum"),
        Key::positive("cutoff", 10.0, "λ_q = λ_p of the finite-difference rule"),
    ],
    check: None,
    run,
};

fn run(settings: &Settings, folder: &RunFolder) -> Result<Vec<Claim>, PaperError> {
    let h = settings.number("step_size");
    let (from, to) = (settings.whole("from"), settings.whole("to"));
    let counts = doublings(from, to);
    let circle = circle_round(settings.number("p0"))?;
    let cutoffs = Cutoffs::relative(settings.number("cutoff"));
    let mut records: Vec<Record> = Vec::new();
    let mut panels = Vec::new();
    for case in &CASES {
        let swept = sweep_case(
            case,
            &circle,
            cutoffs,
            |sweep| sweep.over_samples(&counts, h),
            Record::over_samples,
        )?;
        records.extend(swept.records);
        let mut drawn = swept.curves;
        if let Some(order) = case.sample_order {
            let strang = drawn[0].points.clone();
            drawn.push(reference_slope(&strang, -order, "Nₛ"));
        }
        drawn.push(swept.uncertainty);
        panels.push(Panel {
            title: case.title.into(),
            x: axis("samples Nₛ", Scale::Log2),
            y: error_axis(),
            series: drawn,
            equal_aspect: false,
        });
    }
    Figure::new(panels, 2).save(&folder.figures(), "fig3")?;
    folder.write_csv("fig3.csv", &records)?;
    Ok(claims(&records))
}

/// Least number of samples that shows where a curve ends.
const MIN_SAMPLES_OF_AN_END: usize = 1 << 16;

/// Records of one curve.
fn curve<'a>(records: &'a [Record], case: &str, integrator: &str, rule: &str) -> Vec<&'a Record> {
    (records.iter())
        .filter(|r| r.case == case && r.integrator == integrator && r.rule == rule)
        .collect()
}

fn claims(records: &[Record]) -> Vec<Claim> {
    let mut claims = Vec::new();
    let last = |case: &str, integrator: &str, rule: &str| {
        curve(records, case, integrator, rule)
            .last()
            .map_or(f64::NAN, |r| r.defect())
    };
    let rk2: Vec<f64> = (CASES.iter())
        .map(|case| last(case.title, "RK2", case.rule_name()))
        .collect();
    claims.push(Claim {
        item: "fig3",
        origin: Origin::Paper,
        place: "section 4.3",
        says: "in all cases RK2 has a defect of order 1e-3".into(),
        measured: format!(
            "{:.1e} without interpolation, {:.1e}, {:.1e}, {:.1e} for degrees 1, 2, 3, at the most samples",
            rk2[0], rk2[1], rk2[2], rk2[3]
        ),
        judgement: Judgement::of(rk2.iter().all(|d| (1e-4..1e-2).contains(d))),
    });
    let linear = last("piecewise linear", "Strang", "finite-difference");
    claims.push(Claim {
        item: "fig3",
        origin: Origin::Paper,
        place: "section 4.3",
        says: "for degree 1 both integrators saturate about 1e-3".into(),
        measured: format!(
            "Strang {linear:.1e}, RK2 {:.1e} by finite differences",
            rk2[1]
        ),
        judgement: Judgement::of([linear, rk2[1]].iter().all(|d| (1e-4..1e-2).contains(d))),
    });
    claims.push(Claim::of_paper(
        "fig3",
        "caption of figure 3",
        "for degree 1 the loop integral saturates about 1e-6",
        format!("Strang {linear:.1e} by finite differences at the most samples"),
        Judgement::of((1e-7..1e-5).contains(&linear))
            .if_resolved(records.iter().any(|r| r.samples >= MIN_SAMPLES_OF_AN_END)),
    ));
    claims.push(samples_needed(records));
    for case in CASES.iter().filter(|case| case.degree >= 2) {
        let points: Vec<(f64, f64)> = (curve(records, case.title, "Strang", "pseudospectral")
            .iter())
        .map(|record| record.over_samples())
        .collect();
        let slope = power_law(&points);
        claims.push(Claim {
            item: "fig3",
            origin: Origin::Paper,
            place: "section 4.3",
            says: format!(
                "Strang, {}: converges with the samples roughly as N^-{}",
                case.title, case.degree
            ),
            measured: format!("{} by least squares, down to 1e-13", trend_text("N", slope)),
            judgement: slope.map_or(Judgement::Unresolved, |slope| {
                Judgement::of((slope + case.degree as f64).abs() < 0.5)
            }),
        });
    }
    claims
}

/// Judges how many samples smooth and rough loops need for round-off.
fn samples_needed(records: &[Record]) -> Claim {
    const MAX_ROUNDING_ERROR: f64 = 1e-13;
    let needed: Vec<Option<usize>> = (CASES.iter())
        .map(|case| {
            (curve(records, case.title, "Strang", case.rule_name()).iter())
                .find(|r| r.uncertainty() < MAX_ROUNDING_ERROR)
                .map(|r| r.samples)
        })
        .collect();
    let most = records.iter().map(|r| r.samples).max().unwrap_or(0);
    let text: Vec<String> = (CASES.iter().zip(&needed))
        .map(|(case, needed)| match needed {
            Some(samples) => format!("{}: {samples}", case.title),
            None => format!("{}: more than {most}", case.title),
        })
        .collect();
    let rough = [needed[1], needed[2], needed[3]];
    Claim::of_paper(
        "fig3",
        "section 4.5",
        "a modest number of samples resolves smooth Hamiltonians to machine precision, rough ones need many",
        format!(
            "quadrature error below 1e-13 from this number of samples on: {}",
            text.join("; ")
        ),
        Judgement::of(needed[0].is_some_and(|smooth| {
            smooth <= 1024 && rough.iter().all(|n| n.is_none_or(|n| n >= 8 * smooth))
        }))
        .if_resolved(needed[0].is_some() && most >= MIN_SAMPLES_OF_AN_END),
    )
}

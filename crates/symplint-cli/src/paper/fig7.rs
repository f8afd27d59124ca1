//! Figure 7: particle-in-cell against the step size.

use symplint_models::pic::ShapeFamily;

use super::Item;
use super::claim::{Claim, Judgement};
use super::pic::{
    DEGREES, LAMBDA, MOST_PARTICLES, PLASMAS, RK2, SEED, STRANG, Steps, plasma, rule, sweep_plasma,
};
use super::plot::reference_slope;
use super::sweep::{Record, halvings, last_slope, worst};
use crate::commands::Failure;
use crate::config::{Key, Section};
use crate::figure::{Figure, Panel};
use crate::output::{RunFolder, error_axis, step_axis};

pub const ITEM: Item = Item {
    id: "fig7",
    title: "particle-in-cell: defect against the step size",
    cost: "10 s",
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
    let particles = settings.whole_between("particles", 1, MOST_PARTICLES)? as usize;
    let samples = settings.whole("samples", 3)? as usize;
    let step_sizes = halvings(-1, -(settings.whole("halvings", 2)?.min(40) as i32));
    let seed = settings.whole("seed", 0)?;
    let steps = Steps::read(settings)?;
    let mut records: Vec<Record> = Vec::new();
    let mut panels = Vec::new();
    for (degree, degree_name) in DEGREES {
        for plasma_name in PLASMAS {
            let case = format!("{plasma_name}, {degree_name}");
            let plasma = plasma(
                plasma_name,
                particles,
                ShapeFamily::BSpline,
                degree,
                0,
                seed,
            )?;
            let swept = sweep_plasma(
                &case,
                &plasma,
                &steps,
                rule(degree, settings)?,
                |study| study.over_steps(samples, &step_sizes),
                Record::over_step,
            )?;
            let mut drawn = swept.curves;
            let rk2 = drawn[1].points.clone();
            drawn.push(reference_slope(
                &rk2,
                if degree == 1 { 2.0 } else { 4.0 },
                "h",
            ));
            drawn.push(swept.floor);
            panels.push(Panel {
                title: case,
                x: step_axis(),
                y: error_axis(),
                series: drawn,
                equal_aspect: false,
            });
            records.extend(swept.records);
        }
    }
    Figure {
        title: None,
        panels,
        columns: 2,
    }
    .save(&folder.figures(), "fig7")?;
    folder.write_csv("fig7.csv", &records)?;
    Ok(claims(&records))
}

fn claims(records: &[Record]) -> Vec<Claim> {
    let of = |integrator: &str, degree_name: &str| -> Vec<&Record> {
        (records.iter())
            .filter(|r| r.integrator == integrator && r.case.ends_with(degree_name))
            .collect()
    };
    let mut claims = Vec::new();
    for (degree_name, says, digits) in [
        ("quadratic", "about nine digits", 1e-8),
        (
            "cubic",
            "about 13 to 14 digits, two or three orders above machine precision",
            1e-12,
        ),
    ] {
        let strang = worst(of("Strang", degree_name).into_iter());
        claims.push(Claim {
            item: "fig7",
            place: "section 5.2",
            says: format!("{degree_name}: Strang conserves the loop integral to {says}"),
            measured: format!(
                "no defect above {strang:.1e} at any step size, largest at the largest steps"
            ),
            judgement: Judgement::with_correction(strang < digits, strang < 100.0 * digits),
        });
        for name in PLASMAS {
            let rk2: Vec<(f64, f64)> = (of("RK2", degree_name).iter())
                .filter(|r| r.case.starts_with(name))
                .map(|r| r.over_step())
                .collect();
            let slope = last_slope(&rk2, 100.0 * strang.max(1e-13)).unwrap_or(f64::NAN);
            claims.push(Claim {
                item: "fig7",
                place: "section 5.2",
                says: format!("{name}, {degree_name}: RK2 clearly follows a convergence trend"),
                measured: format!("h^{slope:.2} at the smallest steps above round-off"),
                judgement: Judgement::of((2.5..6.5).contains(&slope)),
            });
        }
    }
    let (strang, rk2) = (of("Strang", "linear"), of("RK2", "linear"));
    let (low, high) = (strang.iter().zip(&rk2))
        .filter(|(s, r)| s.step_size >= 0.01 && s.defect() > s.floor() && r.defect() > r.floor())
        .map(|(s, r)| s.defect() / r.defect())
        .fold((f64::INFINITY, 0.0f64), |(l, h), ratio| {
            (l.min(ratio), h.max(ratio))
        });
    claims.push(Claim {
        item: "fig7",
        place: "section 5.2",
        says: "linear: no discernible difference between Strang and RK2".into(),
        measured: format!(
            "defect of Strang over that of RK2 between {low:.2} and {high:.2} where both stand above the floor (h ≥ 0.01)"
        ),
        judgement: if high == 0.0 {
            Judgement::Unresolved
        } else {
            Judgement::of(low > 0.1 && high < 10.0)
        },
    });
    claims
}

//! Figure 6: particle-in-cell against the number of samples.

use symplint_models::pic::ShapeFamily;

use super::Item;
use super::claim::{Claim, Judgement};
use super::pic::{
    DEGREES, LAMBDA, MOST_PARTICLES, PLASMAS, RK2, SEED, STRANG, Steps, plasma, rule, sweep_plasma,
};
use super::plot::{axis, reference_slope};
use super::sweep::{Record, mean_rate};
use crate::commands::Failure;
use crate::config::{Accept, Key, Section};
use crate::figure::{Figure, Panel, Scale};
use crate::output::{RunFolder, error_axis};

pub const ITEM: Item = Item {
    id: "fig6",
    title: "particle-in-cell: defect against the number of samples",
    cost: "10 s",
    keys: &[
        Key::new("particles", "128", "number of particles"),
        Key::new("step_size", "0.1", "h"),
        Key::new("from", "\"2^6\"", "fewest samples"),
        Key::new("to", "\"2^15\"", "most samples"),
        LAMBDA,
        STRANG,
        RK2,
        SEED,
    ],
    run,
};

fn run(settings: &Section, folder: &RunFolder) -> Result<Vec<Claim>, Failure> {
    let particles = settings.whole_between("particles", 1, MOST_PARTICLES)? as usize;
    let h = settings.number("step_size", Accept::Positive)?;
    let (from, to) = (settings.whole("from", 3)?, settings.whole("to", 3)?);
    let seed = settings.whole("seed", 0)?;
    let counts: Vec<usize> = std::iter::successors(Some(from.min(to)), |n| Some(2 * n))
        .take_while(|&n| n <= to)
        .map(|n| n as usize)
        .collect();
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
                |study| study.over_samples(&counts, h),
                Record::over_samples,
            )?;
            let mut drawn = swept.curves;
            if degree > 1 {
                let strang = drawn[0].points.clone();
                drawn.push(reference_slope(&strang, -(degree as f64), "Nₛ"));
            }
            drawn.push(swept.floor);
            panels.push(Panel {
                title: case,
                x: axis("samples Nₛ", Scale::Log2),
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
    .save(&folder.figures(), "fig6")?;
    folder.write_csv("fig6.csv", &records)?;

    let curve = |case: &str, of: fn(&Record) -> f64| -> Vec<(f64, f64)> {
        (records.iter())
            .filter(|r| r.case == case && r.integrator == "Strang")
            .map(|r| (r.samples as f64, of(r)))
            .collect()
    };
    let mut claims = Vec::new();
    for (degree, degree_name) in DEGREES.into_iter().skip(1) {
        // Single defects scatter below their quadrature error, whose trend is the rate.
        let rates =
            PLASMAS.map(|name| mean_rate(&curve(&format!("{name}, {degree_name}"), Record::floor)));
        claims.push(Claim {
            item: "fig6",
            place: "section 5.2",
            says: format!("p = {degree}: Strang converges with the samples as N^-{degree}"),
            measured: format!(
                "its quadrature error goes as N^{:.2} (Landau) and N^{:.2} (two-stream), the defect below it",
                rates[0], rates[1]
            ),
            judgement: Judgement::of(rates.iter().all(|rate| (rate + degree as f64).abs() < 0.5)),
        });
    }
    let linear = || records.iter().filter(|r| r.case.ends_with("linear"));
    let cut = linear()
        .filter(|r| r.omitted_cells != Some(0))
        .map(|r| r.samples)
        .min();
    let whole = counts
        .iter()
        .copied()
        .filter(|&n| cut.is_none_or(|cut| n < cut))
        .max();
    let whole = whole.unwrap_or(0);
    // Signed, because the end-point error falls as 1/N on top of what the jumps leave.
    let signed: Vec<f64> = (linear())
        .filter(|r| {
            r.case.starts_with("two-stream") && r.integrator == "Strang" && r.samples <= whole
        })
        .map(|r| r.signed_defect)
        .collect();
    claims.push(match signed[..] {
        [.., before, last] => {
            let limit = 2.0 * last - before;
            Claim {
                item: "fig6",
                place: "section 5.2",
                says: "p = 1: no convergence is seen, because the quadrature error saturates for N_s > 1000".into(),
                measured: format!(
                    "two-stream: up to {whole} samples the cut-offs leave out no cell at all; the defect is {last:.1e} \
                     there and, extrapolated in 1/N, {limit:.1e}"
                ),
                judgement: Judgement::with_correction(
                    limit.abs() > 0.9 * last.abs(),
                    limit.abs() > 0.3 * last.abs(),
                ),
            }
        }
        _ => Claim {
            item: "fig6",
            place: "section 5.2",
            says: "p = 1: no convergence is seen, because the quadrature error saturates for N_s > 1000".into(),
            measured: "the cut-offs leave out cells at every number of samples".into(),
            judgement: Judgement::Unresolved,
        },
    });
    Ok(claims)
}

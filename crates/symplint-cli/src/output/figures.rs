//! Figures of `check` and `trace`.

use symplint::{Diagnosis, Ensemble, Point, Sweep, TraceRecord};

use super::plot::{axis, portrait, reference_slope, series};
use crate::config::Config;
use crate::figure::{Axis, Figure, Panel, Scale, Series, Style};

/// The axis of step sizes.
pub fn step_axis() -> Axis {
    axis("step size h", Scale::Log2)
}

/// The axis of relative defects.
pub fn error_axis() -> Axis {
    axis("relative loop defect |E|", Scale::Log10)
}

/// The figures of a diagnosis with their names, and a line on the one that was left out, if any was.
pub fn check_figures(
    config: &Config,
    diagnosis: &Diagnosis,
) -> (Vec<(&'static str, Figure)>, Option<String>) {
    let title = format!("{}, {}", config.system.name, config.integrator);
    let mut figures = vec![("step_sizes", step_sizes(&title, diagnosis))];
    if diagnosis
        .points
        .iter()
        .any(|point| point.sweep == Sweep::Samples)
    {
        figures.push(("samples", samples(&title, diagnosis)));
    }
    let note = match advanced_loop(&title, config) {
        Ok(figure) => {
            figures.push(("loop", figure));
            None
        }
        Err(reason) => Some(format!("figures/loop is left out: {reason}")),
    };
    (figures, note)
}

fn single(title: &str, x: Axis, y: Axis, series: Vec<Series>) -> Figure {
    Figure {
        title: None,
        panels: vec![Panel {
            title: title.into(),
            x,
            y,
            series,
            equal_aspect: false,
        }],
        columns: 1,
    }
}

/// Quadrature error and round-off: what lies below cannot be told from zero.
fn floor(points: &[&Point], x: impl Fn(&Point) -> f64) -> Series {
    let floor = points.iter().map(|point| {
        let quadrature = point.quadrature_error.unwrap_or(f64::NAN);
        (x(point), quadrature + point.roundoff)
    });
    series(
        "quadrature error + round-off",
        floor.collect(),
        Style::Floor,
        0,
    )
}

fn step_sizes(title: &str, diagnosis: &Diagnosis) -> Figure {
    let of_loop = |wanted: fn(usize) -> bool| -> Vec<&Point> {
        (diagnosis.points.iter())
            .filter(|point| point.sweep == Sweep::StepSize && wanted(point.loop_index))
            .collect()
    };
    let at = |point: &Point| (point.step_size, point.defect);
    let given = of_loop(|index| index == 0);
    let random = of_loop(|index| index > 0);
    let mut all = vec![
        floor(&given, |point| point.step_size),
        series(
            "given loop",
            given.iter().map(|point| at(point)).collect(),
            Style::LineAndPoints,
            0,
        ),
    ];
    if !random.is_empty() {
        let points = random.iter().map(|point| at(point)).collect();
        all.push(series("random loops", points, Style::Points, 1));
    }
    if let Some(order) = diagnosis.verdict.order {
        let points: Vec<(f64, f64)> = given.iter().map(|point| at(point)).collect();
        all.push(reference_slope(&points, order, "h"));
    }
    single(title, step_axis(), error_axis(), all)
}

fn samples(title: &str, diagnosis: &Diagnosis) -> Figure {
    let points: Vec<&Point> = (diagnosis.points.iter())
        .filter(|point| point.sweep == Sweep::Samples)
        .collect();
    let x = axis("samples Nₛ", Scale::Log2);
    let count = |point: &Point| point.samples as f64;
    let defects = points
        .iter()
        .map(|point| (count(point), point.defect))
        .collect();
    let all = vec![
        floor(&points, count),
        series("given loop", defects, Style::LineAndPoints, 0),
    ];
    single(title, x, error_axis(), all)
}

/// Positions and momenta of one degree of freedom.
fn plane(ensemble: &Ensemble, dof: usize) -> Vec<(f64, f64)> {
    /// More points than a figure can show only make files large.
    const MOST: usize = 4096;
    let (q, p) = (ensemble.q().row(dof), ensemble.p().row(dof));
    let every = q.len().div_ceil(MOST).max(1);
    q.iter()
        .copied()
        .zip(p.iter().copied())
        .step_by(every)
        .collect()
}

/// The loop before and after the largest step, in the plane of the first degree of freedom.
///
/// Drawn as points, because a line would hide that a loop is broken.
///
/// # Errors
/// Why it cannot be had, in words. The verdict does not need it, so that this is no failure of the run.
fn advanced_loop(title: &str, config: &Config) -> Result<Figure, String> {
    const SAMPLES: usize = 720;
    /// Of the states before the step. A run that streams its samples must not need more memory for a
    /// figure than for the verdict.
    const MOST_BYTES: usize = 512 << 20;
    let dof = config.map.dof();
    if dof > MOST_BYTES / (16 * SAMPLES) {
        return Err(format!(
            "{SAMPLES} states of {dof} degrees of freedom take more than 512 MiB"
        ));
    }
    let h = (config.diagnostic.step_sizes.iter().copied()).fold(0.0, f64::max);
    let advanced = || -> Result<(Ensemble, Ensemble), symplint::Error> {
        let before = Ensemble::sample(&*config.phase_loop, SAMPLES)?;
        let mut after = before.clone();
        after.advance(&*config.map, h)?;
        Ok((before, after))
    };
    let (before, after) =
        advanced().map_err(|error| format!("of its {SAMPLES} samples one fails; {error}"))?;
    Ok(two_loops(title, &before, &after, 0, Some(h)))
}

/// A loop before and after a step, in the plane of one degree of freedom.
fn two_loops(
    title: &str,
    before: &Ensemble,
    after: &Ensemble,
    dof: usize,
    h: Option<f64>,
) -> Figure {
    let label = h.map_or("after the step".into(), |h| {
        format!("after one step of {}", super::raised_power_of_two(h))
    });
    let coordinate = |name: &str| {
        let label = match before.dof() {
            1 => name.to_owned(),
            _ => format!("{name}{}", subscript(dof)),
        };
        axis(&label, Scale::Linear)
    };
    Figure {
        title: None,
        panels: vec![Panel {
            title: title.into(),
            x: coordinate("q"),
            y: coordinate("p"),
            series: vec![
                series("before", plane(before, dof), Style::Closed, 0),
                series(&label, plane(after, dof), Style::Points, 1),
            ],
            equal_aspect: true,
        }],
        columns: 1,
    }
}

/// The digits of a number as an index.
fn subscript(number: usize) -> String {
    let lower = |digit: char| match digit.to_digit(10) {
        Some(value) => char::from_u32(0x2080 + value).unwrap_or(digit),
        None => digit,
    };
    number.to_string().chars().map(lower).collect()
}

/// The figures of loops from files with their names: defects against step sizes where they are stated, and
/// the loop before and after the largest step, in the plane of the degree of freedom that jumps
/// first, if any does.
pub fn measure_figures(
    title: &str,
    diagnosis: &Diagnosis,
    before: &Ensemble,
    after: &Ensemble,
    h: Option<f64>,
) -> Vec<(&'static str, Figure)> {
    let mut figures = Vec::new();
    if diagnosis
        .points
        .iter()
        .any(|point| point.step_size.is_finite())
    {
        figures.push(("step_sizes", step_sizes(title, diagnosis)));
    }
    let dof = diagnosis.breaks.first().map_or(0, |at| at.found.dof);
    figures.push(("loop", two_loops(title, before, after, dof, h)));
    figures
}

/// The figures of a trace with their names.
pub fn trace_figures(config: &Config, record: &TraceRecord) -> Vec<(&'static str, Figure)> {
    let title = format!("{}, {}", config.system.name, config.integrator);
    let time = || axis("time t", Scale::Linear);
    let defects = record
        .points
        .iter()
        .map(|point| (point.time, point.defect))
        .collect();
    let floor = (record.points.iter())
        .map(|point| (point.time, point.quadrature_error.unwrap_or(f64::NAN)))
        .collect();
    let integral = vec![
        series("quadrature error", floor, Style::Floor, 0),
        series("loop integral", defects, Style::Line, 0),
    ];
    let energy = (record.points.iter())
        .map(|point| (point.time, point.energy_error.unwrap_or(f64::NAN)))
        .collect();
    let energy_axis = axis("relative energy error", Scale::Linear);
    let mut figures = vec![(
        "loop_integral",
        single(&title, time(), error_axis(), integral),
    )];
    if config.system.model.hamiltonian().is_some() {
        let energy = vec![series("", energy, Style::Line, 0)];
        figures.push(("energy", single(&title, time(), energy_axis, energy)));
    }
    if config.map.dof() == 1 && !record.snapshots.is_empty() {
        let loops: Vec<(String, Vec<(f64, f64)>)> = (record.snapshots.iter())
            .map(|(step, ensemble)| {
                let time = *step as f64 * config.trace.step_size;
                (format!("t = {time}"), plane(ensemble, 0))
            })
            .collect();
        let panel = match config.system.model.hamiltonian() {
            None => portrait(&title, &loops, None),
            Some(hamiltonian) => {
                let energy = |q: symplint::Rows<'_>, p: symplint::Rows<'_>, out: &mut [f64]| {
                    hamiltonian.energy(q, p, out);
                };
                portrait(&title, &loops, Some(&energy))
            }
        };
        figures.push((
            "loops",
            Figure {
                title: None,
                panels: vec![panel],
                columns: 1,
            },
        ));
    }
    figures
}

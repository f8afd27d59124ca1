//! The figures of a diagnosis, of a trace and of loops from files.

use symplint::evidence::{Evidence, LoopAtStep, LoopPicture, Point, Sector, Sweep};
use symplint::trace::{Observable, TraceRecord};
use symplint::{Diagnosis, Ensemble};

use crate::figure::{Axis, Figure, Panel, Scale, Series, Style};
use crate::number::raised_power_of_two;
use crate::plot::{
    axis, error_axis, portrait, reference_slope, series, step_axis, uncertainty,
    uncertainty_in_time,
};

/// The figures of a diagnosis with their names: defects against step sizes and numbers of samples, as far as there are any, and the loop
/// before and after the largest step, if the evidence has its picture.
pub fn figures(title: &str, diagnosis: &Diagnosis) -> Vec<(&'static str, Figure)> {
    let points = diagnosis.points();
    let mut figures = Vec::new();
    if points.iter().any(|point| point.step_size.is_finite()) {
        figures.push(("step_sizes", step_sizes(title, diagnosis)));
    }
    if points.iter().any(|point| point.sweep == Sweep::Samples) {
        figures.push(("samples", samples(title, diagnosis)));
    }
    figures.extend(many_steps(title, diagnosis).map(|figure| ("many_steps", figure)));
    if let Some(picture) = &diagnosis.picture {
        figures.push(("loop", loop_figure(title, &diagnosis.evidence, picture)));
    }
    figures
}

/// Colours of the given loop: of its defect, and of its defect with breaks closed.
const GIVEN_COLORS: [usize; 2] = [0, 2];
/// The same for random loops.
const RANDOM_COLORS: [usize; 2] = [1, 3];
/// The colour of the sector of a loop that changes most.
const SECTOR_COLOR: usize = 4;
/// The colour of breaks, and a marker that differs from other markers.
const BREAK_COLOR: usize = 3;

fn single(title: &str, x: Axis, y: Axis, series: Vec<Series>) -> Figure {
    Figure::new(
        vec![Panel {
            title: title.into(),
            x,
            y,
            series,
            equal_aspect: false,
        }],
        1,
    )
}

/// The uncertainty of some points; none where it is not known.
fn uncertainty_of(points: &[&Point], x: impl Fn(&Point) -> f64) -> Series {
    uncertainty(points.iter().map(|point| (x(point), uncertainty_at(point))))
}

/// Not a number if it is not known.
fn uncertainty_at(point: &Point) -> f64 {
    point.quadrature_error.unwrap_or(f64::NAN) + point.roundoff
}

/// The defects of some loops against step sizes. Those of a broken loop are of two integrals: of the pieces between
/// its breaks, and with the breaks closed, which alone distinguishes a symplectic map.
fn defects(name: &str, points: &[&Point], style: Style, colors: [usize; 2]) -> Vec<Series> {
    let curve = |of: fn(&Point) -> Option<f64>| -> Vec<(f64, f64)> {
        let at = |point: &&Point| Some((point.step_size, of(point)?));
        points.iter().filter_map(at).collect()
    };
    let all = curve(|point| Some(point.defect));
    // Between rounding errors, a line shows nothing.
    let exceeds = |point: &&Point| point.defect > uncertainty_at(point);
    let style = match points.iter().any(exceeds) {
        true => style,
        false => Style::Points,
    };
    let is_broken = |point: &&Point| point.jumps.is_some_and(|count| count > 0);
    if !points.iter().any(is_broken) {
        return vec![series(name, all, style, colors[0])];
    }
    let closed = curve(|point| point.closed_defect);
    let label = |part: &str| format!("{name}, {part}");
    vec![
        series(&label("between breaks"), all, style, colors[0]),
        series(&label("breaks closed"), closed, style, colors[1]),
    ]
}

/// The defects of all loops against step sizes, with their uncertainty and the order of the defect.
pub fn step_sizes(title: &str, diagnosis: &Diagnosis) -> Figure {
    let points = diagnosis.points();
    let of_loop = |wanted: fn(usize) -> bool| -> Vec<&Point> {
        (points.iter())
            .filter(|point| point.sweep == Sweep::StepSize && wanted(point.loop_index))
            .collect()
    };
    let (given, random) = (of_loop(|index| index == 0), of_loop(|index| index > 0));
    let mut all = Vec::new();
    let (style, colors) = (Style::LineAndPoints, GIVEN_COLORS);
    all.extend(defects("your loop", &given, style, colors));
    if !random.is_empty() {
        // Above the others, whose lines still show.
        let (style, colors) = (Style::Points, RANDOM_COLORS);
        all.extend(defects("random loops", &random, style, colors));
    }
    // If the verdict states no order, the given loop may still follow a power law.
    let fits = diagnosis.fits().iter();
    let of_given = (fits.filter(|fit| fit.loop_index == 0 && fit.against == "step_size"))
        .find_map(|fit| fit.whole());
    if let Some(order) = (diagnosis.verdict.order.or(of_given)).filter(|order| order.round() > 0.0)
    {
        let points: Vec<(f64, f64)> = (given.iter())
            .map(|point| (point.step_size, point.defect))
            .collect();
        all.push(reference_slope(&points, order, "h"));
    }
    let points: Vec<&Point> = given.iter().chain(&random).copied().collect();
    all.push(uncertainty_of(&points, |point| point.step_size));
    let found = diagnosis.verdict.headline();
    single(&found, step_axis(), error_axis(), all).with_title(title)
}

fn samples(title: &str, diagnosis: &Diagnosis) -> Figure {
    let all = diagnosis.points();
    let points: Vec<&Point> = (all.iter())
        .filter(|point| point.sweep == Sweep::Samples)
        .collect();
    let x = axis("samples Nₛ", Scale::Log2);
    let count = |point: &Point| point.samples as f64;
    let defects = points
        .iter()
        .map(|point| (count(point), point.defect))
        .collect();
    let all = vec![
        series("your loop", defects, Style::LineAndPoints, GIVEN_COLORS[0]),
        uncertainty_of(&points, count),
    ];
    single(title, x, error_axis(), all)
}

/// The defect of the given loop against the number of steps, if many steps were made.
fn many_steps(title: &str, diagnosis: &Diagnosis) -> Option<Figure> {
    let curve = &diagnosis.evidence.loop_at_steps;
    let steps = |of: &LoopAtStep| of.step as f64;
    if curve.len() < 2 {
        return None;
    }
    let defects = curve.iter().map(|of| (steps(of), of.defect.abs()));
    let errors = curve
        .iter()
        .map(|of| (steps(of), of.uncertainty.unwrap_or(f64::NAN)));
    let h = diagnosis.evidence.long_time.and_then(|of| of.step_size);
    let label = h.map_or("number of steps".into(), |h| {
        format!("number of steps, h = {}", raised_power_of_two(h))
    });
    let all = vec![
        series("your loop", defects.collect(), Style::Line, GIVEN_COLORS[0]),
        uncertainty(errors),
    ];
    Some(single(
        title,
        axis(&label, Scale::Linear),
        error_axis(),
        all,
    ))
}

/// Positions and momenta of one degree of freedom.
fn plane(ensemble: &Ensemble, dof: usize) -> Vec<(f64, f64)> {
    let (q, p) = (ensemble.q().row(dof), ensemble.p().row(dof));
    q.iter().copied().zip(p.iter().copied()).collect()
}

/// The loop before and after a step, in the plane of the degree of freedom that jumps first, or else of the first. Marks
/// show the places on the loop that the evidence names.
///
/// Drawn as points, because a line would hide that a loop is broken.
fn loop_figure(title: &str, evidence: &Evidence, picture: &LoopPicture) -> Figure {
    let dof = jumping_dof(evidence);
    let label = picture.step_size.map_or("after the step".into(), |h| {
        format!("after one step, h = {}", raised_power_of_two(h))
    });
    let coordinate = |name: &str| {
        let label = match picture.before.dof() {
            1 => name.to_owned(),
            _ => format!("{name}{}", subscript(dof)),
        };
        axis(&label, Scale::Linear)
    };
    let mut drawn = vec![
        series("before", plane(&picture.before, dof), Style::Closed, 0),
        series(&label, plane(&picture.after, dof), Style::Points, 1),
    ];
    drawn.extend(marks(evidence, picture, dof));
    Figure::new(
        vec![Panel {
            title: title.into(),
            x: coordinate("q"),
            y: coordinate("p"),
            series: drawn,
            equal_aspect: true,
        }],
        1,
    )
}

/// The degree of freedom of the first break of the given loop; 0 without breaks.
fn jumping_dof(evidence: &Evidence) -> usize {
    let mut breaks = evidence.breaks.iter();
    breaks
        .find(|at| at.loop_index == 0)
        .map_or(0, |at| at.found.dof)
}

/// A sector that makes this part of all changes is marked; the findings name it by the same limit. Conventional.
const LARGE_SHARE: f64 = 0.4;

/// The places on the given loop before the step that the evidence names: its breaks by this step, and the sector that
/// changes most if it stands out.
fn marks(evidence: &Evidence, picture: &LoopPicture, dof: usize) -> Vec<Series> {
    let points = plane(&picture.before, dof);
    let sample = |s: f64| (s * points.len() as f64).round() as usize % points.len();
    let breaks: Vec<(f64, f64)> = (evidence.breaks.iter())
        .filter(|at| at.loop_index == 0 && at.step_size == picture.step_size)
        .map(|at| points[sample(at.found.s)])
        .collect();
    let mut marks = Vec::new();
    let localisation = evidence.localisation.as_ref();
    if let Some(of) = localisation.filter(|of| of.loop_index == 0) {
        let size = |sector: &&Sector| sector.change.abs();
        let all: f64 = of.sectors.iter().map(|sector| size(&sector)).sum();
        let largest = (of.sectors.iter()).max_by(|a, b| size(a).total_cmp(&size(b)));
        if let Some(sector) = largest.filter(|of| size(of) >= LARGE_SHARE * all && all > 0.0) {
            let (from, to) = (sample(sector.from), sample(sector.to));
            // The last sector ends where the first one begins.
            let to = if to <= from { points.len() } else { to };
            let arc = (from..=to).map(|k| points[k % points.len()]).collect();
            let label = format!("largest change: s = {} to {}", sector.from, sector.to);
            marks.push(series(&label, arc, Style::Line, SECTOR_COLOR));
        }
    }
    if !breaks.is_empty() {
        marks.push(series("breaks", breaks, Style::Points, BREAK_COLOR));
    }
    marks
}

/// The digits of a number as an index.
fn subscript(number: usize) -> String {
    let lower = |digit: char| match digit.to_digit(10) {
        Some(value) => char::from_u32(0x2080 + value).unwrap_or(digit),
        None => digit,
    };
    number.to_string().chars().map(lower).collect()
}

/// The figures of a trace with their names. `energy` is that of the system, if it has one; `step_size` is the
/// size of its steps.
pub fn trace_figures(
    title: &str,
    record: &TraceRecord,
    step_size: f64,
    energy: Option<Observable<'_>>,
) -> Vec<(&'static str, Figure)> {
    let time = || axis("time t", Scale::Linear);
    let defects = record
        .points
        .iter()
        .map(|point| (point.time, point.defect))
        .collect();
    let uncertainty = uncertainty_in_time(&record.points);
    let exceeds = (record.points.iter().zip(&uncertainty.points))
        .any(|(point, allowed)| point.defect > allowed.1);
    // Between rounding errors, a line shows nothing.
    let style = if exceeds { Style::Line } else { Style::Points };
    let integral = vec![series("defect", defects, style, 0), uncertainty];
    let energy_errors = (record.points.iter())
        .map(|point| (point.time, point.energy_error.unwrap_or(f64::NAN)))
        .collect();
    let energy_axis = axis("relative energy error", Scale::Linear);
    let mut figures = vec![(
        "loop_integral",
        single(title, time(), error_axis(), integral),
    )];
    if energy.is_some() {
        let errors = vec![series("", energy_errors, Style::Line, 0)];
        figures.push(("energy", single(title, time(), energy_axis, errors)));
    }
    if record
        .snapshots
        .first()
        .is_some_and(|(_, ensemble)| ensemble.dof() == 1)
    {
        let loops: Vec<(String, Vec<(f64, f64)>)> = (record.snapshots.iter())
            .map(|(step, ensemble)| {
                let time = *step as f64 * step_size;
                (format!("t = {time}"), plane(ensemble, 0))
            })
            .collect();
        let panel = portrait(title, &loops, energy);
        figures.push(("loops", Figure::new(vec![panel], 1)));
    }
    figures
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use symplint::{Circle, Coordinates, Diagnostic, PerSample};

    use super::*;

    /// The defects of one series.
    fn defects_of<'a>(figure: &'a Figure, label: &str) -> impl Iterator<Item = f64> + 'a {
        let series = &figure.panels[0].series;
        let found = series.iter().find(|series| series.label == label);
        let found = found.unwrap_or_else(|| panic!("there is no {label}: {series:?}"));
        assert!(!found.points.is_empty());
        found.points.iter().map(|point| point.1)
    }

    #[test]
    fn a_broken_loop_is_drawn_with_its_breaks_open_and_closed() {
        // A kick by the force of |q|, and a drift: symplectic on both sides of its jump.
        let step = PerSample::new(1, |h, q, p| {
            p[0] -= h * q[0].signum();
            q[0] += h * p[0];
        });
        let circle = Circle::new(vec![0.1], vec![0.3], 1.0).unwrap();
        let diagnosis = Diagnostic::halving(-1, -4).run(&step, &circle).unwrap();
        let figure = step_sizes("|q|", &diagnosis);
        assert!(defects_of(&figure, "your loop, between breaks").all(|defect| defect > 1e-4));
        assert!(defects_of(&figure, "your loop, breaks closed").all(|defect| defect < 1e-12));
        assert!(defects_of(&figure, "random loops, breaks closed").all(|defect| defect < 1e-12));
        assert_eq!(figure.panels[0].title, diagnosis.verdict.headline());
    }

    fn drawn(title: &str, diagnosis: &Diagnosis) -> Figure {
        let picture = diagnosis.picture.as_ref();
        let picture = picture.expect("samples stay in memory");
        assert_eq!(picture.step_size, Some(0.5));
        loop_figure(title, &diagnosis.evidence, picture)
    }

    #[test]
    fn breaks_are_marked_on_the_loop_before_the_step() {
        let step = PerSample::new(1, |h, q, p| {
            p[0] -= h * q[0].signum();
            q[0] += h * p[0];
        });
        let circle = Circle::new(vec![0.1], vec![0.3], 1.0).unwrap();
        let diagnosis = Diagnostic::halving(-1, -3).run(&step, &circle).unwrap();
        let figure = drawn("|q|", &diagnosis);
        let series = &figure.panels[0].series;
        let breaks = series.iter().find(|series| series.label == "breaks");
        let breaks = &breaks.expect("breaks are marked").points;
        // The force jumps at q = 0, which is crossed twice.
        assert_eq!(breaks.len(), 2);
        assert!(
            breaks.iter().all(|point| point.0.abs() < 0.01),
            "{breaks:?}"
        );
    }

    #[test]
    fn a_loop_of_a_periodic_map_is_drawn_whole_and_near_the_loop_before() {
        let wrapped = PerSample::new(1, |h, q, p| {
            p[0] -= h * q[0].sin();
            q[0] = (q[0] + h * p[0]).rem_euclid(TAU);
        })
        .with_coordinates(Coordinates::plain(1).with_periods(vec![TAU]).unwrap())
        .unwrap();
        let circle = Circle::new(vec![0.0], vec![0.3], 1.0).unwrap();
        let diagnosis = Diagnostic::halving(-1, -3).run(&wrapped, &circle).unwrap();
        let figure = drawn("wrapped", &diagnosis);
        let [before, after] = [0, 1].map(|k| &figure.panels[0].series[k].points);
        let near = |a: &(f64, f64), b: &(f64, f64)| (a.0 - b.0).abs() < 1.0;
        assert!(after.windows(2).all(|pair| near(&pair[0], &pair[1])));
        assert!(before.iter().zip(after).all(|(a, b)| near(a, b)));
    }

    #[test]
    fn the_uncertainty_of_all_loops_is_drawn() {
        let step = PerSample::new(1, |h, q, p| {
            p[0] -= h * q[0].sin();
            q[0] += h * p[0];
        });
        let circle = Circle::new(vec![0.0], vec![0.3], 1.0).unwrap();
        let diagnosis = Diagnostic::halving(-1, -3).run(&step, &circle).unwrap();
        let drawn: Vec<f64> =
            defects_of(&step_sizes("pendulum", &diagnosis), "uncertainty").collect();
        let points = diagnosis.points();
        let largest = points.iter().map(uncertainty_at).fold(0.0, f64::max);
        assert!(drawn.contains(&largest), "{largest:e}: {drawn:?}");
    }

    #[test]
    fn the_sector_with_the_largest_change_is_marked() {
        // A leak where q > 0.8.
        let step = PerSample::new(1, |h, q, p| {
            p[0] -= h * q[0];
            p[0] *= 1.0 - 0.1 * h * (20.0 * (q[0] - 0.8)).tanh().mul_add(0.5, 0.5);
            q[0] += h * p[0];
        });
        let circle = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
        let diagnosis = Diagnostic::halving(-1, -3).run(&step, &circle).unwrap();
        let figure = drawn("leak", &diagnosis);
        let series = &figure.panels[0].series;
        let marked = (series.iter()).find(|series| series.label.starts_with("largest change"));
        let arc = &marked.expect("a sector stands out").points;
        assert!(arc.iter().all(|point| point.0 > 0.0), "{arc:?}");
    }

    #[test]
    fn many_steps_have_a_figure() {
        let damped = PerSample::new(1, |h: f64, q: &mut [f64], p: &mut [f64]| {
            p[0] = (p[0] - h * q[0]) * (-0.1 * h).exp();
            q[0] += h * p[0];
        });
        let circle = Circle::new(vec![1.0], vec![0.0], 0.5).unwrap();
        let diagnostic = Diagnostic {
            long_time: 1000,
            ..Diagnostic::halving(-1, -3)
        };
        let diagnosis = diagnostic.run(&damped, &circle).unwrap();
        let figure = many_steps("damped", &diagnosis).expect("many steps were made");
        let points = &figure.panels[0].series[0].points;
        assert_eq!(points.len(), 200);
        // Each step of 1/2 multiplies the area by exp(−0.05).
        for &(step, defect) in points {
            let expected = -(-0.05 * step).exp_m1();
            assert!(
                (defect - expected).abs() < 1e-9,
                "{step}: {defect} and {expected}"
            );
        }
        let names: Vec<&str> = figures("damped", &diagnosis)
            .iter()
            .map(|of| of.0)
            .collect();
        assert_eq!(names, ["step_sizes", "many_steps", "loop"]);
        let short = Diagnostic::halving(-1, -3).run(&damped, &circle).unwrap();
        assert!(many_steps("damped", &short).is_none());
    }

    #[test]
    fn a_whole_loop_has_one_defect() {
        let spring = PerSample::new(1, |h, q, p| {
            q[0] += h * p[0];
            p[0] -= h * q[0];
        });
        let circle = Circle::new(vec![1.0], vec![0.0], 0.5).unwrap();
        let diagnosis = Diagnostic::halving(-1, -3).run(&spring, &circle).unwrap();
        let figure = step_sizes("spring", &diagnosis);
        assert!(defects_of(&figure, "your loop").all(|defect| defect < 1e-13));
        let labels = figure.panels[0].series.iter().map(|series| &series.label);
        assert_eq!(labels.filter(|label| label.contains("closed")).count(), 0);
    }
}

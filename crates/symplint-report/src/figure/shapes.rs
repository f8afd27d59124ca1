//! The lines, markers, dots and zeros of series on the page.

use super::curve;
use super::geometry::{Point, Rect};
use super::range;
use super::scale::Ruler;
use super::style::STYLE;
use super::{Panel, Series, Style};

/// A series as it lies on the page.
#[derive(Debug, Default)]
pub(super) struct Shapes {
    pub lines: Vec<Vec<Point>>,
    pub markers: Vec<Point>,
    /// Points without a shape: of a large cloud, or left alone between two breaks of a line.
    pub dots: Vec<Point>,
    /// Tips of the triangles of zeros.
    pub zeros: Vec<Point>,
    /// Which of `STYLE.dashes` the series has, if it is dashed.
    pub dash: usize,
}

/// The visible shapes of each series.
///
/// `dashed` holds the labels of the dashed series so far: those of one name are dashed alike.
pub(super) fn shapes<'a>(
    panel: &'a Panel,
    frame: Rect,
    x: &Ruler,
    y: &Ruler,
    dashed: &mut Vec<&'a str>,
) -> Vec<Shapes> {
    let mut stacked = Vec::new();
    panel
        .series
        .iter()
        .map(|series| {
            let mut shapes = series_shapes(series, frame, x, y);
            let mut places: Vec<Point> = range::zeros(series, panel)
                .filter_map(|value| Some((x.place_value(value)?, frame.bottom)))
                .filter(|place| frame.grown(0.5).contains(*place))
                .collect();
            places.sort_by(|a, b| a.0.total_cmp(&b.0));
            shapes.zeros = stack(
                curve::spaced(&places, 2.0 * STYLE.marker_radius),
                &mut stacked,
            );
            if series.style == Style::Dashed {
                let known = dashed.iter().position(|label| *label == series.label);
                shapes.dash = known.unwrap_or(dashed.len()) % STYLE.dashes.len();
                if known.is_none() {
                    dashed.push(&series.label);
                }
            }
            shapes
        })
        .collect()
}

fn series_shapes(series: &Series, frame: Rect, x: &Ruler, y: &Ruler) -> Shapes {
    let mut runs = curve::runs(&series.points, x, y);
    let has_line = series.style != Style::Points;
    let mut shapes = Shapes::default();
    match series.style {
        Style::Points => {
            let cloud = curve::sparse_cloud(inside(&runs, frame), STYLE.max_dots);
            if cloud.len() > STYLE.max_markers {
                shapes.dots = cloud;
            } else {
                shapes.markers = cloud;
            }
        }
        Style::LineAndPoints => shapes.markers = along_line(inside(&runs, frame)),
        Style::Line | Style::Closed => {
            let alone: Vec<Vec<Point>> = runs.iter().filter(|r| r.len() == 1).cloned().collect();
            shapes.dots = curve::sparse_cloud(inside(&alone, frame), STYLE.max_dots);
        }
        Style::Dashed | Style::Uncertainty | Style::Thin => {}
    }
    if has_line {
        if series.style == Style::Closed {
            close(&mut runs, series.points.len());
        }
        if series.style == Style::Uncertainty {
            reach_frame(&mut runs, frame);
        }
        shapes.lines = runs
            .iter()
            .flat_map(|run| curve::visible(run, frame))
            .collect();
    }
    shapes
}

fn inside(runs: &[Vec<Point>], frame: Rect) -> Vec<Point> {
    let points = runs.iter().flatten().copied();
    points.filter(|p| frame.grown(0.5).contains(*p)).collect()
}

/// A few points all keep their markers, however close; many keep a distance.
fn along_line(points: Vec<Point>) -> Vec<Point> {
    if points.len() <= STYLE.max_line_markers {
        return points;
    }
    let spaced = curve::spaced(&points, STYLE.min_marker_distance);
    let stride = spaced.len().div_ceil(STYLE.max_line_markers).max(1);
    spaced.into_iter().step_by(stride).collect()
}

/// Joins the last point to the first. A curve broken by missing values is not closed across
/// the gap: its last run continues with the first.
fn close(runs: &mut [Vec<Point>], points: usize) {
    let unbroken = runs.len() == 1 && runs.first().is_some_and(|run| run.len() == points);
    if let (true, Some(run)) = (unbroken, runs.first_mut()) {
        run.extend(run.first().copied());
    }
}

/// Continues the uncertainty level to the frame across the free room next to the data.
fn reach_frame(runs: &mut [Vec<Point>], frame: Rect) {
    let reach = STYLE.max_band_gap * frame.width();
    for run in runs {
        let (Some(&first), Some(&last)) = (run.first(), run.last()) else {
            continue;
        };
        let (start, end) = if first.0 <= last.0 {
            (frame.left, frame.right)
        } else {
            (frame.right, frame.left)
        };
        // A single value has no other place to show its width.
        let is_single = run.len() == 1;
        if is_single || (first.0 - start).abs() < reach {
            run.insert(0, (start, first.1));
        }
        if is_single || (last.0 - end).abs() < reach {
            run.push((end, last.1));
        }
    }
}

/// Puts zeros of later series above those of earlier ones that they would cover.
fn stack(places: Vec<Point>, stacked: &mut Vec<Point>) -> Vec<Point> {
    let height = 2.0 * STYLE.marker_radius + 1.0;
    let placed: Vec<Point> = places
        .into_iter()
        .map(|mut place| {
            while stacked.iter().any(|other| {
                (other.0 - place.0).abs() < STYLE.marker_radius && (other.1 - place.1).abs() < 1.0
            }) {
                place.1 -= height;
            }
            place
        })
        .collect();
    stacked.extend(&placed);
    placed
}

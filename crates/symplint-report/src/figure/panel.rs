//! One panel: grid, series, frame, ticks and labels.

use super::curve;
use super::font::{CAPITAL, Typeface};
use super::geometry::{Point, Rect};
use super::layout::{
    AXIS_LABEL, EDGE, LABEL_GAP, LINE, PANEL_TITLE, PANEL_WIDTH, TICK_GAP, TICK_LABEL, TITLE_GAP,
};
use super::legend::Legend;
use super::palette::{BAND, BAND_SHADE, CONTOUR, FAINT_GRID, GRID, INK, color};
use super::scale::Ruler;
use super::scene::{Align, Scene, Text};
use super::ticks::Ticks;
use super::{Panel, Series, Style, marker, range};

/// Widths of data lines and of everything thinner.
pub(super) const THICK: f64 = 2.2;
pub(super) const THIN: f64 = 1.5;
/// Lengths of a dash and of the gap after it, for the first, second, … dashed series.
pub(super) const DASHES: [(f64, f64); 4] = [(7.0, 5.0), (2.5, 3.5), (14.0, 5.0), (4.5, 8.0)];
/// An uncertainty that ends this close to the frame, as a part of its width, is drawn up to it.
const BAND_REACH: f64 = 0.08;
/// More markers than this become dots.
const MOST_MARKERS: usize = 250;
pub(super) const DOT: f64 = 1.7;
/// More dots than this are thinned to a grid.
const MOST_DOTS: usize = 4000;
/// Most markers along a line, and their closest distance where there are more points.
const MOST_LINE_MARKERS: usize = 40;
const MARKER_DISTANCE: f64 = 16.0;
/// Lengths of ticks.
const MAJOR: f64 = 6.0;
const MINOR: f64 = 3.0;

/// A series as it lies on the page.
#[derive(Debug, Default)]
pub(super) struct Shapes {
    pub lines: Vec<Vec<Point>>,
    pub markers: Vec<Point>,
    /// Points without a shape: of a large cloud, or left alone between two breaks of a line.
    pub dots: Vec<Point>,
    /// Tips of the triangles of zeros.
    pub zeros: Vec<Point>,
    /// Which of [`DASHES`] the series has, if it is dashed.
    pub dash: usize,
}

/// A panel with its place on the page.
pub(super) struct Placed<'a> {
    pub panel: &'a Panel,
    /// The title, with the letter of the panel if it has one.
    pub title: &'a str,
    /// Left border of the panel.
    pub left: f64,
    pub frame: Rect,
    pub x: Ruler,
    pub y: Ruler,
    pub x_ticks: Ticks,
    pub y_ticks: Ticks,
    /// One for each series of the panel.
    pub shapes: Vec<Shapes>,
    pub legend: Legend,
    /// Where a legend below the panel starts.
    pub below: f64,
}

/// What of each series is visible in the frame.
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
            shapes.zeros = stack(curve::spaced(&places, 2.0 * marker::RADIUS), &mut stacked);
            if series.style == Style::Dashed {
                let known = dashed.iter().position(|label| *label == series.label);
                shapes.dash = known.unwrap_or(dashed.len()) % DASHES.len();
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
            let cloud = curve::sparse_cloud(inside(&runs, frame), MOST_DOTS);
            if cloud.len() > MOST_MARKERS {
                shapes.dots = cloud;
            } else {
                shapes.markers = cloud;
            }
        }
        Style::LineAndPoints => shapes.markers = along_line(inside(&runs, frame)),
        Style::Line | Style::Closed => {
            let alone: Vec<Vec<Point>> = runs.iter().filter(|r| r.len() == 1).cloned().collect();
            shapes.dots = curve::sparse_cloud(inside(&alone, frame), MOST_DOTS);
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
    if points.len() <= MOST_LINE_MARKERS {
        return points;
    }
    let spaced = curve::spaced(&points, MARKER_DISTANCE);
    let stride = spaced.len().div_ceil(MOST_LINE_MARKERS).max(1);
    spaced.into_iter().step_by(stride).collect()
}

/// Joins the last point to the first. A curve broken by missing values is not closed across
/// the gap: its last run goes on with the first.
fn close(runs: &mut [Vec<Point>], points: usize) {
    let unbroken = runs.len() == 1 && runs.first().is_some_and(|run| run.len() == points);
    if let (true, Some(run)) = (unbroken, runs.first_mut()) {
        run.extend(run.first().copied());
    }
}

/// Continues the uncertainty level to the frame across the free room beside the data.
fn reach_frame(runs: &mut [Vec<Point>], frame: Rect) {
    let reach = BAND_REACH * frame.width();
    for run in runs {
        let (Some(&first), Some(&last)) = (run.first(), run.last()) else {
            continue;
        };
        let (start, end) = if first.0 <= last.0 {
            (frame.left, frame.right)
        } else {
            (frame.right, frame.left)
        };
        if (first.0 - start).abs() < reach {
            run.insert(0, (start, first.1));
        }
        if (last.0 - end).abs() < reach {
            run.push((end, last.1));
        }
    }
}

/// Puts zeros of later series above those of earlier ones that they would cover.
fn stack(places: Vec<Point>, stacked: &mut Vec<Point>) -> Vec<Point> {
    let height = 2.0 * marker::RADIUS + 1.0;
    let placed: Vec<Point> = places
        .into_iter()
        .map(|mut place| {
            while stacked.iter().any(|other| {
                (other.0 - place.0).abs() < marker::RADIUS && (other.1 - place.1).abs() < 1.0
            }) {
                place.1 -= height;
            }
            place
        })
        .collect();
    stacked.extend(&placed);
    placed
}

impl Placed<'_> {
    /// Draws the panel, lowest layers first.
    pub fn draw(&self, scene: &mut Scene, face: &Typeface) {
        self.draw_each(scene, &[Style::Uncertainty], draw_shade);
        self.draw_grid(scene);
        self.draw_each(scene, &[Style::Thin], draw_lines);
        self.draw_each(scene, &[Style::Uncertainty, Style::Dashed], draw_lines);
        let data = [
            Style::Line,
            Style::Closed,
            Style::LineAndPoints,
            Style::Points,
        ];
        self.draw_each(scene, &data, draw_lines);
        self.draw_frame(scene);
        self.draw_each(scene, &data, draw_markers);
        self.legend.draw(scene, self.left, self.below);
        self.draw_tick_labels(scene);
        self.draw_titles(scene, face);
    }

    fn draw_each(
        &self,
        scene: &mut Scene,
        styles: &[Style],
        draw: fn(&mut Scene, &Series, &Shapes, Rect),
    ) {
        for (series, shapes) in self.panel.series.iter().zip(&self.shapes) {
            if styles.contains(&series.style) {
                draw(scene, series, shapes, self.frame);
            }
        }
    }

    /// The page places of the major and of the minor ticks of both axes.
    fn tick_places(&self) -> [(Vec<f64>, Vec<f64>); 2] {
        [(&self.x, &self.x_ticks), (&self.y, &self.y_ticks)].map(|(ruler, ticks)| {
            let major = ticks.major.iter().map(|tick| ruler.place(tick.at));
            let minor = ticks.minor.iter().map(|at| ruler.place(*at));
            (major.collect(), minor.collect())
        })
    }

    fn draw_grid(&self, scene: &mut Scene) {
        let frame = self.frame;
        let [x, y] = self.tick_places();
        // Minor lines of both axes first, so that they do not cut the major ones.
        for (x, y, color) in [(x.1, y.1, FAINT_GRID), (x.0, y.0, GRID)] {
            for x in x {
                scene.line(vec![(x, frame.top), (x, frame.bottom)], 1.0, color);
            }
            for y in y {
                scene.line(vec![(frame.left, y), (frame.right, y)], 1.0, color);
            }
        }
    }

    fn draw_frame(&self, scene: &mut Scene) {
        let frame = self.frame;
        let mut outline = frame.corners().to_vec();
        outline.extend([(frame.left, frame.top), (frame.right, frame.top)]);
        scene.line(outline, 1.2, INK);
        let [x, y] = self.tick_places();
        for (x, y, length) in [(x.0, y.0, MAJOR), (x.1, y.1, MINOR)] {
            for x in x {
                scene.line(
                    vec![(x, frame.bottom), (x, frame.bottom - length)],
                    1.2,
                    INK,
                );
            }
            for y in y {
                scene.line(vec![(frame.left, y), (frame.left + length, y)], 1.2, INK);
            }
        }
    }

    fn draw_tick_labels(&self, scene: &mut Scene) {
        let frame = self.frame;
        let label = |text: &str, at, align| Text {
            text: text.to_string(),
            at,
            align,
            size: TICK_LABEL,
            upwards: false,
            color: INK,
        };
        for tick in &self.x_ticks.major {
            let at = (
                self.x.place(tick.at),
                frame.bottom + TICK_GAP + 0.8 * TICK_LABEL,
            );
            scene.text(label(&tick.label, at, Align::Middle));
        }
        for tick in &self.y_ticks.major {
            let at = (
                frame.left - TICK_GAP,
                self.y.place(tick.at) + 0.5 * CAPITAL * TICK_LABEL,
            );
            scene.text(label(&tick.label, at, Align::End));
        }
    }

    fn draw_titles(&self, scene: &mut Scene, face: &Typeface) {
        let frame = self.frame;
        let centre = 0.5 * (frame.left + frame.right);
        let panel_centre = self.left + 0.5 * PANEL_WIDTH;
        let mut title = |text: &str, size, room, at: Point, upwards: bool| {
            let (text, size) = face.fit(text, size, room);
            // A title wider than the frame is centred on the panel, so that it stays on the page.
            let wide = !upwards && face.width(&text, size) > frame.width();
            scene.text(Text {
                text,
                at: (if wide { panel_centre } else { at.0 }, at.1),
                align: Align::Middle,
                size,
                upwards,
                color: INK,
            });
        };
        let room = PANEL_WIDTH - 2.0 * EDGE;
        let above = frame.top - TITLE_GAP - 0.25 * PANEL_TITLE;
        title(self.title, PANEL_TITLE, room, (centre, above), false);

        let ticks = frame.bottom + TICK_GAP + LINE * TICK_LABEL;
        let under = ticks + LABEL_GAP + 0.8 * AXIS_LABEL;
        title(
            &self.panel.x.label,
            AXIS_LABEL,
            room,
            (centre, under),
            false,
        );

        let widest = self
            .y_ticks
            .major
            .iter()
            .map(|tick| face.width(&tick.label, TICK_LABEL))
            .fold(0.0, f64::max);
        let beside = frame.left - TICK_GAP - widest - LABEL_GAP - 0.25 * AXIS_LABEL;
        let middle = 0.5 * (frame.top + frame.bottom);
        let room = frame.height();
        title(
            &self.panel.y.label,
            AXIS_LABEL,
            room,
            (beside, middle),
            true,
        );
    }
}

fn draw_shade(scene: &mut Scene, _: &Series, shapes: &Shapes, frame: Rect) {
    for line in &shapes.lines {
        let (Some(first), Some(last)) = (line.first(), line.last()) else {
            continue;
        };
        let mut area = line.clone();
        area.extend([(last.0, frame.bottom), (first.0, frame.bottom)]);
        scene.area(area, BAND_SHADE);
    }
}

fn draw_lines(scene: &mut Scene, series: &Series, shapes: &Shapes, _: Rect) {
    for line in &shapes.lines {
        match series.style {
            Style::Dashed => {
                for dash in curve::dashes(line, DASHES[shapes.dash]) {
                    scene.line(dash, THIN, color(series.color));
                }
            }
            Style::Uncertainty => scene.line(line.clone(), THIN, BAND),
            Style::Thin => scene.line(line.clone(), 1.0, CONTOUR),
            _ => scene.line(line.clone(), THICK, color(series.color)),
        }
    }
}

fn draw_markers(scene: &mut Scene, series: &Series, shapes: &Shapes, _: Rect) {
    let color = color(series.color);
    for centre in &shapes.dots {
        scene.disc(*centre, DOT, color);
    }
    for centre in &shapes.markers {
        marker::draw(scene, *centre, series.color, color);
    }
    for tip in &shapes.zeros {
        marker::draw_zero(scene, *tip, color);
    }
}

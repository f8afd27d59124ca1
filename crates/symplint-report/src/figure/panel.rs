//! One panel: grid, series, frame, ticks and labels.

use super::curve;
use super::font::{CAPITAL, Typeface};
use super::geometry::{Point, Rect};
use super::legend::Legend;
use super::palette::{BAND, BAND_SHADE, CONTOUR, FAINT_GRID, GRID, INK, color};
use super::scale::Ruler;
use super::scene::{Align, Scene, Text};
use super::shapes::Shapes;
use super::style::STYLE;
use super::ticks::Ticks;
use super::{Panel, Series, Style, marker};

/// A panel with its place on the page.
pub(super) struct PanelDrawing<'a> {
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
    /// The top of a legend below the panel.
    pub below: f64,
}

impl PanelDrawing<'_> {
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
        self.draw_markers(scene, &data);
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

    /// Draws the markers of all series. A marker that would hide others of the series before it is smaller, so that they are seen.
    fn draw_markers(&self, scene: &mut Scene, styles: &[Style]) {
        let mut drawn: Vec<Point> = Vec::new();
        for (series, shapes) in self.panel.series.iter().zip(&self.shapes) {
            if !styles.contains(&series.style) {
                continue;
            }
            let color = color(series.color);
            for centre in &shapes.dots {
                scene.disc(*centre, STYLE.dot_radius, color);
            }
            for centre in &shapes.markers {
                let apart = |other: &Point| (other.0 - centre.0).hypot(other.1 - centre.1);
                let hidden = (drawn.iter())
                    .filter(|other| apart(other) < STYLE.marker_radius)
                    .count();
                let size = 0.55f64.powi(hidden.min(2) as i32);
                marker::draw(
                    scene,
                    *centre,
                    series.color,
                    color,
                    size * STYLE.marker_radius,
                );
            }
            drawn.extend(&shapes.markers);
            for tip in &shapes.zeros {
                marker::draw_zero(scene, *tip, color);
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
        for (x, y, length) in [(x.0, y.0, STYLE.major_tick), (x.1, y.1, STYLE.minor_tick)] {
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
            size: STYLE.tick_label,
            upwards: false,
            color: INK,
        };
        for tick in &self.x_ticks.major {
            let at = (
                self.x.place(tick.at),
                frame.bottom + STYLE.tick_label_gap + 0.8 * STYLE.tick_label,
            );
            scene.text(label(&tick.label, at, Align::Middle));
        }
        for tick in &self.y_ticks.major {
            let at = (
                frame.left - STYLE.tick_label_gap,
                self.y.place(tick.at) + 0.5 * CAPITAL * STYLE.tick_label,
            );
            scene.text(label(&tick.label, at, Align::End));
        }
    }

    fn draw_titles(&self, scene: &mut Scene, face: &Typeface) {
        let frame = self.frame;
        let centre = 0.5 * (frame.left + frame.right);
        let panel_centre = self.left + 0.5 * STYLE.panel_width;
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
        let room = STYLE.panel_width - 2.0 * STYLE.edge;
        let above = frame.top - STYLE.title_gap - 0.25 * STYLE.title;
        title(self.title, STYLE.title, room, (centre, above), false);

        let ticks = frame.bottom + STYLE.tick_label_gap + STYLE.line_height * STYLE.tick_label;
        let under = ticks + STYLE.title_gap + 0.8 * STYLE.title;
        title(
            &self.panel.x.label,
            STYLE.title,
            room,
            (centre, under),
            false,
        );

        let widest = self
            .y_ticks
            .major
            .iter()
            .map(|tick| face.width(&tick.label, STYLE.tick_label))
            .fold(0.0, f64::max);
        let beside =
            frame.left - STYLE.tick_label_gap - widest - STYLE.title_gap - 0.25 * STYLE.title;
        let middle = 0.5 * (frame.top + frame.bottom);
        let room = frame.height();
        title(
            &self.panel.y.label,
            STYLE.title,
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
                for dash in curve::dashes(line, STYLE.dashes[shapes.dash]) {
                    scene.line(dash, STYLE.thin_line, color(series.color));
                }
            }
            Style::Uncertainty => scene.line(line.clone(), STYLE.thin_line, BAND),
            Style::Thin => scene.line(line.clone(), 1.0, CONTOUR),
            _ => scene.line(line.clone(), STYLE.thick_line, color(series.color)),
        }
    }
}

//! Legends that hide no data.
//!
//! The legend of a panel goes to the first place inside the frame that no line, marker or zero touches;
//! if the panel has no free place, into a strip below it. One legend for all panels is a strip below them.

use super::font::{CAPITAL, Typeface};
use super::geometry::{Point, Rect};
use super::marker;
use super::palette::{BAND, BAND_SHADE, CONTOUR, GRID, INK, WHITE, color};
use super::scene::{Align, Scene, Text};
use super::shapes::Shapes;
use super::style::STYLE;
use super::{Panel, Style, curve};

/// Width of a strip below a panel.
const ROOM: f64 = STYLE.panel_width - 2.0 * STYLE.edge;

/// What an entry's swatch shows.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Swatch {
    Series {
        style: Style,
        color: usize,
        dash: usize,
    },
    /// A cloud of dots of this colour.
    Dots(usize),
    Zero,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Entry {
    swatch: Swatch,
    text: String,
    size: f64,
    width: f64,
}

/// The entries of a panel and where they go.
#[derive(Debug)]
pub(super) enum Legend {
    Nothing,
    Inside { place: Rect, entries: Vec<Entry> },
    Below { strip: Strip },
}

/// Entries in columns, filled row by row.
#[derive(Debug)]
pub(super) struct Strip {
    entries: Vec<Entry>,
    /// Widths of the columns.
    widths: Vec<f64>,
}

impl Legend {
    /// Finds the place for the legend of a panel with the given frame.
    pub fn place(panel: &Panel, shapes: &[Shapes], frame: Rect, face: &Typeface) -> Legend {
        let entries = entries(panel, shapes, ROOM, face);
        if entries.is_empty() {
            return Legend::Nothing;
        }
        let width = entries.iter().map(|entry| entry.width).fold(0.0, f64::max)
            + 2.0 * STYLE.legend_padding;
        let height = STYLE.legend_row * entries.len() as f64 + 2.0 * STYLE.legend_padding;
        let free = places(frame, width, height)
            .into_iter()
            .find(|place| covered(*place, shapes) == 0);
        match free {
            Some(place) => Legend::Inside { place, entries },
            None => Legend::Below {
                strip: Strip::in_columns(entries, ROOM),
            },
        }
    }

    /// Height that the legend needs below the panel.
    pub fn height_below(&self) -> f64 {
        match self {
            Legend::Below { strip } => strip.height(),
            Legend::Nothing | Legend::Inside { .. } => 0.0,
        }
    }

    /// Draws the legend; a strip starts at `below`, in the middle of the panel from `left` on.
    pub fn draw(&self, scene: &mut Scene, left: f64, below: f64) {
        match self {
            Legend::Nothing => {}
            Legend::Inside { place, entries } => {
                scene.rect(*place, WHITE);
                let mut outline = place.corners().to_vec();
                outline.push((place.left, place.top));
                scene.line(outline, 1.0, GRID);
                for (k, entry) in entries.iter().enumerate() {
                    let middle =
                        place.top + STYLE.legend_padding + STYLE.legend_row * (k as f64 + 0.5);
                    draw_entry(scene, entry, (place.left + STYLE.legend_padding, middle));
                }
            }
            Legend::Below { strip } => strip.draw(scene, (left, left + STYLE.panel_width), below),
        }
    }
}

impl Strip {
    /// The entries of all panels, each once, in rows at most `room` wide.
    pub fn of<'a>(
        panels: impl Iterator<Item = (&'a Panel, &'a [Shapes])>,
        room: f64,
        face: &Typeface,
    ) -> Strip {
        let mut all: Vec<Entry> = Vec::new();
        for (panel, shapes) in panels {
            for entry in entries(panel, shapes, room, face) {
                if !all.contains(&entry) {
                    all.push(entry);
                }
            }
        }
        // What marks zeros comes last, wherever the first of them are.
        all.sort_by_key(|entry| entry.swatch == Swatch::Zero);
        Strip::in_columns(all, room)
    }

    /// Columns as even as they can be in as few rows as fit.
    fn in_columns(entries: Vec<Entry>, room: f64) -> Strip {
        let count = entries.len();
        for rows in 1..=count {
            let columns = count.div_ceil(rows);
            let widths: Vec<f64> = (0..columns)
                .map(|column| {
                    let entries = entries.iter().skip(column).step_by(columns);
                    entries.map(|entry| entry.width).fold(0.0, f64::max)
                })
                .collect();
            if rows == count || total(&widths) <= room {
                return Strip { entries, widths };
            }
        }
        Strip {
            entries,
            widths: Vec::new(),
        }
    }

    fn rows(&self) -> std::slice::Chunks<'_, Entry> {
        self.entries.chunks(self.widths.len().max(1))
    }

    /// Height on the page.
    pub fn height(&self) -> f64 {
        STYLE.legend_row * self.rows().len() as f64 + STYLE.legend_padding
    }

    /// Draws the strip from `top` on, in the middle between left and right.
    pub fn draw(&self, scene: &mut Scene, (left, right): (f64, f64), top: f64) {
        let start = left + 0.5 * (right - left - total(&self.widths));
        for (k, row) in self.rows().enumerate() {
            let mut left = start;
            for (entry, width) in row.iter().zip(&self.widths) {
                draw_entry(
                    scene,
                    entry,
                    (left, top + STYLE.legend_row * (k as f64 + 0.5)),
                );
                left += width + STYLE.legend_column_gap;
            }
        }
    }
}

/// The width of columns side by side.
fn total(widths: &[f64]) -> f64 {
    widths.iter().sum::<f64>() + STYLE.legend_column_gap * widths.len().saturating_sub(1) as f64
}

/// The entries of a panel, each at most `room` wide.
fn entries(panel: &Panel, shapes: &[Shapes], room: f64, face: &Typeface) -> Vec<Entry> {
    let room = room - STYLE.swatch_width - STYLE.swatch_gap;
    let entry = |swatch, label: &str| {
        let (text, size) = face.fit(label, STYLE.legend, room);
        let width = STYLE.swatch_width + STYLE.swatch_gap + face.width(&text, size);
        Entry {
            swatch,
            text,
            size,
            width,
        }
    };
    let mut entries: Vec<Entry> = panel
        .series
        .iter()
        .zip(shapes)
        .filter(|(series, _)| !series.label.is_empty() && series.style != Style::Thin)
        .map(|(series, shapes)| {
            let swatch = if series.style == Style::Points && !shapes.dots.is_empty() {
                Swatch::Dots(series.color)
            } else {
                Swatch::Series {
                    style: series.style,
                    color: series.color,
                    dash: shapes.dash,
                }
            };
            entry(swatch, &series.label)
        })
        .collect();
    if shapes.iter().any(|shapes| !shapes.zeros.is_empty()) {
        entries.push(entry(Swatch::Zero, "exactly 0"));
    }
    entries
}

/// The places inside the frame, best first; none if the box is too large.
fn places(frame: Rect, width: f64, height: f64) -> Vec<Rect> {
    let (left, right) = (
        frame.left + STYLE.legend_inset,
        frame.right - STYLE.legend_inset - width,
    );
    let (top, bottom) = (
        frame.top + STYLE.legend_inset,
        frame.bottom - STYLE.legend_inset - height,
    );
    if left > right || top > bottom {
        return Vec::new();
    }
    let (centre, middle) = (0.5 * (left + right), 0.5 * (top + bottom));
    [
        (right, top),
        (left, top),
        (right, bottom),
        (left, bottom),
        (right, middle),
        (left, middle),
        (centre, top),
        (centre, bottom),
    ]
    .map(|(x, y)| Rect {
        left: x.round(),
        top: y.round(),
        right: (x + width).round(),
        bottom: (y + height).round(),
    })
    .to_vec()
}

/// How many segments, markers and zeros the box would hide.
fn covered(place: Rect, shapes: &[Shapes]) -> usize {
    let place = place.grown(STYLE.legend_clearance);
    let marked = place.grown(STYLE.marker_radius);
    shapes
        .iter()
        .map(|shapes| {
            let segments = shapes
                .lines
                .iter()
                .flat_map(|line| line.windows(2))
                .filter(|pair| place.clip(pair[0], pair[1]).is_some());
            let markers = shapes
                .markers
                .iter()
                .chain(&shapes.dots)
                .chain(&shapes.zeros)
                .filter(|point| marked.contains(**point));
            segments.count() + markers.count()
        })
        .sum()
}

fn draw_entry(scene: &mut Scene, entry: &Entry, (left, middle): Point) {
    draw_swatch(scene, entry.swatch, (left, middle));
    scene.text(Text {
        text: entry.text.clone(),
        at: (
            left + STYLE.swatch_width + STYLE.swatch_gap,
            middle + 0.5 * CAPITAL * entry.size,
        ),
        align: Align::Start,
        size: entry.size,
        upwards: false,
        color: INK,
    });
}

fn draw_swatch(scene: &mut Scene, swatch: Swatch, (left, middle): Point) {
    let centre = (left + 0.5 * STYLE.swatch_width, middle);
    let line = vec![(left, middle), (left + STYLE.swatch_width, middle)];
    match swatch {
        Swatch::Dots(index) => {
            for (dx, dy) in [(-12.0, 2.0), (-4.0, -3.0), (3.0, 3.0), (11.0, -1.0)] {
                scene.disc(
                    (centre.0 + dx, centre.1 + dy),
                    1.4 * STYLE.dot_radius,
                    color(index),
                );
            }
        }
        Swatch::Zero => marker::draw_zero(scene, (centre.0, centre.1 + STYLE.marker_radius), INK),
        Swatch::Series {
            style,
            color: index,
            dash,
        } => match style {
            Style::Line | Style::Closed => scene.line(line, STYLE.thick_line, color(index)),
            Style::Points => marker::draw(scene, centre, index, color(index), STYLE.marker_radius),
            Style::LineAndPoints => {
                scene.line(line, STYLE.thick_line, color(index));
                marker::draw(scene, centre, index, color(index), STYLE.marker_radius);
            }
            Style::Dashed => {
                for dash in curve::dashes(&line, STYLE.dashes[dash]) {
                    scene.line(dash, STYLE.thin_line, color(index));
                }
            }
            Style::Uncertainty => {
                let shade = Rect {
                    left,
                    top: middle,
                    right: left + STYLE.swatch_width,
                    bottom: middle + 0.3 * STYLE.legend_row,
                };
                scene.rect(shade, BAND_SHADE);
                scene.line(line, STYLE.thin_line, BAND);
            }
            Style::Thin => scene.line(line, 1.0, CONTOUR),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{panel, series};
    use super::*;

    const FRAME: Rect = Rect {
        left: 100.0,
        top: 0.0,
        right: 600.0,
        bottom: 400.0,
    };

    fn place(lines: Vec<Vec<Point>>, label: &str) -> Legend {
        let face = Typeface::load().expect("the built-in font is readable");
        let panel = panel(vec![series(label, Vec::new(), Style::Line, 0)]);
        let shapes = vec![Shapes {
            lines,
            ..Shapes::default()
        }];
        Legend::place(&panel, &shapes, FRAME, &face)
    }

    #[test]
    fn the_legend_avoids_a_segment_without_points_in_the_corner() {
        // The line only passes through the upper right and the upper left corner.
        let Legend::Inside { place, .. } = place(vec![vec![(100.0, 20.0), (600.0, 20.0)]], "a")
        else {
            panic!("the lower corners are free");
        };
        assert!(place.right > 500.0 && place.bottom > 350.0);
    }

    #[test]
    fn a_full_panel_has_its_legend_below() {
        let lines = (0..40)
            .map(|k| vec![(100.0, 10.0 * f64::from(k)), (600.0, 10.0 * f64::from(k))])
            .collect();
        let legend = place(lines, "a");
        assert!(matches!(legend, Legend::Below { .. }));
        assert!(legend.height_below() > 0.0);
    }

    #[test]
    fn no_labels_no_legend_and_long_labels_fit_the_panel() {
        assert!(matches!(place(Vec::new(), ""), Legend::Nothing));
        let Legend::Below { strip } = place(vec![], &"very long ".repeat(20)) else {
            panic!("too wide for the frame");
        };
        assert!(total(&strip.widths) <= ROOM + 0.1);
    }

    #[test]
    fn a_strip_has_even_columns_in_as_few_rows_as_fit() {
        let entry = |width| Entry {
            swatch: Swatch::Zero,
            text: String::new(),
            size: STYLE.legend,
            width,
        };
        let strip = |widths: &[f64], room| {
            let strip = Strip::in_columns(widths.iter().map(|&w| entry(w)).collect(), room);
            (strip.rows().len(), strip.widths)
        };
        assert_eq!(strip(&[100.0, 60.0], 200.0), (1, vec![100.0, 60.0]));
        // Three of them would fit into the first row: 2 × 2 is more even.
        let four = [100.0, 60.0, 50.0, 90.0];
        assert_eq!(strip(&four, 270.0), (2, vec![100.0, 90.0]));
        assert_eq!(strip(&four, 10.0).0, 4);
        assert_eq!(strip(&[], 100.0).0, 0);
    }
}

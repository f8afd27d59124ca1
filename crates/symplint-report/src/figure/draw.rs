//! From a figure to a picture: the grid of panels.

use super::font::Typeface;
use super::geometry::Rect;
use super::layout::{Margins, Sizes, sizes};
use super::legend::{Legend, Strip};
use super::palette::{INK, WHITE};
use super::panel::PanelDrawing;
use super::scale::Ruler;
use super::scene::{Align, Scene, Text};
use super::shapes::shapes;
use super::style::STYLE;
use super::{Figure, Panel};

/// Lays the whole figure out and draws it.
pub(super) fn scene(figure: &Figure, face: &Typeface) -> Scene {
    let columns = figure.columns.clamp(1, figure.panels.len().max(1));
    let count = columns as f64;
    let width = count * STYLE.panel_width + (count - 1.0) * STYLE.column_gap;
    let title = figure.title.as_deref().unwrap_or_default();
    let mut top = if title.is_empty() {
        0.0
    } else {
        STYLE.edge + STYLE.line_height * STYLE.figure_title
    };
    let titles = titles(figure);
    let mut rows = Rows {
        figure,
        titles: &titles,
        face,
        dashed: Vec::new(),
    };
    let mut panels = Vec::new();
    for row in aligned(figure, &titles, columns, face).chunks(columns) {
        let (placed, height) = rows.place(panels.len(), row, top);
        top += height + STYLE.row_gap;
        panels.extend(placed);
    }
    let shared = figure.shared_legend.then(|| {
        let drawn = panels.iter().map(|drawn| (drawn.panel, &*drawn.shapes));
        let strip = Strip::of(drawn, width - 2.0 * STYLE.edge, face);
        (top, strip)
    });
    top += (shared.as_ref()).map_or(0.0, |(_, strip)| strip.height() + STYLE.row_gap);
    let height = (top - STYLE.row_gap).max(1.0).ceil();

    let mut scene = Scene {
        width,
        height,
        marks: Vec::new(),
    };
    let page = Rect {
        left: 0.0,
        top: 0.0,
        right: width,
        bottom: height,
    };
    scene.rect(page, WHITE);
    let (text, size) = face.fit(title, STYLE.figure_title, width - 2.0 * STYLE.edge);
    scene.text(Text {
        text,
        at: (0.5 * width, STYLE.edge + 0.8 * STYLE.figure_title),
        align: Align::Middle,
        size,
        upwards: false,
        color: INK,
    });
    for panel in panels {
        panel.draw(&mut scene, face);
    }
    if let Some((top, strip)) = shared {
        strip.draw(&mut scene, (0.0, width), top);
    }
    scene
}

/// The titles of the panels, lettered where there are several: `(a) linear`.
fn titles(figure: &Figure) -> Vec<String> {
    let several = figure.panels.len() > 1;
    let title = |(k, panel): (usize, &Panel)| match several {
        true => format!("({}) {}", letters(k), panel.title)
            .trim_end()
            .to_owned(),
        false => panel.title.clone(),
    };
    figure.panels.iter().enumerate().map(title).collect()
}

/// a, b, …, z, aa, ab, ….
fn letters(k: usize) -> String {
    let last = char::from(b'a' + (k % 26) as u8);
    match k / 26 {
        0 => last.to_string(),
        more => letters(more - 1) + &last.to_string(),
    }
}

/// The sizes of all panels, with the frames of a column below each other and those of a row of one height.
fn aligned(figure: &Figure, titles: &[String], columns: usize, face: &Typeface) -> Vec<Sizes> {
    let panels = || figure.panels.iter().zip(titles).enumerate();
    let alone: Vec<Sizes> = panels()
        .map(|(_, (panel, title))| sizes(panel, title, face, (0.0, 0.0), STYLE.plot_height))
        .collect();
    let widest = |column: usize| -> Margins {
        (alone.iter().zip(&figure.panels))
            .skip(column)
            .step_by(columns)
            // Frames narrowed by equal aspect stand in the middle of their panel.
            .filter(|(_, panel)| !panel.equal_aspect)
            .fold((0.0, 0.0), |(left, right), (sizes, _)| {
                (left.max(sizes.left), right.max(sizes.right))
            })
    };
    // Beside a phase portrait, other frames end where it ends.
    let height = |row: usize| -> f64 {
        (alone.iter().zip(&figure.panels))
            .skip(row * columns)
            .take(columns)
            .filter(|(_, panel)| panel.equal_aspect)
            .map(|(sizes, _)| sizes.height)
            .reduce(f64::max)
            .unwrap_or(STYLE.plot_height)
    };
    panels()
        .map(|(k, (panel, title))| {
            sizes(panel, title, face, widest(k % columns), height(k / columns))
        })
        .collect()
}

/// Places the panels row by row.
struct Rows<'a> {
    figure: &'a Figure,
    titles: &'a [String],
    face: &'a Typeface,
    /// Labels of dashed series that one legend names.
    dashed: Vec<&'a str>,
}

impl<'a> Rows<'a> {
    /// Places the next row, from panel `first` on, at `top`; also its height.
    fn place(&mut self, first: usize, row: &[Sizes], top: f64) -> (Vec<PanelDrawing<'a>>, f64) {
        let figure = self.figure;
        let above = row.iter().map(|sizes| sizes.top).fold(0.0, f64::max);
        let mut height = 0.0_f64;
        let mut placed = Vec::new();
        let panels = figure.panels.iter().zip(self.titles).skip(first);
        for (column, (sizes, (panel, title))) in row.iter().zip(panels).enumerate() {
            let left = column as f64 * (STYLE.panel_width + STYLE.column_gap);
            // Whole units make the frame and its ticks sharp.
            let (frame_left, frame_top) = ((left + sizes.left).round(), (top + above).round());
            let frame = Rect {
                left: frame_left,
                top: frame_top,
                right: frame_left + sizes.width.floor(),
                bottom: frame_top + sizes.height.floor(),
            };
            let x = Ruler {
                scale: panel.x.scale,
                span: sizes.x,
                start: frame.left,
                end: frame.right,
            };
            let y = Ruler {
                scale: panel.y.scale,
                span: sizes.y,
                start: frame.bottom,
                end: frame.top,
            };
            if !figure.shared_legend {
                self.dashed.clear();
            }
            let shapes = shapes(panel, frame, &x, &y, &mut self.dashed);
            let legend = if figure.shared_legend {
                Legend::Nothing
            } else {
                Legend::place(panel, &shapes, frame, self.face)
            };
            let below = frame.bottom + sizes.bottom;
            height = height.max(below + legend.height_below() - top);
            placed.push(PanelDrawing {
                panel,
                title,
                left,
                frame,
                x,
                y,
                x_ticks: sizes.x_ticks.clone(),
                y_ticks: sizes.y_ticks.clone(),
                shapes,
                legend,
                below,
            });
        }
        (placed, height)
    }
}

#[cfg(test)]
mod tests {
    use super::letters;

    #[test]
    fn letters_go_on_after_z() {
        assert_eq!([0, 25, 26, 52].map(letters), ["a", "z", "aa", "ba"]);
    }
}

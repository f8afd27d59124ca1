//! From a figure to a picture: the grid of panels.

use super::Figure;
use super::font::Typeface;
use super::geometry::Rect;
use super::layout::{EDGE, FIGURE_TITLE, LINE, PANEL_WIDTH, Sizes, sizes};
use super::legend::Legend;
use super::palette::{INK, WHITE};
use super::panel::{Placed, shapes};
use super::scale::Ruler;
use super::scene::{Align, Scene, Text};

/// Between panels.
const COLUMN_GAP: f64 = 18.0;
const ROW_GAP: f64 = 14.0;

/// Lays the whole figure out and draws it.
pub(super) fn scene(figure: &Figure, face: &Typeface) -> Scene {
    let columns = figure.columns.clamp(1, figure.panels.len().max(1));
    let count = columns as f64;
    let width = count * PANEL_WIDTH + (count - 1.0) * COLUMN_GAP;
    let title = figure.title.as_deref().unwrap_or_default();
    let mut top = if title.is_empty() {
        0.0
    } else {
        EDGE + LINE * FIGURE_TITLE
    };
    let mut panels = Vec::new();
    for row in aligned(figure, columns, face).chunks(columns) {
        let placed = place_row(figure, &panels, row, top, face);
        top += placed.1 + ROW_GAP;
        panels.extend(placed.0);
    }
    let height = (top - ROW_GAP).max(1.0).ceil();

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
    let (text, size) = face.fit(title, FIGURE_TITLE, width - 2.0 * EDGE);
    scene.text(Text {
        text,
        at: (0.5 * width, EDGE + 0.8 * FIGURE_TITLE),
        align: Align::Middle,
        size,
        upwards: false,
        color: INK,
    });
    for panel in panels {
        panel.draw(&mut scene, face);
    }
    scene
}

/// The sizes of all panels, with the frames of a column starting below each other.
fn aligned(figure: &Figure, columns: usize, face: &Typeface) -> Vec<Sizes> {
    let alone: Vec<Sizes> = figure
        .panels
        .iter()
        .map(|panel| sizes(panel, face, 0.0))
        .collect();
    let widest = |column: usize| {
        alone
            .iter()
            .zip(&figure.panels)
            .skip(column)
            .step_by(columns)
            // Frames narrowed by equal aspect stand in the middle of their panel.
            .filter(|(_, panel)| !panel.equal_aspect)
            .map(|(sizes, _)| sizes.left)
            .fold(0.0, f64::max)
    };
    figure
        .panels
        .iter()
        .enumerate()
        .map(|(k, panel)| sizes(panel, face, widest(k % columns)))
        .collect()
}

/// Places the next row of panels at `top`; also its height.
fn place_row<'a>(
    figure: &'a Figure,
    before: &[Placed],
    row: &[Sizes],
    top: f64,
    face: &Typeface,
) -> (Vec<Placed<'a>>, f64) {
    let above = row.iter().map(|sizes| sizes.top).fold(0.0, f64::max);
    let mut height = 0.0_f64;
    let mut placed = Vec::new();
    for (column, (sizes, panel)) in row.iter().zip(&figure.panels[before.len()..]).enumerate() {
        let left = column as f64 * (PANEL_WIDTH + COLUMN_GAP);
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
        let shapes = shapes(panel, frame, &x, &y);
        let legend = Legend::place(panel, &shapes, frame, face);
        let below = frame.bottom + sizes.bottom;
        height = height.max(below + legend.height_below() - top);
        placed.push(Placed {
            panel,
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

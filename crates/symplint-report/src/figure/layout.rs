//! How large the parts of a panel are.

use super::font::Typeface;
use super::range;
use super::scale::Span;
use super::ticks::{Room, Ticks, choose};
use super::{Axis, Panel};

/// Type sizes in page units.
pub(super) const FIGURE_TITLE: f64 = 23.0;
pub(super) const PANEL_TITLE: f64 = 20.0;
pub(super) const AXIS_LABEL: f64 = 20.0;
pub(super) const TICK_LABEL: f64 = 17.5;
pub(super) const LEGEND: f64 = 17.0;

/// Width of a panel with its labels.
pub(super) const PANEL_WIDTH: f64 = 650.0;
/// Height of the area inside the frame, unless equal aspect asks for another.
const PLOT_HEIGHT: f64 = 400.0;
/// Bounds of that height under equal aspect.
const PLOT_HEIGHTS: (f64, f64) = (150.0, 560.0);
/// From the frame to the tick labels.
pub(super) const TICK_GAP: f64 = 8.0;
/// From the tick labels to the axis label.
pub(super) const LABEL_GAP: f64 = 9.0;
/// From the frame to the title, clear of a tick label at the upper corner.
pub(super) const TITLE_GAP: f64 = 9.0;
/// Free border of a panel.
pub(super) const EDGE: f64 = 8.0;
/// Height of a line of text in em.
pub(super) const LINE: f64 = 1.2;

/// Sizes and ticks of a panel, before it has a place on the page.
#[derive(Debug)]
pub(super) struct Sizes {
    /// From the panel's border to the frame.
    pub left: f64,
    /// From the frame to the panel's border.
    pub right: f64,
    pub top: f64,
    /// From the frame to the panel's border, without a legend below the panel.
    pub bottom: f64,
    /// Inside of the frame.
    pub width: f64,
    pub height: f64,
    pub x: Span,
    pub y: Span,
    pub x_ticks: Ticks,
    pub y_ticks: Ticks,
}

/// Margins left and right of the frame of a panel.
pub(super) type Margins = (f64, f64);

/// The sizes of a panel whose margins are at least as wide as `least`.
pub(super) fn sizes(panel: &Panel, title: &str, face: &Typeface, least: Margins) -> Sizes {
    let spans = range::spans(panel);
    let (mut left, mut right) = (least.0, least.1.max(EDGE));
    // Labels decide the margins, margins the room for labels: the second round settles it, and
    // margins only grow, so a label of the last round always fits.
    let mut rounds = 0;
    loop {
        let room = PANEL_WIDTH - left - right;
        let (width, height, x, y) = frame(panel, spans, room);
        let y_ticks = choose(
            panel.y.scale,
            y,
            &Room {
                length: height,
                extent: |_: &str| 1.7 * TICK_LABEL,
            },
        );
        let x_ticks = choose(
            panel.x.scale,
            x,
            &Room {
                length: width,
                extent: |label: &str| face.width(label, TICK_LABEL) + 0.9 * TICK_LABEL,
            },
        );
        let widest = y_ticks
            .major
            .iter()
            .map(|tick| face.width(&tick.label, TICK_LABEL))
            .fold(0.0, f64::max);
        let needed_left = (EDGE + label_height(&panel.y) + widest + TICK_GAP).ceil();
        let needed_right = x_ticks
            .major
            .iter()
            .map(|tick| {
                let beyond = (tick.at - x.high) / x.length() * width;
                beyond + 0.5 * face.width(&tick.label, TICK_LABEL)
            })
            .fold(0.0, f64::max)
            .ceil()
            + EDGE;
        rounds += 1;
        if rounds == 4 || (needed_left <= left && needed_right <= right) {
            return Sizes {
                left: left + 0.5 * (room - width),
                right,
                top: top(title),
                bottom: TICK_GAP + LINE * TICK_LABEL + label_height(&panel.x) + EDGE,
                width,
                height,
                x,
                y,
                x_ticks,
                y_ticks,
            };
        }
        left = left.max(needed_left);
        right = right.max(needed_right);
    }
}

/// Inner size of the frame and the spans it shows.
fn frame(panel: &Panel, (x, y): (Span, Span), room: f64) -> (f64, f64, Span, Span) {
    if !panel.equal_aspect {
        return (room, PLOT_HEIGHT, x, y);
    }
    let (lowest, highest) = PLOT_HEIGHTS;
    let slope = y.length() / x.length();
    let height = (room * slope).clamp(lowest, highest).round();
    let width = (height / slope).clamp(lowest, room).round();
    // Very long or very high data: the shorter span grows until the units agree.
    let unit = (x.length() / width).max(y.length() / height);
    (
        width,
        height,
        x.with_length(unit * width),
        y.with_length(unit * height),
    )
}

fn top(title: &str) -> f64 {
    if title.is_empty() {
        EDGE + 0.5 * TICK_LABEL
    } else {
        EDGE + LINE * PANEL_TITLE + TITLE_GAP
    }
}

fn label_height(axis: &Axis) -> f64 {
    if axis.label.is_empty() {
        0.0
    } else {
        LABEL_GAP + LINE * AXIS_LABEL
    }
}

#[cfg(test)]
mod tests {
    use super::super::Style;
    use super::super::tests::{panel, series};
    use super::*;

    #[test]
    fn equal_aspect_draws_a_unit_of_x_as_long_as_one_of_y() {
        let face = Typeface::load().expect("the built-in font is readable");
        for (a, b) in [(1.0, 1.0), (3.0, 1.0), (1.0, 40.0), (100.0, 1.0)] {
            let mut panel = panel(vec![series(
                "orbit",
                vec![(-a, -b), (a, b)],
                Style::Closed,
                0,
            )]);
            panel.equal_aspect = true;
            let sizes = sizes(&panel, "", &face, (0.0, 0.0));
            let x_unit = sizes.width / sizes.x.length();
            let y_unit = sizes.height / sizes.y.length();
            assert!((x_unit / y_unit - 1.0).abs() < 1e-2, "{a} {b}");
            assert!(sizes.left + sizes.width <= PANEL_WIDTH);
            assert!(sizes.x.low <= -a && sizes.y.high >= b);
        }
    }
}

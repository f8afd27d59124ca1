//! How large the parts of a panel are.

use super::font::Typeface;
use super::range;
use super::scale::Span;
use super::style::STYLE;
use super::ticks::{Room, Ticks, choose};
use super::{Axis, Panel};

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

/// The sizes of a panel whose margins are at least as wide as `least`, and whose frame has this height, except for panels of equal
/// aspect.
pub(super) fn sizes(
    panel: &Panel,
    title: &str,
    face: &Typeface,
    least: Margins,
    plot_height: f64,
) -> Sizes {
    let spans = range::spans(panel);
    let (mut left, mut right) = (least.0, least.1.max(STYLE.edge));
    // Labels decide the margins, margins the room for labels: the second round settles it, and
    // margins only grow, so a label of the last round always fits.
    let mut rounds = 0;
    loop {
        let room = STYLE.panel_width - left - right;
        let (width, height, x, y) = frame(panel, spans, room, plot_height);
        let y_ticks = choose(
            panel.y.scale,
            y,
            &Room {
                length: height,
                extent: |_: &str| 1.7 * STYLE.tick_label,
            },
        );
        let x_ticks = choose(
            panel.x.scale,
            x,
            &Room {
                length: width,
                extent: |label: &str| face.width(label, STYLE.tick_label) + 0.9 * STYLE.tick_label,
            },
        );
        let widest = y_ticks
            .major
            .iter()
            .map(|tick| face.width(&tick.label, STYLE.tick_label))
            .fold(0.0, f64::max);
        let needed_left =
            (STYLE.edge + label_height(&panel.y) + widest + STYLE.tick_label_gap).ceil();
        let needed_right = x_ticks
            .major
            .iter()
            .map(|tick| {
                let beyond = (tick.at - x.high) / x.length() * width;
                beyond + 0.5 * face.width(&tick.label, STYLE.tick_label)
            })
            .fold(0.0, f64::max)
            .ceil()
            + STYLE.edge;
        rounds += 1;
        if rounds == 4 || (needed_left <= left && needed_right <= right) {
            return Sizes {
                left: left + 0.5 * (room - width),
                right,
                top: top(title),
                bottom: STYLE.tick_label_gap
                    + STYLE.line_height * STYLE.tick_label
                    + label_height(&panel.x)
                    + STYLE.edge,
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
fn frame(
    panel: &Panel,
    (x, y): (Span, Span),
    room: f64,
    plot_height: f64,
) -> (f64, f64, Span, Span) {
    if !panel.equal_aspect {
        return (room, plot_height, x, y);
    }
    let (lowest, highest) = STYLE.equal_aspect_heights;
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
        STYLE.edge + 0.5 * STYLE.tick_label
    } else {
        STYLE.edge + STYLE.line_height * STYLE.title + STYLE.title_gap
    }
}

fn label_height(axis: &Axis) -> f64 {
    if axis.label.is_empty() {
        0.0
    } else {
        STYLE.title_gap + STYLE.line_height * STYLE.title
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
            let sizes = sizes(&panel, "", &face, (0.0, 0.0), STYLE.plot_height);
            let x_unit = sizes.width / sizes.x.length();
            let y_unit = sizes.height / sizes.y.length();
            assert!((x_unit / y_unit - 1.0).abs() < 1e-2, "{a} {b}");
            assert!(sizes.left + sizes.width <= STYLE.panel_width);
            assert!(sizes.x.low <= -a && sizes.y.high >= b);
        }
    }
}

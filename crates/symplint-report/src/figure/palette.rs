//! Colours that colour-blind readers can tell apart.
//!
//! M. Okabe and K. Ito, "Color Universal Design" (2008). Their yellow is too pale for lines on
//! white and is left out.

/// Red, green, blue.
pub(super) type Color = (u8, u8, u8);

pub(super) const WHITE: Color = (255, 255, 255);
/// Frame and text.
pub(super) const INK: Color = (34, 34, 34);
/// Lines through labelled ticks.
pub(super) const GRID: Color = (226, 226, 226);
/// Lines through unlabelled ticks.
pub(super) const FAINT_GRID: Color = (241, 241, 241);
/// Background contours.
pub(super) const CONTOUR: Color = (196, 196, 196);
/// The upper edge of the uncertainty.
pub(super) const BAND: Color = (128, 128, 128);
/// The area below it.
pub(super) const BAND_SHADE: Color = (240, 240, 240);

const SERIES: [Color; 7] = [
    (0, 114, 178),   // blue
    (213, 94, 0),    // vermilion
    (0, 158, 115),   // bluish green
    (204, 121, 167), // reddish purple
    (230, 159, 0),   // orange
    (86, 180, 233),  // sky blue
    (0, 0, 0),       // black
];

/// The colour of a series index.
pub(super) fn color(index: usize) -> Color {
    SERIES[index % SERIES.len()]
}

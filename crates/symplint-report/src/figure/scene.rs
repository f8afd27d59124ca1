//! A picture as a list of marks, before anybody decides on a file format.
//!
//! One page unit is one pixel of an SVG shown at its natural size. A single panel is about 650
//! units wide; printed 3.5 inches wide, 18 units of type size are 7 points.

use super::geometry::{Point, Rect};
use super::palette::Color;

/// Everything a painter draws, first marks lowest. All marks are opaque.
#[derive(Debug)]
pub(super) struct Scene {
    pub width: f64,
    pub height: f64,
    pub marks: Vec<Mark>,
}

/// One thing on the page.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Mark {
    /// A line with round joins.
    Line {
        points: Vec<Point>,
        width: f64,
        color: Color,
    },
    /// A filled polygon.
    Area { points: Vec<Point>, color: Color },
    /// A filled circle.
    Disc {
        centre: Point,
        radius: f64,
        color: Color,
    },
    /// A line of text.
    Text(Text),
}

/// A line of text.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Text {
    pub text: String,
    /// Where on the baseline the text starts, has its middle or ends.
    pub at: Point,
    pub align: Align,
    /// Em size in page units.
    pub size: f64,
    /// Whether the text runs upwards.
    pub upwards: bool,
    pub color: Color,
}

/// Which part of a text lies at its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Align {
    Start,
    Middle,
    End,
}

impl Scene {
    pub fn line(&mut self, points: Vec<Point>, width: f64, color: Color) {
        if points.len() > 1 {
            self.marks.push(Mark::Line {
                points,
                width,
                color,
            });
        }
    }

    pub fn area(&mut self, points: Vec<Point>, color: Color) {
        if points.len() > 2 {
            self.marks.push(Mark::Area { points, color });
        }
    }

    pub fn rect(&mut self, rect: Rect, color: Color) {
        self.area(rect.corners().to_vec(), color);
    }

    pub fn disc(&mut self, centre: Point, radius: f64, color: Color) {
        self.marks.push(Mark::Disc {
            centre,
            radius,
            color,
        });
    }

    pub fn text(&mut self, text: Text) {
        if !text.text.is_empty() {
            self.marks.push(Mark::Text(text));
        }
    }
}

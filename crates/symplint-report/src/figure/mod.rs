//! Figures of a numerics paper, each written as SVG, PDF and PNG from one description.
//!
//! A [`Figure`] is data: panels with axes and series. [`Figure::save`] decides ranges, ticks and
//! the place of the legends, lays everything out as a list of marks (`scene`), and three
//! painters (`svg`, `pdf`, `png`) turn the same marks into files.
//!
//! ```text
//! Figure ──range, ticks, legend──▶ Layout ──▶ Scene (marks in units) ──▶ name.svg
//!                                                                    ├──▶ name.pdf
//!                                                                    └──▶ name.png
//! ```
//!
//! Logarithmic axes show what logarithms can show: negative and non-finite values are left out,
//! lines break there, and values of exactly zero appear as hollow triangles on the bottom edge,
//! named in the legend.

mod curve;
mod draw;
mod error;
mod font;
mod geometry;
mod layout;
mod legend;
mod marker;
mod number;
mod palette;
mod panel;
mod pdf;
mod png;
mod range;
mod save;
mod scale;
mod scene;
mod shapes;
mod style;
mod svg;
mod ticks;
mod truetype;

#[cfg(test)]
mod tests;

pub use error::FigureError;
pub use number::superscript;

/// A figure: panels in a grid, filled row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Text above all panels.
    pub title: Option<String>,
    /// The panels, in reading order. Several are lettered: (a), (b), ….
    pub panels: Vec<Panel>,
    /// Panels side by side in one row; 0 counts as 1.
    pub columns: usize,
    /// Whether one legend below all panels names the series of all of them, each once.
    pub shared_legend: bool,
}

impl Figure {
    /// A figure of some panels, `columns` side by side, with a legend in each.
    pub fn new(panels: Vec<Panel>, columns: usize) -> Self {
        Figure {
            title: None,
            panels,
            columns,
            shared_legend: false,
        }
    }

    /// The same with a title above all panels.
    pub fn with_title(self, title: impl Into<String>) -> Self {
        let title = Some(title.into());
        Figure { title, ..self }
    }

    /// The same without titles, for a page that names the run itself.
    pub fn without_titles(mut self) -> Self {
        self.title = None;
        for panel in &mut self.panels {
            panel.title.clear();
        }
        self
    }

    /// The same with one legend for all panels.
    pub fn with_shared_legend(self) -> Self {
        Figure {
            shared_legend: true,
            ..self
        }
    }
}

/// One pair of axes with its series.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Text above the panel; empty for none.
    pub title: String,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The curves. Later series lie above earlier ones of the same style.
    pub series: Vec<Series>,
    /// Whether one unit of x is drawn as long as one unit of y, as a phase portrait needs.
    pub equal_aspect: bool,
}

/// One axis of a panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// The quantity and its unit, such as `step size h`.
    pub label: String,
    /// How values become lengths.
    pub scale: Scale,
    /// The values at the two ends; `None`, or a range the scale cannot show, for a range
    /// around the data. Reference slopes ([`Style::Dashed`]) do not widen an automatic y range.
    pub range: Option<(f64, f64)>,
}

/// How values become lengths along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences are equally long.
    Linear,
    /// Equal ratios are equally long; ticks at powers of ten.
    Log10,
    /// Equal ratios are equally long; ticks at powers of two.
    Log2,
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// A line through the points.
    Line,
    /// A marker at every point; small dots where there are hundreds.
    Points,
    /// Both; where points crowd, only some carry a marker.
    LineAndPoints,
    /// A thin dashed line, for reference slopes.
    Dashed,
    /// A thin grey line, shaded down to the axis: what lies there cannot be told from zero.
    Uncertainty,
    /// A line from the last point back to the first as well.
    Closed,
    /// A light grey background line without legend entry, such as an energy contour.
    Thin,
}

/// One curve or point cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// The legend entry; empty for none.
    pub label: String,
    /// The points (x, y) in the order the line visits them.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub style: Style,
    /// Index of the colour and of the marker shape; both repeat, with different periods.
    pub color: usize,
}

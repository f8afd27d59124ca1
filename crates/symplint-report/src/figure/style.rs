//! The look of all figures: sizes and limits, in page units unless another unit is named.
//!
//! All are conventions, checked by eye at the size of one column of a journal (3.5 inches for one panel).

/// Sizes and limits of figures.
pub(super) struct FigureStyle {
    /// Type size of the title above all panels.
    pub figure_title: f64,
    /// Type size of titles of panels and of labels of axes.
    pub title: f64,
    /// Type size of labels of ticks.
    pub tick_label: f64,
    /// Type size of entries of legends.
    pub legend: f64,
    /// Height of a line of text in em.
    pub line_height: f64,

    /// Width of a panel with its labels.
    pub panel_width: f64,
    /// Height inside the frame, except for panels of equal aspect.
    pub plot_height: f64,
    /// Bounds of that height for panels of equal aspect.
    pub equal_aspect_heights: (f64, f64),
    /// Distance between columns of panels.
    pub column_gap: f64,
    /// Distance between rows of panels.
    pub row_gap: f64,
    /// Free border of a panel.
    pub edge: f64,
    /// Distance from the frame to labels of ticks.
    pub tick_label_gap: f64,
    /// Distance from labels of ticks to the label of the axis, and from the frame to the title.
    pub title_gap: f64,
    /// Length of a labelled tick.
    pub major_tick: f64,
    /// Length of another tick.
    pub minor_tick: f64,
    /// Least distance of unlabelled ticks.
    pub min_tick_distance: f64,
    /// Most labels of an axis.
    pub max_tick_labels: usize,

    /// Width of data lines and of the strokes of crosses.
    pub thick_line: f64,
    /// Width of reference slopes and of uncertainties.
    pub thin_line: f64,
    /// Lengths of a dash and of the gap after it, for the first, second, … dashed series.
    pub dashes: [(f64, f64); 4],
    /// Half the size of a marker.
    pub marker_radius: f64,
    /// Width of the white rim that lifts a marker off lines below it.
    pub marker_rim: f64,
    /// Least distance of markers along a line of many points.
    pub min_marker_distance: f64,
    /// Most markers along a line.
    pub max_line_markers: usize,
    /// Most points of a cloud that are drawn as markers; more become dots.
    pub max_markers: usize,
    /// Most dots of a cloud; more are thinned to a grid.
    pub max_dots: usize,
    /// Radius of a dot.
    pub dot_radius: f64,
    /// Largest distance from the frame over which an uncertainty is continued to it, as a part of the width of the frame.
    pub max_band_gap: f64,

    /// Height of a row of a legend.
    pub legend_row: f64,
    /// Distance between columns of a legend.
    pub legend_column_gap: f64,
    /// Width of the line or marker before the text of an entry.
    pub swatch_width: f64,
    /// Distance from there to the text.
    pub swatch_gap: f64,
    /// Free border inside the box of a legend.
    pub legend_padding: f64,
    /// Distance from the box of a legend to the frame.
    pub legend_inset: f64,
    /// Least distance from the box of a legend to data.
    pub legend_clearance: f64,
}

/// The style of every figure.
pub(super) const STYLE: FigureStyle = FigureStyle {
    figure_title: 23.0,
    title: 20.0,
    tick_label: 17.5,
    legend: 17.0,
    line_height: 1.2,

    panel_width: 650.0,
    plot_height: 400.0,
    equal_aspect_heights: (150.0, 560.0),
    column_gap: 18.0,
    row_gap: 14.0,
    edge: 8.0,
    tick_label_gap: 8.0,
    title_gap: 9.0,
    major_tick: 6.0,
    minor_tick: 3.0,
    min_tick_distance: 5.0,
    max_tick_labels: 10,

    thick_line: 2.2,
    thin_line: 1.5,
    dashes: [(7.0, 5.0), (2.5, 3.5), (14.0, 5.0), (4.5, 8.0)],
    marker_radius: 5.0,
    marker_rim: 1.2,
    min_marker_distance: 16.0,
    max_line_markers: 40,
    max_markers: 250,
    max_dots: 4000,
    dot_radius: 1.7,
    max_band_gap: 0.08,

    legend_row: 24.0,
    legend_column_gap: 24.0,
    swatch_width: 36.0,
    swatch_gap: 8.0,
    legend_padding: 7.0,
    legend_inset: 9.0,
    legend_clearance: 6.0,
};

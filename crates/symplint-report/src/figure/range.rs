//! Automatic axis ranges.

use super::scale::Span;
use super::{Axis, Panel, Scale, Series, Style};

/// Free room next to markers and lines, as a part of the range.
const PADDING: f64 = 0.04;
/// Least number of decades of a range that ends at whole decades.
const MIN_WHOLE_DECADES: f64 = 6.0;
/// Least length of a range, relative to its values; shorter ranges are one value.
const MIN_RELATIVE_LENGTH: f64 = 1e-12;
/// Bottom of a panel whose zeros belong to round-off, as a power of ten: just below the
/// smallest relative difference of two numbers near 1.
const ROUND_OFF_FLOOR: f64 = -17.0;

/// The ranges of both axes.
pub(super) fn spans(panel: &Panel) -> (Span, Span) {
    (x_span(panel), y_span(panel))
}

/// The values of exactly zero that a logarithmic y axis cannot show, as places on the x axis.
pub(super) fn zeros<'a>(series: &'a Series, panel: &'a Panel) -> impl Iterator<Item = f64> + 'a {
    let shown = panel.y.scale.is_log()
        && !matches!(
            series.style,
            Style::Dashed | Style::Uncertainty | Style::Thin
        );
    series
        .points
        .iter()
        .filter(move |(x, y)| shown && *y == 0.0 && panel.x.scale.map(*x).is_some())
        .map(|point| point.0)
}

fn x_span(panel: &Panel) -> Span {
    let mut all = Extent::default();
    let mut roomy = Extent::default();
    for series in &panel.series {
        let values = series
            .points
            .iter()
            .filter(|point| panel.y.scale.map(point.1).is_some())
            .map(|point| point.0)
            .chain(zeros(series, panel))
            .filter_map(|x| panel.x.scale.map(x));
        let needs_room = matches!(
            series.style,
            Style::Points | Style::LineAndPoints | Style::Closed
        );
        for value in values {
            all.add(value);
            if needs_room {
                roomy.add(value);
            }
        }
    }
    explicit(&panel.x).unwrap_or_else(|| automatic(panel.x.scale, all, roomy))
}

fn y_span(panel: &Panel) -> Span {
    if let Some(span) = explicit(&panel.y) {
        return span;
    }
    let scale = panel.y.scale;
    let mut all = Extent::default();
    let mut roomy = Extent::default();
    let mut references = Extent::default();
    let (mut shown, mut zero) = (0_usize, 0_usize);
    for series in &panel.series {
        zero += zeros(series, panel).count();
        for &(x, y) in &series.points {
            let (Some(_), Some(value)) = (panel.x.scale.map(x), scale.map(y)) else {
                continue;
            };
            if series.style == Style::Dashed {
                references.add(value);
                continue;
            }
            shown += 1;
            all.add(value);
            if series.style != Style::Thin {
                roomy.add(value);
            }
        }
    }
    if shown == 0 && zero == 0 {
        (all, roomy) = (references, references);
    }
    if zero > 0 {
        return with_zeros(scale, all, 10 * zero >= shown);
    }
    automatic(scale, all, roomy)
}

/// The smallest and the largest of some mapped values.
#[derive(Debug, Clone, Copy, Default)]
struct Extent(Option<(f64, f64)>);

impl Extent {
    fn add(&mut self, value: f64) {
        self.0 = Some(match self.0 {
            Some((low, high)) => (low.min(value), high.max(value)),
            None => (value, value),
        });
    }
}

/// The range the caller asked for, if the scale can show it.
fn explicit(axis: &Axis) -> Option<Span> {
    let (a, b) = axis.range?;
    let (a, b) = (axis.scale.map(a)?, axis.scale.map(b)?);
    let span = Span {
        low: a.min(b),
        high: a.max(b),
    };
    (span.length() > MIN_RELATIVE_LENGTH * a.abs().max(b.abs()).max(1e-290)).then_some(span)
}

/// A range around `all`, with free room around those of its values that need it.
fn automatic(scale: Scale, all: Extent, roomy: Extent) -> Span {
    let Some((low, high)) = all.0 else {
        return match scale {
            Scale::Linear => Span {
                low: 0.0,
                high: 1.0,
            },
            Scale::Log10 | Scale::Log2 => Span {
                low: -1.0,
                high: 0.0,
            },
        };
    };
    let size = low.abs().max(high.abs());
    if high - low <= MIN_RELATIVE_LENGTH * size.max(1e-280) {
        let half = match scale {
            Scale::Linear if size < 1e-280 => 1.0,
            Scale::Linear => 0.1 * size,
            Scale::Log10 | Scale::Log2 => 1.0,
        };
        return Span {
            low: low - half,
            high: high + half,
        };
    }
    let room = PADDING * (high - low);
    let (mut low, mut high) = (low, high);
    if let Some((a, b)) = roomy.0 {
        low = low.min(a - room);
        high = high.max(b + room);
    }
    rounded(scale, Span { low, high })
}

/// A range with a bottom edge for zeros: below round-off if the zeros are many or the data
/// come near it, else a little below the data.
fn with_zeros(scale: Scale, all: Extent, many: bool) -> Span {
    let per_decade = 10.0_f64.log2();
    let unit = if scale == Scale::Log2 {
        per_decade
    } else {
        1.0
    };
    let (low, high) = all.0.unwrap_or((-16.0 * unit, -16.0 * unit));
    let floor = if many || low < -9.0 * unit {
        ROUND_OFF_FLOOR * unit
    } else {
        f64::INFINITY
    };
    let low = (low - 0.5 * unit).floor().min(floor.floor());
    let high = (high + PADDING * (high - low)).max(low + unit);
    rounded(scale, Span { low, high })
}

fn rounded(scale: Scale, span: Span) -> Span {
    if scale == Scale::Log10 && span.length() >= MIN_WHOLE_DECADES {
        Span {
            low: span.low.floor(),
            high: span.high.ceil(),
        }
    } else {
        span
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{axis, panel, series};
    use super::*;

    fn y_of(scale: Scale, values: &[f64]) -> Span {
        let points = values
            .iter()
            .enumerate()
            .map(|(k, y)| (k as f64, *y))
            .collect();
        let mut panel = panel(vec![series("a", points, Style::LineAndPoints, 0)]);
        panel.y = axis("y", scale);
        spans(&panel).1
    }

    #[test]
    fn wide_ranges_end_at_decades() {
        let span = y_of(Scale::Log10, &[3e-16, 0.2]);
        assert_eq!((span.low, span.high), (-17.0, 0.0));
        let span = y_of(Scale::Log10, &[0.01, 0.1]);
        assert!(span.low < -2.0 && span.low > -2.2 && span.high < -0.8);
    }

    #[test]
    fn constants_single_points_and_nothing_have_ranges() {
        for scale in [Scale::Linear, Scale::Log10, Scale::Log2] {
            for values in [
                &[] as &[f64],
                &[0.0],
                &[5.0],
                &[5.0, 5.0],
                &[1e300, -1e300],
                &[5e-324, 5e-324],
                &[f64::MAX, f64::MIN],
                &[f64::NAN, f64::INFINITY],
                &[-3.0],
                &[1.0, 1.0 + 1e-15],
            ] {
                let span = y_of(scale, values);
                assert!(
                    span.length() > 0.0 && span.length().is_finite(),
                    "{scale:?} {values:?} {span:?}"
                );
            }
        }
    }

    #[test]
    fn zeros_reach_below_round_off_only_where_they_belong_to_it() {
        assert_eq!(y_of(Scale::Log10, &[0.0, 0.0]).low, -17.0);
        assert_eq!(y_of(Scale::Log10, &[0.0, 1e-14, 1e-2]).low, -17.0);
        // A trace that starts at a defect of zero keeps its own range.
        let mut trace = vec![0.0];
        trace.extend((1..100).map(|k| 1e-3 * f64::from(k)));
        assert_eq!(y_of(Scale::Log10, &trace).low, -4.0);
    }

    #[test]
    fn references_do_not_widen_the_range() {
        let mut panel = panel(vec![
            series("data", vec![(1.0, 1e-3), (2.0, 1e-1)], Style::Line, 0),
            series("h⁴", vec![(1.0, 1e-30), (2.0, 1.0)], Style::Dashed, 0),
        ]);
        panel.y = axis("y", Scale::Log10);
        assert!(spans(&panel).1.low > -4.0);
    }

    #[test]
    fn impossible_requests_fall_back_to_the_data() {
        let mut panel = panel(vec![series(
            "a",
            vec![(1.0, 2.0), (3.0, 4.0)],
            Style::Line,
            0,
        )]);
        panel.y = axis("y", Scale::Log10);
        let free = spans(&panel).1;
        for bad in [(0.0, 1.0), (f64::NAN, 1.0), (1.0, 1.0), (-1.0, -2.0)] {
            panel.y.range = Some(bad);
            assert_eq!(spans(&panel).1, free);
        }
        panel.y.range = Some((10.0, 1.0));
        assert_eq!(
            spans(&panel).1,
            Span {
                low: 0.0,
                high: 1.0
            }
        );
    }
}

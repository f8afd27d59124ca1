//! Parts of figures: axes, series, reference slopes, phase portraits.

use std::collections::HashMap;

use contour::ContourBuilder;
use symplint::Block;
use symplint::state::RowsMut;
use symplint::trace::{Observable, TracePoint};

use crate::figure::{Axis, Panel, Scale, Series, Style, superscript};

/// Palette index of curves that are not measurements.
const BLACK: usize = 6;

/// An axis with an automatic range.
pub fn axis(label: &str, scale: Scale) -> Axis {
    Axis {
        label: label.into(),
        scale,
        range: None,
    }
}

/// The axis of step sizes.
pub fn step_axis() -> Axis {
    axis("step size h", Scale::Log2)
}

/// The axis of relative defects.
pub fn error_axis() -> Axis {
    axis("relative change of ∮p·dq", Scale::Log10)
}

/// A series.
pub fn series(label: &str, points: Vec<(f64, f64)>, style: Style, color: usize) -> Series {
    Series {
        label: label.into(),
        points,
        style,
        color,
    }
}

/// The index of a series with this colour and this marker. Colours repeat after 7 indices, markers after 5.
pub fn look(color: usize, marker: usize) -> usize {
    (color % 7..35)
        .step_by(7)
        .find(|index| index % 5 == marker % 5)
        .unwrap_or(color)
}

/// The uncertainty of defects, by one name in every figure: quadrature error and round-off together. Where several
/// curves have a point at one abscissa, it is the largest that is known (not NaN) there.
pub fn uncertainty(points: impl IntoIterator<Item = (f64, f64)>) -> Series {
    let mut largest: Vec<(f64, f64)> = Vec::new();
    let mut places = HashMap::new();
    for (x, size) in points {
        let place = *places.entry(x.to_bits()).or_insert(largest.len());
        match largest.get_mut(place) {
            None => largest.push((x, size)),
            Some(known) => known.1 = known.1.max(size),
        }
    }
    series("uncertainty", largest, Style::Uncertainty, 0)
}

/// The uncertainty of the points of traces, against time.
pub fn uncertainty_in_time<'a>(points: impl IntoIterator<Item = &'a TracePoint>) -> Series {
    uncertainty(points.into_iter().map(|point| {
        let quadrature = point.quadrature_error.unwrap_or(f64::NAN);
        (point.time, quadrature + point.roundoff)
    }))
}

/// A dashed line of slope `order` that runs just below those of the defects `points` that lie well above
/// round-off.
pub fn reference_slope(points: &[(f64, f64)], order: f64, variable: &str) -> Series {
    let factor = (points.iter())
        .filter(|point| point.1 > 1e-13)
        .map(|point| 0.5 * point.1 / point.0.powf(order))
        .fold(f64::INFINITY, f64::min);
    let line = |x: f64| (x, factor * x.powf(order));
    let power = match order {
        1.0 => variable.to_owned(),
        _ => format!("{variable}{}", superscript(order)),
    };
    series(
        &power,
        points.iter().map(|p| line(p.0)).collect(),
        Style::Dashed,
        BLACK,
    )
}

/// Loops over the contours of the energy, one degree of freedom.
pub fn portrait(
    title: &str,
    loops: &[(String, Vec<(f64, f64)>)],
    energy: Option<Observable<'_>>,
) -> Panel {
    let all = || loops.iter().flat_map(|(_, points)| points.iter().copied());
    let (left, right) = bounds(all().map(|point| point.0));
    let (bottom, top) = bounds(all().map(|point| point.1));
    let mut all_series = energy.map_or(Vec::new(), |energy| {
        contours((left, right), (bottom, top), energy)
    });
    for (index, (label, points)) in loops.iter().enumerate() {
        all_series.push(series(label, points.clone(), Style::Closed, index));
    }
    let ranged = |label: &str, range| Axis {
        label: label.into(),
        scale: Scale::Linear,
        range: Some(range),
    };
    Panel {
        title: title.into(),
        x: ranged("q", (left, right)),
        y: ranged("p", (bottom, top)),
        series: all_series,
        equal_aspect: true,
    }
}

fn bounds(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(v), h.max(v))
    });
    let margin = 0.15 * (high - low).max(1e-12);
    (low - margin, high + margin)
}

/// Equally filled contours of the energy on a box.
fn contours(x: (f64, f64), y: (f64, f64), energy: Observable<'_>) -> Vec<Series> {
    const COLUMNS: usize = 161;
    const ROWS: usize = 121;
    const LEVELS: usize = 11;
    let step = |range: (f64, f64), count: usize| (range.1 - range.0) / (count - 1) as f64;
    let (dx, dy) = (step(x, COLUMNS), step(y, ROWS));
    let mut q: Vec<f64> = (0..COLUMNS * ROWS)
        .map(|k| x.0 + (k % COLUMNS) as f64 * dx)
        .collect();
    let mut p: Vec<f64> = (0..COLUMNS * ROWS)
        .map(|k| y.0 + (k / COLUMNS) as f64 * dy)
        .collect();
    let mut values = vec![0.0; COLUMNS * ROWS];
    let n = values.len();
    let states = Block::new(RowsMut::new(&mut q, 1, n, n), RowsMut::new(&mut p, 1, n, n));
    energy(states.q.as_rows(), states.p.as_rows(), &mut values);
    let mut sorted = values.clone();
    sorted.sort_by(f64::total_cmp);
    let levels: Vec<f64> = (1..=LEVELS)
        .map(|k| sorted[k * (n - 1) / (LEVELS + 1)])
        .collect();
    let builder = ContourBuilder::new(COLUMNS, ROWS, true)
        .x_origin(x.0)
        .y_origin(y.0)
        .x_step(dx)
        .y_step(dy);
    let lines = builder.lines(&values, &levels).unwrap_or_default();
    (lines.iter())
        .flat_map(|line| line.geometry().iter())
        .map(|curve| {
            let points = curve.points().map(|point| (point.x(), point.y())).collect();
            series("", points, Style::Thin, 0)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_colour_has_every_marker() {
        for color in 0..7 {
            for marker in 0..5 {
                let index = look(color, marker);
                assert_eq!((index % 7, index % 5), (color, marker));
            }
        }
    }

    #[test]
    fn of_several_uncertainties_the_largest_is_drawn() {
        let unknown = f64::NAN;
        let band = uncertainty([
            (1.0, 1e-3),
            (2.0, unknown),
            (3.0, unknown),
            (1.0, 1e-2),
            (2.0, 1e-3),
            (3.0, unknown),
        ]);
        assert_eq!(band.points[..2], [(1.0, 1e-2), (2.0, 1e-3)]);
        assert!(band.points.len() == 3 && band.points[2].1.is_nan());
    }
}

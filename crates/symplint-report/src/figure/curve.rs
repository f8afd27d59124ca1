//! From data to the lines and points on the page.
//!
//! Lines break at values an axis cannot show, are cut at the frame, and lose points that a reader
//! could not see, so that 100 000 points make a file as small as a few thousand.

use super::geometry::{Point, Rect, distance_to_segment};
use super::scale::Ruler;

/// Width of the columns in which a line keeps only its first, lowest, highest and last point.
const COLUMN_WIDTH: f64 = 0.5;
/// Largest distance between a line and the points that it omits.
const MAX_SHIFT: f64 = 0.12;
/// Most points omitted in a row, which bounds the work per point.
const MAX_OMITTED: usize = 64;

/// The page places of the points, split where one cannot be shown.
pub(super) fn runs(points: &[Point], x: &Ruler, y: &Ruler) -> Vec<Vec<Point>> {
    let mut runs = vec![Vec::new()];
    for point in points {
        match (x.place_value(point.0), y.place_value(point.1)) {
            (Some(x), Some(y)) => {
                if let Some(run) = runs.last_mut() {
                    run.push((x, y));
                }
            }
            _ => runs.push(Vec::new()),
        }
    }
    runs.retain(|run| !run.is_empty());
    runs
}

/// The visible lines of a run: decimated and cut at the frame.
pub(super) fn visible(run: &[Point], frame: Rect) -> Vec<Vec<Point>> {
    cut(&thinned(run), frame)
        .into_iter()
        .map(|piece| straightened(&piece))
        .collect()
}

/// First, lowest, highest and last point of every column, where x does not turn back.
fn thinned(run: &[Point]) -> Vec<Point> {
    let column = |point: &Point| (point.0 / COLUMN_WIDTH).floor();
    if run.windows(2).any(|pair| pair[1].0 < pair[0].0) {
        return run.to_vec();
    }
    let mut kept = Vec::new();
    for group in run.chunk_by(|a, b| column(a) == column(b)) {
        let mut extremes = [0, 0, 0, group.len() - 1];
        for (k, point) in group.iter().enumerate() {
            if point.1 < group[extremes[1]].1 {
                extremes[1] = k;
            }
            if point.1 > group[extremes[2]].1 {
                extremes[2] = k;
            }
        }
        extremes.sort_unstable();
        let mut previous = None;
        for k in extremes {
            if previous != Some(k) {
                kept.push(group[k]);
            }
            previous = Some(k);
        }
    }
    kept
}

/// The pieces of a run inside the frame.
fn cut(run: &[Point], frame: Rect) -> Vec<Vec<Point>> {
    let mut pieces: Vec<Vec<Point>> = Vec::new();
    for pair in run.windows(2) {
        let Some((from, to)) = frame.clip(pair[0], pair[1]) else {
            continue;
        };
        match pieces.last_mut() {
            Some(piece) if piece.last() == Some(&from) => piece.push(to),
            _ => pieces.push(vec![from, to]),
        }
    }
    pieces
}

/// The same line without points that lie on it anyway.
fn straightened(piece: &[Point]) -> Vec<Point> {
    let mut kept = Vec::new();
    let mut anchor = 0;
    while anchor < piece.len() {
        kept.push(piece[anchor]);
        let furthest = (anchor + MAX_OMITTED).min(piece.len() - 1);
        let mut next = anchor + 1;
        while next < furthest
            && piece[anchor + 1..=next]
                .iter()
                .all(|p| distance_to_segment(*p, piece[anchor], piece[next + 1]) < MAX_SHIFT)
        {
            next += 1;
        }
        anchor = next;
    }
    kept
}

/// The dashes of a line.
pub(super) fn dashes(piece: &[Point], (dash, gap): (f64, f64)) -> Vec<Vec<Point>> {
    let mut dashes = Vec::new();
    let mut current: Vec<Point> = piece.first().copied().into_iter().collect();
    let (mut drawing, mut left) = (true, dash);
    for pair in piece.windows(2) {
        let (mut from, to) = (pair[0], pair[1]);
        loop {
            let rest = (to.0 - from.0).hypot(to.1 - from.1);
            if rest < left {
                left -= rest;
                if drawing {
                    current.push(to);
                }
                break;
            }
            let part = left / rest;
            from = (
                from.0 + part * (to.0 - from.0),
                from.1 + part * (to.1 - from.1),
            );
            if drawing {
                current.push(from);
                dashes.push(std::mem::take(&mut current));
            } else {
                current = vec![from];
            }
            drawing = !drawing;
            left = if drawing { dash } else { gap };
        }
    }
    if drawing {
        dashes.push(current);
    }
    dashes.retain(|dash| dash.len() > 1);
    dashes
}

/// Points no two of which are closer than `distance` along the list.
pub(super) fn spaced(points: &[Point], distance: f64) -> Vec<Point> {
    let mut kept: Vec<Point> = Vec::new();
    for point in points {
        let free = kept
            .last()
            .is_none_or(|last| (point.0 - last.0).hypot(point.1 - last.1) >= distance);
        if free {
            kept.push(*point);
        }
    }
    kept
}

/// At most `most` points of a cloud: one for each cell of a grid that is as fine as possible.
pub(super) fn sparse_cloud(points: Vec<Point>, most: usize) -> Vec<Point> {
    let mut cell = 0.5;
    let mut kept = points;
    while kept.len() > most {
        let mut seen = std::collections::HashSet::new();
        kept.retain(|p| seen.insert(((p.0 / cell) as i64, (p.1 / cell) as i64)));
        cell *= 1.4;
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::super::Scale;
    use super::super::scale::Span;
    use super::*;

    const FRAME: Rect = Rect {
        left: 0.0,
        top: 0.0,
        right: 100.0,
        bottom: 100.0,
    };

    fn ruler(scale: Scale) -> Ruler {
        Ruler {
            scale,
            span: Span {
                low: 0.0,
                high: 100.0,
            },
            start: 0.0,
            end: 100.0,
        }
    }

    #[test]
    fn lines_break_where_there_is_no_value() {
        let points = [
            (1.0, 1.0),
            (2.0, f64::NAN),
            (3.0, 1.0),
            (4.0, 0.0),
            (5.0, -1.0),
        ];
        let x = ruler(Scale::Linear);
        assert_eq!(runs(&points, &x, &ruler(Scale::Linear)).len(), 2);
        let log = runs(&points, &x, &ruler(Scale::Log10));
        assert_eq!(log, [vec![(1.0, 0.0)], vec![(3.0, 0.0)]]);
    }

    #[test]
    fn many_points_become_few_and_keep_their_extremes() {
        let run: Vec<Point> = (0..100_000)
            .map(|k| {
                let spike = if k == 51_234 { 45.0 } else { 0.0 };
                (
                    f64::from(k) * 1e-3,
                    50.0 + 3.0 * (f64::from(k) * 0.7).sin() + spike,
                )
            })
            .collect();
        let lines = visible(&run, FRAME);
        let count: usize = lines.iter().map(Vec::len).sum();
        assert!(count < 900, "{count} points left");
        let highest = lines.iter().flatten().map(|p| p.1).fold(0.0, f64::max);
        assert!(highest > 91.0);
    }

    #[test]
    fn smooth_closed_curves_stay_smooth() {
        let circle: Vec<Point> = (0..=2000)
            .map(|k| f64::from(k) * std::f64::consts::TAU / 2000.0)
            .map(|t| (50.0 + 40.0 * t.cos(), 50.0 + 40.0 * t.sin()))
            .collect();
        let lines = visible(&circle, FRAME);
        assert_eq!(lines.len(), 1);
        assert!(lines[0].len() < 120 && lines[0].len() > 30);
        let (first, last) = (lines[0][0], lines[0][lines[0].len() - 1]);
        assert!((first.0 - last.0).hypot(first.1 - last.1) < 1e-9);
    }

    #[test]
    fn lines_are_cut_at_the_frame() {
        let lines = visible(
            &[(-50.0, 50.0), (50.0, 50.0), (50.0, 500.0), (90.0, 90.0)],
            FRAME,
        );
        assert_eq!(lines.len(), 2);
        assert!(
            lines
                .iter()
                .flatten()
                .all(|p| FRAME.grown(1e-9).contains(*p))
        );
    }

    #[test]
    fn dashes_cover_their_share() {
        let found = dashes(&[(0.0, 0.0), (99.0, 0.0)], (6.0, 4.0));
        assert_eq!(found.len(), 10);
        let drawn: f64 = found.iter().map(|d| d[d.len() - 1].0 - d[0].0).sum();
        assert!((drawn - 60.0).abs() < 1e-9);
    }

    #[test]
    fn clouds_are_thinned_evenly() {
        let cloud = (0..100_000)
            .map(|k| (f64::from(k % 317) * 0.3, f64::from(k / 317) * 0.3))
            .collect();
        let kept = sparse_cloud(cloud, 4000);
        assert!(kept.len() <= 4000 && kept.len() > 1500);
    }
}

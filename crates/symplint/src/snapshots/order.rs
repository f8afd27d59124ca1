//! Whether the samples of a file are in the order of the loop.

use crate::state::{Coordinates, Ensemble};

/// Mean distance of neighbouring samples over that of samples sorted by the angle round their centre, in the plane
/// (q_i, p_i) in which the loop is largest: 1 for rows in the order of the loop, about a third of their number for
/// shuffled ones. `None` where all planes are periodic, or the loop is flat in every plane.
pub(super) fn shuffled(states: &Ensemble, coordinates: &Coordinates) -> Option<f64> {
    let samples = states.samples() as f64;
    let spread = |row: &[f64]| {
        let mean = row.iter().sum::<f64>() / samples;
        (row.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / samples).sqrt()
    };
    let of_plane = |i: usize| (spread(states.q().row(i)), spread(states.p().row(i)));
    let (dof, (q_spread, p_spread)) = (0..states.dof())
        .filter(|&i| coordinates.period(i) == 0.0 && coordinates.momentum_period(i) == 0.0)
        .map(|i| (i, of_plane(i)))
        .max_by(|(_, a), (_, b)| (a.0 * a.1).total_cmp(&(b.0 * b.1)))?;
    if !(q_spread > 0.0 && p_spread > 0.0) {
        return None;
    }
    let scaled = |row: &[f64], spread: f64| -> Vec<f64> {
        let mean = row.iter().sum::<f64>() / samples;
        row.iter().map(|x| (x - mean) / spread).collect()
    };
    let q = scaled(states.q().row(dof), q_spread);
    let p = scaled(states.p().row(dof), p_spread);
    let length = |order: &[usize]| -> f64 {
        let next = order.iter().skip(1).chain(order.first());
        (order.iter().zip(next))
            .map(|(&a, &b)| (q[b] - q[a]).hypot(p[b] - p[a]))
            .sum()
    };
    let given: Vec<usize> = (0..q.len()).collect();
    let mut sorted = given.clone();
    sorted.sort_by(|&a, &b| p[a].atan2(q[a]).total_cmp(&p[b].atan2(q[b])));
    let (given, sorted) = (length(&given), length(&sorted));
    (sorted > 0.0).then(|| given / sorted)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loops::Circle;

    fn ratio(order: impl Fn(usize) -> usize) -> f64 {
        const SAMPLES: usize = 256;
        let circle = Circle::new(vec![0.3, -1.0], vec![5.0, 2.0], 0.7).unwrap();
        let loop_in_order = Ensemble::sample(&circle, SAMPLES).unwrap();
        let mut states = loop_in_order.clone();
        for k in 0..SAMPLES {
            for i in 0..2 {
                states.block().q.row_mut(i)[k] = loop_in_order.q().row(i)[order(k)];
                states.block().p.row_mut(i)[k] = loop_in_order.p().row(i)[order(k)];
            }
        }
        shuffled(&states, &Coordinates::plain(2)).unwrap()
    }

    #[test]
    fn shuffled_rows_are_told_from_rows_in_order() {
        assert!((ratio(|k| k) - 1.0).abs() < 1e-12);
        assert!((ratio(|k| 255 - k) - 1.0).abs() < 1e-12);
        // Begun elsewhere.
        assert!((ratio(|k| (k + 77) % 256) - 1.0).abs() < 1e-12);
        // A permutation without any order.
        assert!(ratio(|k| (k * 97 + 13) % 256) > 30.0);
    }
}

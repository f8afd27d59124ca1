//! Slow controls: loop integrals by chords and extrapolation, without transforms.

use std::sync::Arc;

use symplint::{Ensemble, Loop};

use crate::truth_set::member::Step;

/// Rows of the extrapolation at most: 4, 8, …, 4096 chords.
const ROWS: usize = 11;

/// ∫ p·dq along a smooth curve from `from` to `to`: sums over chords, whose errors are a series in n⁻², extrapolated.
pub fn integral(curve: &dyn Fn(f64) -> (Vec<f64>, Vec<f64>), from: f64, to: f64) -> f64 {
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for level in 0..ROWS {
        let n = 4 << level;
        let points: Vec<_> = (0..=n)
            .map(|k| curve(from + (to - from) * k as f64 / n as f64))
            .collect();
        let chord = |pair: &[(Vec<f64>, Vec<f64>)]| -> f64 {
            let ((q0, p0), (q1, p1)) = (&pair[0], &pair[1]);
            (0..q0.len())
                .map(|i| 0.5 * (p0[i] + p1[i]) * (q1[i] - q0[i]))
                .sum()
        };
        let mut row = vec![points.windows(2).map(chord).sum::<f64>()];
        if let Some(previous) = rows.last() {
            for (k, coarse) in previous.iter().enumerate() {
                let gain = 4f64.powi(k as i32 + 1) - 1.0;
                row.push(row[k] + (row[k] - coarse) / gain);
            }
            let (found, before) = (row[level], previous[level - 1]);
            if level > 3 && (found - before).abs() < 1e-15 * found.abs().max(1e-3) {
                return found;
            }
        }
        rows.push(row);
    }
    *rows[ROWS - 1].last().unwrap()
}

/// One state of a loop.
pub fn state(on: &dyn Loop, s: f64) -> (Vec<f64>, Vec<f64>) {
    let mut one = Ensemble::zeros(on.dof(), 1);
    on.sample(&[s], &mut one.block());
    let column = |rows: symplint::state::Rows<'_>| (0..on.dof()).map(|i| rows.row(i)[0]).collect();
    (column(one.q()), column(one.p()))
}

/// (I(h) − I(0)) / |I(0)| of a smooth map.
pub fn change(step: &Step, on: &Arc<dyn Loop>, h: f64) -> f64 {
    let after = |s: f64| {
        let (mut q, mut p) = state(&**on, s);
        step(h, &mut q, &mut p);
        (q, p)
    };
    let initial = integral(&|s| state(&**on, s), 0.0, 1.0);
    (integral(&after, 0.0, 1.0) - initial) / initial.abs()
}

//! The noise of a map: rounding, single precision, solvers that stop at a tolerance.
//!
//! The sixth difference of a smooth function over a short stretch is below round-off; what is left is
//! noise (Moré & Wild, "Estimating computational noise", SIAM J. Sci. Comput. 33, 2011).

use crate::signal::noise::{POINTS, SixthDifference};

/// Where the other states of a row lie, in spacings from the centre. They are not equidistant: stairs whose
/// height divides the spacing would look straight.
const NODES: [f64; 12] = [
    -5.81, -5.23, -3.88, -3.17, -1.83, -0.92, 1.13, 2.21, 2.94, 4.27, 4.79, 6.17,
];

/// States of a row on each side of the centre.
const SIDE: usize = NODES.len() / 2;

/// States of a row, the centre among them.
const ROW: usize = NODES.len() + 1;

/// Sixth differences of a row, each of seven neighbours.
const WINDOWS: usize = ROW + 1 - POINTS;

/// Spacings, in units of the direction; the largest reaches as far as the differences.
const SPACINGS: [f64; 4] = [1.434e-5, 2.371e-4, 3.883e-3, 2.0e-2];

/// States of a noise stencil, that at the centre first.
pub(super) const STATES: usize = 1 + NODES.len() * SPACINGS.len();

/// Noise is counted this many times what the differences show: they show its standard deviation.
const SAFETY: f64 = 4.0;

/// How far along the direction the states of a noise stencil are.
pub(super) fn offsets() -> impl Iterator<Item = f64> {
    let around = |spacing: f64| NODES.into_iter().map(move |node| node * spacing);
    std::iter::once(0.0).chain(SPACINGS.into_iter().flat_map(around))
}

/// The sixth differences of a row, one for each seven neighbours.
pub(super) struct SixthDifferences([SixthDifference; WINDOWS]);

impl SixthDifferences {
    pub fn new() -> Self {
        let mut nodes = [0.0; ROW];
        nodes[..SIDE].copy_from_slice(&NODES[..SIDE]);
        nodes[SIDE + 1..].copy_from_slice(&NODES[SIDE..]);
        SixthDifferences(std::array::from_fn(|first| {
            SixthDifference::at(std::array::from_fn(|k| nodes[first + k]))
        }))
    }

    /// The noise of one coordinate from its differences to the centre, in units of its size and in the
    /// order of [`offsets`].
    ///
    /// The smallest spacing counts at which neighbours differ: it is least misled by a steep map, and a
    /// smaller one sees the stairs of single precision only now and then. Where every spacing has
    /// equal neighbours, the largest noise counts. A coordinate that does not respond at all is noise as large
    /// as the loop: a symplectic map has none, so it must be coarser than the differences.
    pub fn noise(&self, differences: &[f64]) -> f64 {
        const MOST_EQUAL: usize = 2;
        if differences.iter().all(|&difference| difference == 0.0) {
            return 1.0;
        }
        let mut largest: f64 = 0.0;
        for around in differences[1..].chunks_exact(NODES.len()) {
            let mut row = [0.0; ROW];
            row[..SIDE].copy_from_slice(&around[..SIDE]);
            row[SIDE + 1..].copy_from_slice(&around[SIDE..]);
            let noise = SAFETY * self.root_mean_square(&row);
            let equal = row.windows(2).filter(|pair| pair[0] == pair[1]).count();
            if equal <= MOST_EQUAL {
                return noise;
            }
            largest = largest.max(noise);
        }
        largest
    }

    fn root_mean_square(&self, row: &[f64; ROW]) -> f64 {
        let windows = row.windows(POINTS).zip(&self.0);
        let squares = windows.map(|(values, difference)| difference.of(values).powi(2));
        (squares.sum::<f64>() / WINDOWS as f64).sqrt()
    }
}

/// The noise at each place from what each place showed: its own, but not far from that of most
/// places, as a break near one place looks like noise there.
pub(super) fn at_each_place(shown: &[f64]) -> Vec<f64> {
    const MOST: f64 = 16.0;
    let mut sorted = shown.to_vec();
    sorted.sort_by(f64::total_cmp);
    let median = sorted[sorted.len() / 2];
    (shown.iter())
        .map(|&own| median.max(own.min(MOST * median)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(f: impl Fn(f64) -> f64) -> f64 {
        let differences: Vec<f64> = offsets().map(|t| f(t) - f(0.0)).collect();
        assert_eq!(differences.len(), STATES);
        SixthDifferences::new().noise(&differences)
    }

    #[test]
    fn single_precision_shows_its_rounding() {
        for scale in [0.1, 1.0, 37.0, 1e4] {
            // Counted against 1, though the values are much larger.
            let noise = shown(|t| f64::from((scale + t).sin() as f32 + scale as f32));
            let ulp = f64::from(f32::EPSILON) * scale.max(1.0);
            assert!(
                (0.05 * ulp..8.0 * ulp).contains(&noise),
                "{scale}: {noise:e}"
            );
        }
    }

    #[test]
    fn double_precision_shows_round_off_however_steep_the_map() {
        for rate in [1.0, 10.0, 100.0] {
            let noise = shown(|t| 2.0 + (rate * t + 0.4).sin());
            assert!(noise < 1e-14, "{rate}: {noise:e}");
        }
    }

    #[test]
    fn stairs_of_any_width_show_their_height() {
        for exponent in 0..24 {
            let height = 0.1 * 0.5f64.powi(exponent);
            let noise = shown(|t| ((t + 0.3217) / height).round() * height);
            assert!(
                (0.3..8.0).contains(&(noise / height)),
                "{height:e}: {noise:e}"
            );
        }
        assert_eq!(shown(|_| 7.0), 1.0);
    }

    #[test]
    fn one_place_at_a_break_does_not_count() {
        let noise = at_each_place(&[1.0, 2.0, 1e9, 1.5, 1.0]);
        assert_eq!(noise, [1.5, 2.0, 24.0, 1.5, 1.5]);
    }
}

//! The noise of a map: rounding, single precision, solvers that stop at a tolerance.
//!
//! The sixth difference of a smooth function over a short stretch is below round-off; what is left is
//! noise (Moré & Wild, "Estimating computational noise", SIAM J. Sci. Comput. 33, 2011).

use crate::signal::noise::SixthDifferences;

/// The other states of a row, in spacings from the centre. They are not equidistant: stairs whose
/// height divides the spacing would look straight.
const NODES: [f64; 12] = [
    -5.81, -5.23, -3.88, -3.17, -1.83, -0.92, 1.13, 2.21, 2.94, 4.27, 4.79, 6.17,
];

/// States of a row on each side of the centre.
const SIDE: usize = NODES.len() / 2;

/// States of a row, the centre among them.
const ROW: usize = NODES.len() + 1;

/// Spacings, in units of the direction; the largest reaches as far as the differences.
const SPACINGS: [f64; 4] = [1.434e-5, 2.371e-4, 3.883e-3, 2.0e-2];

/// Spacings of a noise stencil.
pub(super) const LEVELS: usize = SPACINGS.len();

/// States at each spacing; there is one more at the centre.
pub(super) const STATES: usize = NODES.len();

/// Noise is counted this many times what the differences show: they show its standard deviation.
const SAFETY: f64 = 4.0;

/// Neighbours of a row that may be equal.
const MOST_EQUAL: usize = 2;

/// How far along the direction the states at a spacing are.
pub(super) fn offsets(level: usize) -> impl Iterator<Item = f64> {
    NODES.into_iter().map(move |node| node * SPACINGS[level])
}

/// The noise of one coordinate at one point.
///
/// The smallest spacing counts at which neighbours differ: it is least misled by a steep map, and a
/// smaller one sees the stairs of single precision only now and then. Where every spacing has
/// equal neighbours, the largest noise counts.
#[derive(Clone, Copy, Default)]
pub(super) struct Noise {
    value: f64,
    /// Whether a spacing was found at which neighbours differ, so that larger ones are not needed.
    pub resolved: bool,
}

/// The values of a row from those at the other states and that at the centre.
fn row(others: [f64; STATES], centre: f64) -> [f64; ROW] {
    let mut row = [centre; ROW];
    row[..SIDE].copy_from_slice(&others[..SIDE]);
    row[SIDE + 1..].copy_from_slice(&others[SIDE..]);
    row
}

/// The sixth differences of a row.
pub(super) fn sixth_differences() -> SixthDifferences {
    SixthDifferences::at(&row(NODES, 0.0))
}

impl Noise {
    /// Adds the differences of a coordinate to its value at the centre, in units of its size, at one spacing; the
    /// smallest spacing first.
    pub fn add(&mut self, sixth_differences: &SixthDifferences, differences: [f64; STATES]) {
        if self.resolved {
            return;
        }
        let row = row(differences, 0.0);
        let shown = SAFETY * sixth_differences.root_mean_square(&row);
        let equal = row.windows(2).filter(|pair| pair[0] == pair[1]).count();
        self.resolved = equal <= MOST_EQUAL;
        self.value = match self.resolved {
            true => shown,
            false => self.value.max(shown),
        };
    }

    /// In units of the coordinate's size; `None` of a coordinate that does not respond at all.
    pub fn value(self) -> Option<f64> {
        (self.resolved || self.value > 0.0).then_some(self.value)
    }
}

/// The noise at each place from what each place showed: its own, but not far from that of most
/// places, as a break near one place looks like noise there.
///
/// If a coordinate does not respond at all, it is constant (clipped, for example) if it has many digits at another place. Otherwise
/// its noise is as large as the loop: it is coarser than the differences.
pub(super) fn at_each_place(shown: &[Option<f64>]) -> Vec<f64> {
    const MOST: f64 = 16.0;
    const MANY_DIGITS: f64 = 1e-10;
    let least = shown.iter().flatten().copied().reduce(f64::min);
    let of_constant = least.filter(|&noise| noise <= MANY_DIGITS).unwrap_or(1.0);
    let shown: Vec<f64> = shown.iter().map(|own| own.unwrap_or(of_constant)).collect();
    let mut sorted = shown.clone();
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
        let mut noise = Noise::default();
        for level in 0..LEVELS {
            let at: Vec<f64> = offsets(level).collect();
            let differences = std::array::from_fn(|k| f(at[k]) - f(0.0));
            noise.add(&sixth_differences(), differences);
        }
        at_each_place(&[noise.value()])[0]
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
        let noise = at_each_place(&[1.0, 2.0, 1e9, 1.5, 1.0].map(Some));
        assert_eq!(noise, [1.5, 2.0, 24.0, 1.5, 1.5]);
    }

    #[test]
    fn a_coordinate_with_many_digits_elsewhere_is_constant_where_it_does_not_respond() {
        assert_eq!(at_each_place(&[None, Some(1e-15), None]), [1e-15; 3]);
        assert_eq!(at_each_place(&[None, Some(1e-3), None])[0], 1.0);
    }
}

//! The noise of a map along a direction: rounding, single precision, solvers that stop at a tolerance.

use crate::signal::noise::{MAX_NOISE_OVER_OTHERS, NODES_BESIDE};

/// Spacings, in units of the direction; the largest reaches as far as the differences.
pub(super) const SPACINGS: [f64; 4] = [1.434e-5, 2.371e-4, 3.883e-3, 2.0e-2];

/// How far along the direction the states at a spacing are.
pub(super) fn offsets(level: usize) -> impl Iterator<Item = f64> {
    NODES_BESIDE
        .into_iter()
        .map(move |node| node * SPACINGS[level])
}

/// The noise at each place from what each place showed: its own, but not far from that of most
/// places, as a break near one place looks like noise there.
///
/// If a coordinate does not respond at all, it is constant (clipped, for example) if it has many digits at another place. Otherwise
/// its noise is as large as the loop: it is coarser than the differences.
pub(super) fn at_each_place(shown: &[Option<f64>]) -> Vec<f64> {
    /// A coordinate that does not respond is constant if its noise at another place is at most this.
    const MAX_NOISE_OF_CONSTANT: f64 = 1e-10;
    let least = shown.iter().flatten().copied().reduce(f64::min);
    let of_constant = least
        .filter(|&noise| noise <= MAX_NOISE_OF_CONSTANT)
        .unwrap_or(1.0);
    let shown: Vec<f64> = shown.iter().map(|own| own.unwrap_or(of_constant)).collect();
    let mut sorted = shown.clone();
    sorted.sort_by(f64::total_cmp);
    let median = sorted[sorted.len() / 2];
    (shown.iter())
        .map(|&own| median.max(own.min(MAX_NOISE_OVER_OTHERS * median)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::noise::SAFETY;
    use crate::signal::noise::{Noise, of_a_row};

    fn shown(f: impl Fn(f64) -> f64) -> f64 {
        let mut noise = Noise::default();
        for level in 0..SPACINGS.len() {
            let at: Vec<f64> = offsets(level).collect();
            let differences = std::array::from_fn(|k| f(at[k]) - f(0.0));
            noise.add(&of_a_row(), differences);
        }
        at_each_place(&[noise.value().map(|shown| SAFETY * shown)])[0]
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

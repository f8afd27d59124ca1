//! Sums over the modes of two real rows that were transformed together, as q + i p.
//!
//! With Z the transform of q + i p, N samples, the transforms of the rows are
//!
//! Q_k = (Z_k + conj Z_{N−k})/2, P_k = (Z_k − conj Z_{N−k})/2i.
//!
//! They are taken apart before anything is multiplied: a sum of |Z_k|² would cancel. Sums run in [`LANES`] lanes, whatever registers the processor has: only the transforms may differ
//! between processors. No multiplication is fused with an addition: rows that are equal enclose no area, to
//! the last bit.

use crate::signal::LANES;
use std::ops::{Add, Range};

use multiversion::multiversion;
use symplint_fft::Complex64;

/// So many neighbouring modes.
type Group = [Complex64; LANES];

/// Sums over a band of modes of q and p, Q_k and P_k.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    /// Σ k (Im P_k Re Q_k − Re P_k Im Q_k).
    pub value: f64,
    /// Σ k |P_k| |Q_k|, at most 18 per cent too large.
    pub scale: f64,
    /// Σ k |Q_k|, at most 9 per cent too large.
    pub q_slope: f64,
    /// Σ k |P_k|, at most 9 per cent too large.
    pub p_slope: f64,
    /// Σ k² |Q_k|².
    pub q_slope_squared: f64,
    /// Σ k² |P_k|².
    pub p_slope_squared: f64,
    /// Σ |Q_k|².
    pub q_power: f64,
    /// Σ |P_k|².
    pub p_power: f64,
}

impl Sums {
    /// Over the modes of `band`, which lies within 1 … ⌈N/2⌉ − 1.
    pub fn over(modes: &[Complex64], band: Range<usize>) -> Self {
        let [
            value,
            scale,
            q_slope,
            p_slope,
            q_slope_squared,
            p_slope_squared,
            q_power,
            p_power,
        ] = all_sums(modes, band);
        // Of twice Q_k and P_k.
        Sums {
            value: 0.25 * value,
            scale: 0.25 * OUTER_OVER_INNER_OCTAGON * OUTER_OVER_INNER_OCTAGON * scale,
            q_slope: 0.5 * OUTER_OVER_INNER_OCTAGON * q_slope,
            p_slope: 0.5 * OUTER_OVER_INNER_OCTAGON * p_slope,
            q_slope_squared: 0.25 * q_slope_squared,
            p_slope_squared: 0.25 * p_slope_squared,
            q_power: 0.25 * q_power,
            p_power: 0.25 * p_power,
        }
    }
}

impl Add for Sums {
    type Output = Sums;

    fn add(self, band: Sums) -> Sums {
        Sums {
            value: self.value + band.value,
            scale: self.scale + band.scale,
            q_slope: self.q_slope + band.q_slope,
            p_slope: self.p_slope + band.p_slope,
            q_slope_squared: self.q_slope_squared + band.q_slope_squared,
            p_slope_squared: self.p_slope_squared + band.p_slope_squared,
            q_power: self.q_power + band.q_power,
            p_power: self.p_power + band.p_power,
        }
    }
}

/// [`Sums::value`] alone.
pub(super) fn value(modes: &[Complex64], band: Range<usize>) -> f64 {
    0.25 * value_sum(modes, band)
}

/// Of N samples, N even, those modes that every second sample has, twice.
pub(super) fn fold(modes: &mut [Complex64]) -> &[Complex64] {
    let (lower, upper) = modes.split_at_mut(modes.len() / 2);
    for (mode, folded) in lower.iter_mut().zip(upper) {
        *mode += *folded;
    }
    lower
}

/// What [`Sums`] has, in its order, of twice Q_k and P_k, moduli by [`octagon`].
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn all_sums(modes: &[Complex64], band: Range<usize>) -> [f64; 8] {
    let mut sums = [[0.0; LANES]; 8];
    for_each_group(
        modes,
        band,
        #[inline(always)]
        |first, group, mirrored| {
            for lane in 0..LANES {
                let k = first + lane as f64;
                let [q, p] = apart(group[lane], mirrored[LANES - 1 - lane]);
                let (q_size, p_size) = (octagon(q), octagon(p));
                let (q_squared, p_squared) = (q.norm_sqr(), p.norm_sqr());
                sums[0][lane] += k * area(q, p);
                sums[1][lane] += k * (q_size * p_size);
                sums[2][lane] += k * q_size;
                sums[3][lane] += k * p_size;
                sums[4][lane] += k * k * q_squared;
                sums[5][lane] += k * k * p_squared;
                sums[6][lane] += q_squared;
                sums[7][lane] += p_squared;
            }
        },
    );
    sums.map(|lanes| lanes.iter().sum())
}

/// The first of [`all_sums`].
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn value_sum(modes: &[Complex64], band: Range<usize>) -> f64 {
    let mut sums = [0.0; LANES];
    for_each_group(
        modes,
        band,
        #[inline(always)]
        |first, group, mirrored| {
            for lane in 0..LANES {
                let [q, p] = apart(group[lane], mirrored[LANES - 1 - lane]);
                sums[lane] += (first + lane as f64) * area(q, p);
            }
        },
    );
    sums.iter().sum()
}

/// Calls `work` with k and with the modes k, k + 1, … and …, N − k − 1, N − k, for groups of modes k that make
/// up the band. The last is filled up with zeros, which add nothing.
#[inline(always)]
fn for_each_group(
    modes: &[Complex64],
    band: Range<usize>,
    mut work: impl FnMut(f64, &Group, &Group),
) {
    let mut k = band.start as f64;
    let mirror = modes.len() + 1 - band.end..modes.len() + 1 - band.start;
    let (groups, rest) = modes[band].as_chunks();
    let (mirrored_rest, mirrored) = modes[mirror].as_rchunks();
    for (group, mirrored) in groups.iter().zip(mirrored.iter().rev()) {
        work(k, group, mirrored);
        k += LANES as f64;
    }
    if !rest.is_empty() {
        let [mut group, mut mirrored] = [[Complex64::ZERO; LANES]; 2];
        group[..rest.len()].copy_from_slice(rest);
        mirrored[LANES - rest.len()..].copy_from_slice(mirrored_rest);
        work(k, &group, &mirrored);
    }
}

/// 2 Q_k and 2 P_k from Z_k and Z_{N−k}.
#[inline(always)]
fn apart(z: Complex64, mirrored: Complex64) -> [Complex64; 2] {
    [
        Complex64::new(z.re + mirrored.re, z.im - mirrored.im),
        Complex64::new(z.im + mirrored.im, mirrored.re - z.re),
    ]
}

/// Im p Re q − Re p Im q.
#[inline(always)]
fn area(q: Complex64, p: Complex64) -> f64 {
    p.im * q.re - p.re * q.im
}

/// 1/cos(π/8): from an octagon in a circle to the one round it.
const OUTER_OVER_INNER_OCTAGON: f64 = 1.082_392_200_292_394;

/// |z| within a factor of [`OUTER_OVER_INNER_OCTAGON`], from below: the gauge of the regular octagon round the unit circle.
///
/// Without a root, which would take longer than all else that is done to a mode.
#[inline(always)]
fn octagon(z: Complex64) -> f64 {
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let (x, y) = (z.re.abs(), z.im.abs());
    larger(std::f64::consts::FRAC_1_SQRT_2 * (x + y), larger(x, y))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A transform without symmetry, of any length.
    fn transform(n: usize) -> Vec<Complex64> {
        let part = |k: usize, shift: f64| (1.3 * (k * k) as f64 + shift).sin() + 0.1;
        (0..n)
            .map(|k| Complex64::new(part(k, 0.0), part(k, 2.0)))
            .collect()
    }

    /// [`Sums`] by their definition.
    fn slow(z: &[Complex64], band: Range<usize>) -> Sums {
        let mut sums = Sums::default();
        for k in band {
            let mirrored = z[z.len() - k].conj();
            let q = (z[k] + mirrored) / 2.0;
            let p = (z[k] - mirrored) / Complex64::new(0.0, 2.0);
            let k = k as f64;
            sums.value += k * (p * q.conj()).im;
            sums.scale += k * p.norm() * q.norm();
            sums.q_slope += k * q.norm();
            sums.p_slope += k * p.norm();
            sums.q_slope_squared += k * k * q.norm_sqr();
            sums.p_slope_squared += k * k * p.norm_sqr();
            sums.q_power += q.norm_sqr();
            sums.p_power += p.norm_sqr();
        }
        sums
    }

    #[test]
    fn sums_are_those_of_the_definition_over_any_band() {
        for n in (3..80).chain([200]) {
            let z = transform(n);
            let end = n.div_ceil(2);
            for start in 1..end {
                for end in [end, (start + end) / 2] {
                    let (sums, expected) = (Sums::over(&z, start..end), slow(&z, start..end));
                    for value in [sums.value, value(&z, start..end)] {
                        let off = (value - expected.value).abs();
                        assert!(off <= 1e-14 * expected.scale, "{n}, {start}: {off:e}");
                    }
                    for (sum, expected, at_most) in [
                        (sums.scale, expected.scale, 1.18),
                        (sums.q_slope, expected.q_slope, 1.09),
                        (sums.p_slope, expected.p_slope, 1.09),
                        (sums.q_slope_squared, expected.q_slope_squared, 1.0),
                        (sums.p_slope_squared, expected.p_slope_squared, 1.0),
                        (sums.q_power, expected.q_power, 1.0),
                        (sums.p_power, expected.p_power, 1.0),
                    ] {
                        let most = expected * at_most * (1.0 + 1e-14);
                        let bounded = (expected * (1.0 - 1e-14)..=most).contains(&sum);
                        assert!(bounded, "{n}, {start}: {sum}, not {expected}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_folded_transform_is_twice_that_of_every_second_sample() {
        let n = 48;
        let samples = transform(n);
        let slow = |samples: &[Complex64], k: usize| -> Complex64 {
            let angle = -std::f64::consts::TAU * k as f64 / samples.len() as f64;
            (samples.iter().enumerate())
                .map(|(j, z)| z * Complex64::cis(angle * j as f64))
                .sum()
        };
        let mut z: Vec<Complex64> = (0..n).map(|k| slow(&samples, k)).collect();
        let second: Vec<Complex64> = samples.iter().step_by(2).copied().collect();
        let folded = fold(&mut z);
        assert_eq!(folded.len(), n / 2);
        for (k, mode) in folded.iter().enumerate() {
            assert!((mode / 2.0 - slow(&second, k)).norm() < 1e-12);
        }
    }

    #[test]
    fn equal_rows_enclose_no_area_to_the_last_bit() {
        for n in [50_usize, 64, 999] {
            // Modes of q + i q.
            let z: Vec<Complex64> = (0..n)
                .map(|k| {
                    let [k, mirrored] = [k, (n - k) % n].map(|k| (1.3 * (k * k) as f64).sin());
                    Complex64::new(k + mirrored, k - mirrored) * Complex64::new(1.0, 1.0)
                })
                .collect();
            let band = 1..n.div_ceil(2);
            assert_eq!(Sums::over(&z, band.clone()).value, 0.0, "{n}");
            assert_eq!(value(&z, band), 0.0, "{n}");
        }
    }

    #[test]
    fn the_bound_on_a_modulus_is_tight_to_nine_per_cent() {
        for degree in 0..360 {
            let bound =
                OUTER_OVER_INNER_OCTAGON * octagon(Complex64::cis(f64::from(degree).to_radians()));
            assert!((1.0 - 1e-15..1.0824).contains(&bound), "{degree}: {bound}");
        }
    }

    #[test]
    fn bands_add_up() {
        let z = transform(40);
        let [low, high, all] = [1..7, 7..20, 1..20].map(|band| Sums::over(&z, band));
        let sum = low + high;
        for (found, expected) in [
            (sum.value, all.value),
            (sum.scale, all.scale),
            (sum.q_slope, all.q_slope),
            (sum.p_slope, all.p_slope),
            (sum.q_slope_squared, all.q_slope_squared),
            (sum.p_slope_squared, all.p_slope_squared),
            (sum.q_power, all.q_power),
            (sum.p_power, all.p_power),
        ] {
            assert!((found - expected).abs() <= 1e-14 * expected.abs().max(all.scale * 1e-2));
        }
    }
}

//! Sums over the modes of two real rows that were transformed together, as q + i p.
//!
//! With Z the transform of q + i p, N samples, the transforms of the rows are
//!
//! Q_k = (Z_k + conj Z_{N−k})/2, P_k = (Z_k − conj Z_{N−k})/2i.
//!
//! They are taken apart before anything is multiplied: a sum of |Z_k|² would cancel.
//!
//! Sums run in four lanes, from the highest mode down (small terms first), in an order that depends
//! on N alone. No multiplication is fused with an addition, so every instruction set gives the
//! same bits.

use std::array::from_fn;
use std::ops::Range;

use multiversion::multiversion;
use rustfft::num_complex::Complex64;

use super::row::larger;

/// Partial sums that run beside each other: a vector register of AVX2.
const LANES: usize = 4;

type Lanes = [f64; LANES];

/// Sums over a range of modes k, both spectra unnormalised.
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
    /// Sums over both ranges of modes.
    pub fn and(self, lower: Sums) -> Sums {
        Sums {
            value: self.value + lower.value,
            scale: self.scale + lower.scale,
            q_slope: self.q_slope + lower.q_slope,
            p_slope: self.p_slope + lower.p_slope,
            q_slope_squared: self.q_slope_squared + lower.q_slope_squared,
            p_slope_squared: self.p_slope_squared + lower.p_slope_squared,
            q_power: self.q_power + lower.q_power,
            p_power: self.p_power + lower.p_power,
        }
    }
}

/// Groups that are taken apart at a time: they stay in the innermost cache.
const GROUPS: usize = 16;

/// Modes of q and p in groups of four, the highest group first, real and imaginary parts apart.
struct Apart {
    q_re: [Lanes; GROUPS],
    q_im: [Lanes; GROUPS],
    p_re: [Lanes; GROUPS],
    p_im: [Lanes; GROUPS],
}

impl Apart {
    const EMPTY: Self = Apart {
        q_re: [[0.0; LANES]; GROUPS],
        q_im: [[0.0; LANES]; GROUPS],
        p_re: [[0.0; LANES]; GROUPS],
        p_im: [[0.0; LANES]; GROUPS],
    };

    /// Takes group `i` apart from modes of q + i p and, highest k first, the modes N − k.
    #[inline(always)]
    fn take(&mut self, i: usize, modes: &[Complex64; LANES], mirrored: &[Complex64; LANES]) {
        let pair = |lane: usize| (modes[lane], mirrored[LANES - 1 - lane]);
        let each = |part: fn(Complex64, Complex64) -> f64| -> Lanes {
            from_fn(|lane| 0.5 * part(pair(lane).0, pair(lane).1))
        };
        self.q_re[i] = each(|a, b| a.re + b.re);
        self.q_im[i] = each(|a, b| a.im - b.im);
        self.p_re[i] = each(|a, b| a.im + b.im);
        self.p_im[i] = each(|a, b| b.re - a.re);
    }
}

/// Sums that run in lanes.
trait Accumulate {
    /// Adds the first `groups` groups of `apart`, whose first holds the modes from `first` on.
    fn add(&mut self, apart: &Apart, groups: usize, first: usize);
}

/// Adds the modes of `range`, four at a time from the highest down. Of the last group, lanes beyond the
/// range are zeros.
#[inline(always)]
fn accumulate(z: &[Complex64], range: Range<usize>, sums: &mut impl Accumulate) {
    let n = z.len();
    let modes = &z[range.clone()];
    let mirrored = &z[n + 1 - range.end..n + 1 - range.start];
    let (rest, groups) = modes.as_rchunks::<LANES>();
    let (mirrored_groups, mirrored_rest) = mirrored.as_chunks::<LANES>();
    let mut apart = Apart::EMPTY;
    let mut end = range.end;
    let chunks = groups.rchunks(GROUPS).zip(mirrored_groups.chunks(GROUPS));
    for (modes, mirrored) in chunks {
        for (i, (modes, mirrored)) in modes.iter().rev().zip(mirrored).enumerate() {
            apart.take(i, modes, mirrored);
        }
        sums.add(&apart, modes.len(), end - LANES);
        end -= modes.len() * LANES;
    }
    if !rest.is_empty() {
        let mut modes = [Complex64::ZERO; LANES];
        let mut mirrored = [Complex64::ZERO; LANES];
        modes[..rest.len()].copy_from_slice(rest);
        mirrored[LANES - rest.len()..].copy_from_slice(mirrored_rest);
        apart.take(0, &modes, &mirrored);
        sums.add(&apart, 1, range.start);
    }
}

/// [`Sums`], each in lanes.
#[derive(Default)]
struct SumsInLanes {
    value: Lanes,
    scale: Lanes,
    q_slope: Lanes,
    p_slope: Lanes,
    q_slope_squared: Lanes,
    p_slope_squared: Lanes,
    q_power: Lanes,
    p_power: Lanes,
}

impl Accumulate for SumsInLanes {
    #[inline(always)]
    fn add(&mut self, apart: &Apart, groups: usize, first: usize) {
        for i in 0..groups.min(GROUPS) {
            let (q_re, q_im) = (&apart.q_re[i], &apart.q_im[i]);
            let (p_re, p_im) = (&apart.p_re[i], &apart.p_im[i]);
            for j in 0..LANES {
                let k = (first - i * LANES + j) as f64;
                let q_size = modulus_bound(q_re[j], q_im[j]);
                let p_size = modulus_bound(p_re[j], p_im[j]);
                let q_squared = q_re[j] * q_re[j] + q_im[j] * q_im[j];
                let p_squared = p_re[j] * p_re[j] + p_im[j] * p_im[j];
                self.value[j] += k * (p_im[j] * q_re[j] - p_re[j] * q_im[j]);
                self.scale[j] += k * (p_size * q_size);
                self.q_slope[j] += k * q_size;
                self.p_slope[j] += k * p_size;
                self.q_slope_squared[j] += k * k * q_squared;
                self.p_slope_squared[j] += k * k * p_squared;
                self.q_power[j] += q_squared;
                self.p_power[j] += p_squared;
            }
        }
    }
}

/// [`Sums::value`] alone, in lanes.
#[derive(Default)]
struct ValueInLanes(Lanes);

impl Accumulate for ValueInLanes {
    #[inline(always)]
    fn add(&mut self, apart: &Apart, groups: usize, first: usize) {
        for i in 0..groups.min(GROUPS) {
            let (q_re, q_im) = (&apart.q_re[i], &apart.q_im[i]);
            let (p_re, p_im) = (&apart.p_re[i], &apart.p_im[i]);
            for j in 0..LANES {
                let k = (first - i * LANES + j) as f64;
                self.0[j] += k * (p_im[j] * q_re[j] - p_re[j] * q_im[j]);
            }
        }
    }
}

/// All sums over the modes of `range`, which lies within 1 … ⌈N/2⌉ − 1.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn sums(z: &[Complex64], range: Range<usize>) -> Sums {
    let mut sums = SumsInLanes::default();
    accumulate(z, range, &mut sums);
    Sums {
        value: total(sums.value),
        scale: total(sums.scale),
        q_slope: total(sums.q_slope),
        p_slope: total(sums.p_slope),
        q_slope_squared: total(sums.q_slope_squared),
        p_slope_squared: total(sums.p_slope_squared),
        q_power: total(sums.q_power),
        p_power: total(sums.p_power),
    }
}

/// [`Sums::value`] alone.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn value(z: &[Complex64], range: Range<usize>) -> f64 {
    let mut value = ValueInLanes::default();
    accumulate(z, range, &mut value);
    total(value.0)
}

/// Turns the transform of an even number of samples into that of every second one.
///
/// Modes k and k + N/2 fold together; `z` is twice too large then, and its upper half is left over.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn fold(z: &mut [Complex64]) -> &mut [Complex64] {
    let (lower, upper) = z.split_at_mut(z.len() / 2);
    for (low, high) in lower.iter_mut().zip(&*upper) {
        *low += high;
    }
    lower
}

/// A bound on √(x² + y²) that is at most 8.3 per cent above it: a regular octagon round the unit circle.
///
/// Without a root, which would take longer than all else that is done to a mode.
#[inline(always)]
fn modulus_bound(x: f64, y: f64) -> f64 {
    /// 1/cos(π/8): from the octagon in the circle to the one round it.
    const OUTWARDS: f64 = 1.082_392_200_292_394;
    let (x, y) = (x.abs(), y.abs());
    let diagonal = std::f64::consts::FRAC_1_SQRT_2 * (x + y);
    OUTWARDS * larger(diagonal, larger(x, y))
}

/// Adds the lanes, nearest first.
fn total(lanes: Lanes) -> f64 {
    let [a, b, c, d] = lanes;
    (a + b) + (c + d)
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

    /// P_k and Q_k by their definition.
    fn modes(z: &[Complex64], k: usize) -> (Complex64, Complex64) {
        let mirrored = z[z.len() - k].conj();
        let q = (z[k] + mirrored) / 2.0;
        let p = (z[k] - mirrored) / Complex64::new(0.0, 2.0);
        (q, p)
    }

    #[test]
    fn sums_are_those_of_the_definition_over_any_range() {
        for n in 3..80 {
            let z = transform(n);
            let end = n.div_ceil(2);
            for start in 1..end {
                let sums = sums(&z, start..end);
                let mut expected = Sums::default();
                for k in start..end {
                    let ((q, p), k) = (modes(&z, k), k as f64);
                    expected = expected.and(Sums {
                        value: k * (p * q.conj()).im,
                        scale: k * p.norm() * q.norm(),
                        q_slope: k * q.norm(),
                        p_slope: k * p.norm(),
                        q_slope_squared: k * k * q.norm_sqr(),
                        p_slope_squared: k * k * p.norm_sqr(),
                        q_power: q.norm_sqr(),
                        p_power: p.norm_sqr(),
                    });
                }
                let close = |a: f64, b: f64, scale: f64| (a - b).abs() <= 1e-14 * scale;
                let bound = |a: f64, b: f64, by: f64| a >= b * (1.0 - 1e-14) && a <= by * b;
                assert!(close(sums.value, expected.value, expected.scale), "{n}");
                assert_eq!(sums.value, value(&z, start..end));
                assert!(bound(sums.scale, expected.scale, 1.18));
                assert!(bound(sums.q_slope, expected.q_slope, 1.09));
                assert!(bound(sums.p_slope, expected.p_slope, 1.09));
                for (sum, expected) in [
                    (sums.q_slope_squared, expected.q_slope_squared),
                    (sums.p_slope_squared, expected.p_slope_squared),
                    (sums.q_power, expected.q_power),
                    (sums.p_power, expected.p_power),
                ] {
                    assert!(close(sum, expected, expected), "{n}: {sum} {expected}");
                }
            }
        }
    }

    #[test]
    fn the_bound_on_a_modulus_is_tight_to_nine_per_cent() {
        for degree in 0..360 {
            let (y, x) = f64::from(degree).to_radians().sin_cos();
            let bound = modulus_bound(x, y);
            assert!((1.0 - 1e-15..1.0824).contains(&bound), "{degree}: {bound}");
        }
    }

    #[test]
    fn a_folded_transform_is_twice_that_of_every_second_sample() {
        let n = 12;
        let samples = transform(n);
        let slow = |samples: &[Complex64], k: usize| -> Complex64 {
            let turn = std::f64::consts::TAU * k as f64 / samples.len() as f64;
            (samples.iter().enumerate())
                .map(|(j, z)| z * Complex64::from_polar(1.0, -turn * j as f64))
                .sum()
        };
        let mut z: Vec<Complex64> = (0..n).map(|k| slow(&samples, k)).collect();
        let second: Vec<Complex64> = samples.iter().step_by(2).copied().collect();
        for (k, folded) in fold(&mut z).iter().enumerate() {
            assert!((folded / 2.0 - slow(&second, k)).norm() < 1e-13);
        }
    }
}

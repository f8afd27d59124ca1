//! Sums over the modes of two real rows that were transformed together, as q + i p.
//!
//! With Z the transform of q + i p, N samples, the transforms of the rows are
//!
//! Q_k = (Z_k + conj Z_{N−k})/2, P_k = (Z_k − conj Z_{N−k})/2i.
//!
//! They are taken apart before anything is multiplied: a sum of |Z_k|² would cancel.
//!
//! Sums run in eight lanes, from the highest mode down (small terms first) within each class of modes, in an
//! order that depends on N and the classes alone. No multiplication is fused with an addition, so every
//! instruction set gives the same bits.

use std::array::from_fn;
use std::ops::Range;

use multiversion::multiversion;
use rustfft::num_complex::Complex64;

use super::row::larger;
use super::spectrum::Modes;

/// Partial sums that run beside each other: a vector register of AVX-512, or two of AVX2.
const LANES: usize = 8;

type Lanes = [f64; LANES];

/// Sums over all bands, both spectra unnormalised.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    /// Σ k (Im P_k Re Q_k − Re P_k Im Q_k).
    pub value: f64,
    /// Σ k |Q_k|, at most 9 per cent too large.
    pub q_slope: f64,
    /// Σ k |P_k|, at most 9 per cent too large.
    pub p_slope: f64,
    /// Σ k² |Q_k|².
    pub q_slope_squared: f64,
    /// Σ k² |P_k|².
    pub p_slope_squared: f64,
}

/// Sums over one band of modes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Band {
    /// Σ k |P_k| |Q_k|, at most 18 per cent too large.
    pub scale: f64,
    /// Σ |Q_k|².
    pub q_power: f64,
    /// Σ |P_k|².
    pub p_power: f64,
}

/// Groups that are taken apart at a time: they stay in the innermost cache.
const GROUPS: usize = 4;

/// Modes k and N − k in groups of eight, the highest k first, real and imaginary parts apart.
struct Apart {
    re: [Lanes; GROUPS],
    im: [Lanes; GROUPS],
    mirrored_re: [Lanes; GROUPS],
    mirrored_im: [Lanes; GROUPS],
}

impl Apart {
    fn empty() -> Self {
        Apart {
            re: [[0.0; LANES]; GROUPS],
            im: [[0.0; LANES]; GROUPS],
            mirrored_re: [[0.0; LANES]; GROUPS],
            mirrored_im: [[0.0; LANES]; GROUPS],
        }
    }

    /// Takes group `i` apart from modes of q + i p and, highest k first, the modes N − k.
    #[inline(always)]
    fn take(&mut self, i: usize, modes: [Complex64; LANES], mirrored: [Complex64; LANES]) {
        self.re[i] = from_fn(|lane| modes[lane].re);
        self.im[i] = from_fn(|lane| modes[lane].im);
        self.mirrored_re[i] = from_fn(|lane| mirrored[LANES - 1 - lane].re);
        self.mirrored_im[i] = from_fn(|lane| mirrored[LANES - 1 - lane].im);
    }

    /// Twice Q_k and P_k of a lane: what they are less is taken from the sums.
    #[inline(always)]
    fn twice(&self, i: usize, lane: usize) -> [Complex64; 2] {
        let (re, im) = (self.re[i][lane], self.im[i][lane]);
        let (mirrored_re, mirrored_im) = (self.mirrored_re[i][lane], self.mirrored_im[i][lane]);
        [
            Complex64::new(re + mirrored_re, im - mirrored_im),
            Complex64::new(im + mirrored_im, mirrored_re - re),
        ]
    }
}

/// Adds the modes of `range`.
#[inline(always)]
fn accumulate(modes: &impl Modes, range: Range<usize>, apart: &mut Apart, sums: &mut SumsInLanes) {
    let class_bits = modes.class_bits();
    let classes = 1 << class_bits;
    // Below, classes have too few modes in an octave to fill the lanes.
    let low_end = match classes {
        1 => range.start,
        _ => (classes * LANES).clamp(range.start, range.end),
    };
    for class in 0..classes {
        // Places of the modes k = `classes` × place + class.
        let place = |k: usize| (k.saturating_sub(class) + classes - 1) >> class_bits;
        accumulate_run(modes, class, place(low_end)..place(range.end), apart, sums);
    }
    accumulate_each(modes, range.start..low_end, apart, sums);
}

/// Adds modes of one class, eight at a time from the highest down. Of the last group, lanes beyond them
/// are zeros.
#[inline(always)]
fn accumulate_run(
    modes: &impl Modes,
    class: usize,
    places: Range<usize>,
    apart: &mut Apart,
    sums: &mut SumsInLanes,
) {
    let classes = 1 << modes.class_bits();
    let class_len = modes.modes() >> modes.class_bits();
    // Modes N − k: their class, and the place of that of k = 0.
    let (mirrored_class, origin) = match class {
        0 => (0, class_len),
        _ => (classes - class, class_len - 1),
    };
    let mut end = places.end;
    while end >= places.start + LANES {
        let groups = ((end - places.start) / LANES).min(GROUPS);
        for i in 0..groups {
            let place = end - (i + 1) * LANES;
            let mirrored_place = origin + 1 - (place + LANES);
            apart.take(
                i,
                modes.run(class, place),
                modes.run(mirrored_class, mirrored_place),
            );
        }
        sums.add(apart, groups, classes * (end - LANES) + class, classes);
        end -= groups * LANES;
    }
    if end > places.start {
        let first = classes * places.start + class;
        add_single(modes, first, classes, end - places.start, apart, sums);
    }
}

/// The same for modes that are gathered one by one.
#[inline(always)]
fn accumulate_each(
    modes: &impl Modes,
    range: Range<usize>,
    apart: &mut Apart,
    sums: &mut SumsInLanes,
) {
    let mut end = range.end;
    while end > range.start {
        let start = end.saturating_sub(LANES).max(range.start);
        add_single(modes, start, 1, end - start, apart, sums);
        end = start;
    }
}

/// Adds `count` modes, eight at most, of wave numbers `first`, `first` + `step`, ….
#[inline(always)]
fn add_single(
    modes: &impl Modes,
    first: usize,
    step: usize,
    count: usize,
    apart: &mut Apart,
    sums: &mut SumsInLanes,
) {
    let mut taken = [Complex64::ZERO; LANES];
    let mut mirrored = [Complex64::ZERO; LANES];
    for lane in 0..count {
        let k = first + lane * step;
        taken[lane] = modes.mode(k);
        mirrored[LANES - 1 - lane] = modes.mode(modes.modes() - k);
    }
    apart.take(0, taken, mirrored);
    sums.add(apart, 1, first, step);
}

/// Wave numbers of a group, and how far those of the next lie below.
#[inline(always)]
fn wave_numbers(first: usize, step: usize) -> (Lanes, f64) {
    let (first, step) = (first as f64, step as f64);
    (
        from_fn(|lane| first + lane as f64 * step),
        LANES as f64 * step,
    )
}

/// [`Sums`] and those of one [`Band`], each in lanes.
#[derive(Default)]
struct SumsInLanes {
    value: Lanes,
    q_slope: Lanes,
    p_slope: Lanes,
    q_slope_squared: Lanes,
    p_slope_squared: Lanes,
    band: BandInLanes,
}

#[derive(Default)]
struct BandInLanes {
    scale: Lanes,
    q_power: Lanes,
    p_power: Lanes,
}

impl SumsInLanes {
    /// Adds the first `groups` groups of `apart`. The wave numbers of the first are `first`, `first` + `step`, …;
    /// each other lies below the one before.
    #[allow(
        clippy::needless_range_loop,
        reason = "an iterator over the lanes does not become vector instructions"
    )]
    #[inline(always)]
    fn add(&mut self, apart: &Apart, groups: usize, first: usize, step: usize) {
        let (highest, down) = wave_numbers(first, step);
        for i in 0..groups.min(GROUPS) {
            for j in 0..LANES {
                let k = highest[j] - i as f64 * down;
                let [q, p] = apart.twice(i, j);
                let (q_size, p_size) = (modulus_bound(q), modulus_bound(p));
                let (q_squared, p_squared) = (q.norm_sqr(), p.norm_sqr());
                self.value[j] += k * (p.im * q.re - p.re * q.im);
                self.q_slope[j] += k * q_size;
                self.p_slope[j] += k * p_size;
                self.q_slope_squared[j] += k * k * q_squared;
                self.p_slope_squared[j] += k * k * p_squared;
                self.band.scale[j] += k * (p_size * q_size);
                self.band.q_power[j] += q_squared;
                self.band.p_power[j] += p_squared;
            }
        }
    }
}

/// All sums over the modes of bands that lie below each other, within 1 … ⌈N/2⌉ − 1: band i
/// from `edges[i + 1]` to below `edges[i]`.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
pub(super) fn sums<M: Modes>(modes: &M, edges: &[usize], bands: &mut [Band]) -> Sums {
    let mut sums = SumsInLanes::default();
    let mut apart = Apart::empty();
    for (edges, band) in edges.windows(2).zip(bands) {
        let (end, start) = (edges[0], edges[1]);
        sums.band = BandInLanes::default();
        accumulate(modes, start..end, &mut apart, &mut sums);
        *band = Band {
            scale: 0.25 * total(sums.band.scale),
            q_power: 0.25 * total(sums.band.q_power),
            p_power: 0.25 * total(sums.band.p_power),
        };
    }
    Sums {
        value: 0.25 * total(sums.value),
        q_slope: 0.5 * total(sums.q_slope),
        p_slope: 0.5 * total(sums.p_slope),
        q_slope_squared: 0.25 * total(sums.q_slope_squared),
        p_slope_squared: 0.25 * total(sums.p_slope_squared),
    }
}

/// A bound on |z| that is at most 8.3 per cent above it: a regular octagon round the unit circle.
///
/// Without a root, which would take longer than all else that is done to a mode.
#[inline(always)]
fn modulus_bound(z: Complex64) -> f64 {
    /// 1/cos(π/8): from the octagon in the circle to the one round it.
    const OUTWARDS: f64 = 1.082_392_200_292_394;
    let (x, y) = (z.re.abs(), z.im.abs());
    let diagonal = std::f64::consts::FRAC_1_SQRT_2 * (x + y);
    OUTWARDS * larger(diagonal, larger(x, y))
}

/// Adds the lanes, nearest first.
fn total(lanes: Lanes) -> f64 {
    let [a, b, c, d, e, f, g, h] = lanes;
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

#[cfg(test)]
mod tests {
    use super::super::spectrum::{Spectrum, in_classes};
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
    fn sums_are_those_of_the_definition_over_any_bands() {
        let in_order = (3..80).map(|n| (n, 1));
        for (n, classes) in in_order.chain([(64, 2), (64, 4), (96, 8), (128, 16), (200, 4)]) {
            let z = transform(n);
            let permuted = in_classes(&z, classes);
            let spectrum = Spectrum::new(&permuted, classes);
            let end = n.div_ceil(2);
            for start in 1..end {
                let middle = (start + end) / 2;
                let mut bands = [Band::default(); 2];
                let sums = sums(&spectrum, &[end, middle, start], &mut bands);
                let close = |a: f64, b: f64, scale: f64| (a - b).abs() <= 1e-14 * scale;
                let bound = |a: f64, b: f64, by: f64| a >= b * (1.0 - 1e-14) && a <= by * b;
                let (mut expected, mut scale) = (Sums::default(), 0.0);
                for (band, range) in bands.iter().zip([middle..end, start..middle]) {
                    let mut in_band = Band::default();
                    for k in range {
                        let ((q, p), k) = (modes(&z, k), k as f64);
                        in_band.scale += k * p.norm() * q.norm();
                        in_band.q_power += q.norm_sqr();
                        in_band.p_power += p.norm_sqr();
                        expected.value += k * (p * q.conj()).im;
                        expected.q_slope += k * q.norm();
                        expected.p_slope += k * p.norm();
                        expected.q_slope_squared += k * k * q.norm_sqr();
                        expected.p_slope_squared += k * k * p.norm_sqr();
                    }
                    assert!(bound(band.scale, in_band.scale, 1.18), "{n}, {classes}");
                    assert!(close(band.q_power, in_band.q_power, in_band.q_power));
                    assert!(close(band.p_power, in_band.p_power, in_band.p_power));
                    scale += in_band.scale;
                }
                assert!(close(sums.value, expected.value, scale), "{n}, {classes}");
                assert!(bound(sums.q_slope, expected.q_slope, 1.09));
                assert!(bound(sums.p_slope, expected.p_slope, 1.09));
                for (sum, expected) in [
                    (sums.q_slope_squared, expected.q_slope_squared),
                    (sums.p_slope_squared, expected.p_slope_squared),
                ] {
                    assert!(close(sum, expected, expected), "{n}: {sum} {expected}");
                }
            }
        }
    }

    #[test]
    fn the_bound_on_a_modulus_is_tight_to_nine_per_cent() {
        for degree in 0..360 {
            let bound = modulus_bound(Complex64::cis(f64::from(degree).to_radians()));
            assert!((1.0 - 1e-15..1.0824).contains(&bound), "{degree}: {bound}");
        }
    }
}

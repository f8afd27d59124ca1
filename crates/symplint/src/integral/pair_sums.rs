//! Sums over the modes of two real rows that were transformed together, as q + i p.
//!
//! With Z the transform of q + i p, N samples, the transforms of the rows are
//!
//! Q_k = (Z_k + conj Z_{N−k})/2, P_k = (Z_k − conj Z_{N−k})/2i.
//!
//! They are taken apart before anything is multiplied: a sum of |Z_k|² would cancel.
//!
//! Sums run in the lanes of a vector register, from the highest mode down (small terms first) within each class
//! of modes, in an order that depends on N, the classes and the width of registers alone. No multiplication is
//! fused with an addition: rows that are equal enclose no area, to the last bit.

use std::ops::Range;

use pulp::{Simd, WithSimd};
use rustfft::num_complex::Complex64;

use super::ahead::Ahead;
use super::spectrum::{Class, Modes, Parts};
use super::vectors::vectorised;

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

/// All sums over the modes of bands that lie below each other, within 1 … ⌈N/2⌉ − 1: band i
/// from `edges[i + 1]` to below `edges[i]`. On the way, rows of as many samples are asked for.
pub(super) fn sums(modes: &impl Modes, edges: &[usize], bands: &mut [Band], ahead: Ahead) -> Sums {
    vectorised(OverBands {
        modes,
        edges,
        bands,
        ahead,
    })
}

/// [`Sums::value`] alone.
pub(super) fn value(modes: &impl Modes, range: Range<usize>) -> f64 {
    vectorised(OverRange { modes, range })
}

struct OverBands<'a, M> {
    modes: &'a M,
    edges: &'a [usize],
    bands: &'a mut [Band],
    ahead: Ahead<'a>,
}

impl<M: Modes> WithSimd for OverBands<'_, M> {
    type Output = Sums;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> Sums {
        let mut lanes = SumsInLanes::new(simd);
        for (edges, band) in self.edges.windows(2).zip(self.bands) {
            let (end, start) = (edges[0], edges[1]);
            lanes.band = BandInLanes::new(simd);
            accumulate(simd, self.modes, start..end, &mut lanes, &mut self.ahead);
            *band = Band {
                scale: OUTWARDS * OUTWARDS * 0.25 * simd.reduce_sum_f64s(lanes.band.scale),
                q_power: 0.25 * simd.reduce_sum_f64s(lanes.band.q_power),
                p_power: 0.25 * simd.reduce_sum_f64s(lanes.band.p_power),
            };
        }
        Sums {
            value: 0.25 * simd.reduce_sum_f64s(lanes.value),
            q_slope: OUTWARDS * 0.5 * simd.reduce_sum_f64s(lanes.q_slope),
            p_slope: OUTWARDS * 0.5 * simd.reduce_sum_f64s(lanes.p_slope),
            q_slope_squared: 0.25 * simd.reduce_sum_f64s(lanes.q_slope_squared),
            p_slope_squared: 0.25 * simd.reduce_sum_f64s(lanes.p_slope_squared),
        }
    }
}

struct OverRange<'a, M> {
    modes: &'a M,
    range: Range<usize>,
}

impl<M: Modes> WithSimd for OverRange<'_, M> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let mut lanes = ValueInLanes::<S>(simd.splat_f64s(0.0));
        accumulate(
            simd,
            self.modes,
            self.range,
            &mut lanes,
            &mut Ahead::nothing(),
        );
        0.25 * simd.reduce_sum_f64s(lanes.0)
    }
}

/// Adds the modes of `range`.
#[inline(always)]
fn accumulate<S: Simd>(
    simd: S,
    modes: &impl Modes,
    range: Range<usize>,
    to: &mut impl Accumulate<S>,
    ahead: &mut Ahead,
) {
    let class_bits = modes.class_bits();
    let classes = 1 << class_bits;
    // Below, classes have too few modes in an octave to fill the lanes.
    let low_end = match classes {
        1 => range.start,
        _ => (classes * S::F64_LANES).clamp(range.start, range.end),
    };
    for class in 0..classes {
        // Places of the modes k = `classes` × place + class.
        let place = |k: usize| (k.saturating_sub(class) + classes - 1) >> class_bits;
        accumulate_class(
            simd,
            modes,
            class,
            place(low_end)..place(range.end),
            to,
            ahead,
        );
    }
    let mut end = low_end;
    while end > range.start {
        let start = end.saturating_sub(S::F64_LANES).max(range.start);
        add_single(simd, modes, start, 1, end - start, to);
        end = start;
    }
}

/// Adds modes of one class, as many at a time as there are lanes, from the highest down. Of the last, lanes
/// beyond them are zeros.
#[inline(always)]
fn accumulate_class<S: Simd>(
    simd: S,
    modes: &impl Modes,
    class: usize,
    places: Range<usize>,
    to: &mut impl Accumulate<S>,
    ahead: &mut Ahead,
) {
    let lanes = S::F64_LANES;
    let classes = 1 << modes.class_bits();
    // Modes N − k: their class, and one place more than that of k = 0.
    let class_len = modes.modes() >> modes.class_bits();
    let (mirrored, origin) = match class {
        0 => (modes.class(0), class_len + 1),
        _ => (modes.class(classes - class), class_len),
    };
    let this = modes.class(class);
    let groups = places.len() / lanes;
    let mut k = wave_numbers(
        simd,
        classes * (places.end.max(lanes) - lanes) + class,
        classes,
    );
    let down = simd.splat_f64s((classes * lanes) as f64);
    for i in 1..=groups {
        let place = places.end - i * lanes;
        let mirrored = mirrored.run(simd, origin - (place + lanes));
        // Modes k and N − k: in the end, N samples of the rows ahead.
        ahead.ask(2 * lanes);
        to.add(simd, k, Pair::apart(simd, this.run(simd, place), mirrored));
        k = simd.sub_f64s(k, down);
    }
    let rest = places.len() - groups * lanes;
    if rest > 0 {
        add_single(
            simd,
            modes,
            classes * places.start + class,
            classes,
            rest,
            to,
        );
    }
}

/// Adds `count` modes, no more than there are lanes, of wave numbers `first`, `first` + `step`, …, gathered one by
/// one.
#[inline(always)]
fn add_single<S: Simd>(
    simd: S,
    modes: &impl Modes,
    first: usize,
    step: usize,
    count: usize,
    to: &mut impl Accumulate<S>,
) {
    let lanes = S::F64_LANES;
    let [mut taken, mut mirrored] = [[Complex64::ZERO; MOST_LANES]; 2];
    for lane in 0..count {
        let k = first + lane * step;
        taken[lane] = modes.mode(k);
        mirrored[lanes - 1 - lane] = modes.mode(modes.modes() - k);
    }
    let (taken, mirrored) = (&taken[..], &mirrored[..]);
    let pair = Pair::apart(simd, taken.run(simd, 0), mirrored.run(simd, 0));
    to.add(simd, wave_numbers(simd, first, step), pair);
}

/// Lanes of a vector register at most.
const MOST_LANES: usize = 8;

/// `first`, `first` + `step`, …, in the order in which modes stand in the lanes.
#[inline(always)]
fn wave_numbers<S: Simd>(simd: S, first: usize, step: usize) -> S::f64s {
    let mut k = [Complex64::ZERO; MOST_LANES];
    for (lane, k) in k.iter_mut().enumerate() {
        k.re = (first + lane * step) as f64;
    }
    (&k[..]).run(simd, 0).re
}

/// Twice Q_k and P_k: what they are less is taken from the sums.
struct Pair<S: Simd> {
    q: Parts<S>,
    p: Parts<S>,
}

impl<S: Simd> Pair<S> {
    /// From modes of q + i p and, highest k first, the modes N − k.
    #[inline(always)]
    fn apart(simd: S, modes: Parts<S>, mirrored: Parts<S>) -> Self {
        let mirrored = mirrored.reversed();
        Pair {
            q: Parts {
                re: simd.add_f64s(modes.re, mirrored.re),
                im: simd.sub_f64s(modes.im, mirrored.im),
            },
            p: Parts {
                re: simd.add_f64s(modes.im, mirrored.im),
                im: simd.sub_f64s(mirrored.re, modes.re),
            },
        }
    }

    /// Im P_k Re Q_k − Re P_k Im Q_k, four times.
    #[inline(always)]
    fn area(&self, simd: S) -> S::f64s {
        let (q, p) = (&self.q, &self.p);
        simd.sub_f64s(simd.mul_f64s(p.im, q.re), simd.mul_f64s(p.re, q.im))
    }
}

/// Sums, each in lanes.
trait Accumulate<S: Simd> {
    /// Adds modes of wave numbers k.
    fn add(&mut self, simd: S, k: S::f64s, pair: Pair<S>);
}

struct ValueInLanes<S: Simd>(S::f64s);

impl<S: Simd> Accumulate<S> for ValueInLanes<S> {
    #[inline(always)]
    fn add(&mut self, simd: S, k: S::f64s, pair: Pair<S>) {
        add_product(simd, &mut self.0, k, pair.area(simd));
    }
}

/// [`Sums`] and those of one [`Band`].
struct SumsInLanes<S: Simd> {
    value: S::f64s,
    q_slope: S::f64s,
    p_slope: S::f64s,
    q_slope_squared: S::f64s,
    p_slope_squared: S::f64s,
    band: BandInLanes<S>,
}

struct BandInLanes<S: Simd> {
    scale: S::f64s,
    q_power: S::f64s,
    p_power: S::f64s,
}

impl<S: Simd> SumsInLanes<S> {
    #[inline(always)]
    fn new(simd: S) -> Self {
        let zero = simd.splat_f64s(0.0);
        SumsInLanes {
            value: zero,
            q_slope: zero,
            p_slope: zero,
            q_slope_squared: zero,
            p_slope_squared: zero,
            band: BandInLanes::new(simd),
        }
    }
}

impl<S: Simd> BandInLanes<S> {
    #[inline(always)]
    fn new(simd: S) -> Self {
        let zero = simd.splat_f64s(0.0);
        BandInLanes {
            scale: zero,
            q_power: zero,
            p_power: zero,
        }
    }
}

impl<S: Simd> Accumulate<S> for SumsInLanes<S> {
    #[inline(always)]
    fn add(&mut self, simd: S, k: S::f64s, pair: Pair<S>) {
        let (q_size, p_size) = (pair.q.octagon(simd), pair.p.octagon(simd));
        let (q_squared, p_squared) = (pair.q.squared(simd), pair.p.squared(simd));
        let k_squared = simd.mul_f64s(k, k);
        add_product(simd, &mut self.value, k, pair.area(simd));
        add_product(simd, &mut self.q_slope, k, q_size);
        add_product(simd, &mut self.p_slope, k, p_size);
        add_product(simd, &mut self.q_slope_squared, k_squared, q_squared);
        add_product(simd, &mut self.p_slope_squared, k_squared, p_squared);
        add_product(simd, &mut self.band.scale, k, simd.mul_f64s(p_size, q_size));
        self.band.q_power = simd.add_f64s(self.band.q_power, q_squared);
        self.band.p_power = simd.add_f64s(self.band.p_power, p_squared);
    }
}

#[inline(always)]
fn add_product<S: Simd>(simd: S, sum: &mut S::f64s, a: S::f64s, b: S::f64s) {
    *sum = simd.add_f64s(*sum, simd.mul_f64s(a, b));
}

/// 1/cos(π/8): from an octagon in a circle to the one round it.
const OUTWARDS: f64 = 1.082_392_200_292_394;

impl<S: Simd> Parts<S> {
    /// |z|².
    #[inline(always)]
    fn squared(&self, simd: S) -> S::f64s {
        simd.add_f64s(
            simd.mul_f64s(self.re, self.re),
            simd.mul_f64s(self.im, self.im),
        )
    }

    /// |z| within a factor of [`OUTWARDS`], from below: the gauge of the regular octagon round the unit circle.
    ///
    /// Without a root, which would take longer than all else that is done to a mode.
    #[inline(always)]
    fn octagon(&self, simd: S) -> S::f64s {
        let (x, y) = (simd.abs_f64s(self.re), simd.abs_f64s(self.im));
        let half_root = simd.splat_f64s(std::f64::consts::FRAC_1_SQRT_2);
        let diagonal = simd.mul_f64s(half_root, simd.add_f64s(x, y));
        simd.max_f64s(diagonal, simd.max_f64s(x, y))
    }
}

#[cfg(test)]
mod tests {
    use pulp::Scalar;

    use super::super::spectrum::{Spectrum, in_classes};
    use super::super::vectors::{on, widths};
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

    /// [`sums`] over two bands, and the same over them together, with each width of registers.
    fn at_each_width(spectrum: &Spectrum, edges: [usize; 3]) -> Vec<(Sums, [Band; 2], f64)> {
        widths()
            .into_iter()
            .map(|width| {
                let mut bands = [Band::default(); 2];
                let over_bands = OverBands {
                    modes: spectrum,
                    edges: &edges,
                    bands: &mut bands,
                    ahead: Ahead::nothing(),
                };
                let sums = on(width, over_bands);
                let over_range = OverRange {
                    modes: spectrum,
                    range: edges[2]..edges[0],
                };
                (sums, bands, on(width, over_range))
            })
            .collect()
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
                let (mut expected, mut in_bands) = (Sums::default(), [Band::default(); 2]);
                for (in_band, range) in in_bands.iter_mut().zip([middle..end, start..middle]) {
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
                }
                let scale = in_bands[0].scale + in_bands[1].scale;
                let close = |a: f64, b: f64, scale: f64| (a - b).abs() <= 1e-14 * scale;
                let bound = |a: f64, b: f64, by: f64| a >= b * (1.0 - 1e-14) && a <= by * b;
                for (sums, bands, value) in at_each_width(&spectrum, [end, middle, start]) {
                    for (band, in_band) in bands.iter().zip(&in_bands) {
                        assert!(bound(band.scale, in_band.scale, 1.18), "{n}, {classes}");
                        assert!(close(band.q_power, in_band.q_power, in_band.q_power));
                        assert!(close(band.p_power, in_band.p_power, in_band.p_power));
                    }
                    for value in [sums.value, value] {
                        assert!(close(value, expected.value, scale), "{n}, {classes}");
                    }
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
            for (sums, _, value) in at_each_width(&Spectrum::new(&z, 1), [n.div_ceil(2), 3, 1]) {
                assert_eq!((sums.value, value), (0.0, 0.0), "{n}");
            }
        }
    }

    #[test]
    fn the_bound_on_a_modulus_is_tight_to_nine_per_cent() {
        for degree in 0..360 {
            let z = Complex64::cis(f64::from(degree).to_radians());
            let parts = Parts::<Scalar> { re: z.re, im: z.im };
            let bound = OUTWARDS * parts.octagon(Scalar);
            assert!((1.0 - 1e-15..1.0824).contains(&bound), "{degree}: {bound}");
        }
    }
}

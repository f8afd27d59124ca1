//! Sums over the modes of two real rows that were transformed together, as q + i p.
//!
//! With Z the transform of q + i p, N samples, the transforms of the rows are
//!
//! Q_k = (Z_k + conj Z_{N−k})/2, P_k = (Z_k − conj Z_{N−k})/2i.
//!
//! Sums run in the lanes of a vector register, from the highest mode down (small terms first) within each class
//! of modes, in an order that depends on N, the classes and the width of registers alone.

use std::ops::Range;

use pulp::{Simd, WithSimd};
use rustfft::num_complex::Complex64;

use super::ahead::Ahead;
use super::pair_lanes::{Accumulate, Band, BandInLanes, Pair, Sums, SumsInLanes, ValueInLanes};
use super::spectrum::{Class, Modes};
use super::vectors::vectorised;

/// All sums over the modes of bands that lie below each other, within 1 … ⌈N/2⌉ − 1: band i
/// from `edges[i + 1]` to below `edges[i]`. On the way, most of the rows `ahead` is asked for.
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
            *band = lanes.band.total(simd);
        }
        lanes.total(simd)
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
        let mut lanes = ValueInLanes::new(simd);
        accumulate(
            simd,
            self.modes,
            self.range,
            &mut lanes,
            &mut Ahead::nothing(),
        );
        lanes.total(simd)
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
        // Modes k and N − k: in the end, nearly N samples of each row ahead.
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

#[cfg(test)]
mod tests {
    use super::super::spectrum::{Folded, Spectrum, in_classes};
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
    fn folded_modes_are_summed_as_others() {
        for (n, classes) in [(6, 1), (50, 1), (200, 1), (64, 2), (128, 4), (512, 16)] {
            let z = transform(n);
            let permuted = in_classes(&z, classes);
            let folded = Folded::new(Spectrum::new(&permuted, classes));
            let expected: Vec<Complex64> = (0..n / 2).map(|k| z[k] + z[k + n / 2]).collect();
            for start in 1..(n / 2).div_ceil(2) {
                let range = start..(n / 2).div_ceil(2);
                let (mut value, mut scale) = (0.0, 0.0);
                for k in range.clone() {
                    let ((q, p), k) = (modes(&expected, k), k as f64);
                    value += k * (p * q.conj()).im;
                    scale += k * p.norm() * q.norm();
                }
                for width in widths() {
                    let over_range = OverRange {
                        modes: &folded,
                        range: range.clone(),
                    };
                    let off = (on(width, over_range) - value).abs();
                    assert!(
                        off <= 1e-14 * scale,
                        "{n}, {classes}, from {start}: {off:e}"
                    );
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
}

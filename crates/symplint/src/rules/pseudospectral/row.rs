//! What is done to a row of samples before its transform.

use multiversion::multiversion;
use pulp::bytemuck::{cast_slice, cast_slice_mut};
use pulp::{Simd, WithSimd};
use rustfft::num_complex::Complex64;

use super::vectors::vectorised;

/// Where the samples of a row lie.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    first: f64,
    low: f64,
    high: f64,
}

impl Extent {
    /// The largest absolute value.
    pub fn largest(&self) -> f64 {
        self.high.max(-self.low)
    }

    fn include(&mut self, value: f64) {
        self.low = self.low.min(value);
        self.high = self.high.max(value);
    }

    /// The power of two at or below the largest distance from the first sample; 0 if all are the same.
    pub fn unit(&self) -> f64 {
        let distance = (self.high - self.first).max(self.first - self.low);
        if distance == 0.0 {
            return 0.0;
        }
        /// Sign and mantissa cut away.
        const EXPONENT: u64 = 0x7FF0_0000_0000_0000;
        // Of subnormal distances nothing is left: the smallest normal number, then.
        f64::from_bits(distance.to_bits() & EXPONENT).max(f64::MIN_POSITIVE)
    }
}

/// Writes (q − q_0)/`q_unit` + i (p − p_0)/`p_unit`, and says where the samples lie: in one go, at the speed of the
/// memory. The units are powers of two, or 0 for a constant row.
///
/// # Panics
/// If the lengths differ, or are 0.
pub(super) fn pack(packed: &mut [Complex64], rows: [&[f64]; 2], units: [f64; 2]) -> [Extent; 2] {
    vectorised(Pack::new(packed, rows, units))
}

struct Pack<'a> {
    packed: &'a mut [Complex64],
    q: Shift<'a>,
    p: Shift<'a>,
}

/// What is done to each sample of a row.
struct Shift<'a> {
    row: &'a [f64],
    first: f64,
    factor: f64,
}

impl<'a> Shift<'a> {
    fn new(row: &'a [f64], unit: f64) -> Self {
        Shift {
            row,
            first: row[0],
            factor: inverse(unit),
        }
    }

    fn of(&self, value: f64) -> f64 {
        (value - self.first) * self.factor
    }
}

impl<'a> Pack<'a> {
    fn new(packed: &'a mut [Complex64], [q, p]: [&'a [f64]; 2], units: [f64; 2]) -> Self {
        assert!(q.len() == packed.len() && p.len() == packed.len());
        Pack {
            packed,
            q: Shift::new(q, units[0]),
            p: Shift::new(p, units[1]),
        }
    }
}

impl WithSimd for Pack<'_> {
    type Output = [Extent; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [Extent; 2] {
        let Pack { packed, q, p } = self;
        let mut q_lanes = Lanes::new(simd, &q);
        let mut p_lanes = Lanes::new(simd, &p);
        let (q_registers, q_rest) = S::as_simd_f64s(q.row);
        let (p_registers, p_rest) = S::as_simd_f64s(p.row);
        let (packed, packed_rest) = packed.split_at_mut(q_registers.len() * S::F64_LANES);
        let (packed, _) = S::as_mut_simd_f64s(cast_slice_mut(packed));
        let (packed, _) = packed.as_chunks_mut::<2>();
        for ((packed, q), p) in packed.iter_mut().zip(q_registers).zip(p_registers) {
            let (q, p) = (q_lanes.take(simd, *q), p_lanes.take(simd, *p));
            interleave::<S>(packed, q, p);
        }
        let (mut q_extent, mut p_extent) =
            (q_lanes.extent(simd, q.first), p_lanes.extent(simd, p.first));
        for ((packed, &q_value), &p_value) in packed_rest.iter_mut().zip(q_rest).zip(p_rest) {
            *packed = Complex64::new(q.of(q_value), p.of(p_value));
            q_extent.include(q_value);
            p_extent.include(p_value);
        }
        [q_extent, p_extent]
    }
}

/// A [`Shift`] and an [`Extent`], in the lanes of registers.
struct Lanes<S: Simd> {
    first: S::f64s,
    factor: S::f64s,
    low: S::f64s,
    high: S::f64s,
}

impl<S: Simd> Lanes<S> {
    #[inline(always)]
    fn new(simd: S, shift: &Shift) -> Self {
        let first = simd.splat_f64s(shift.first);
        Lanes {
            first,
            factor: simd.splat_f64s(shift.factor),
            low: first,
            high: first,
        }
    }

    #[inline(always)]
    fn take(&mut self, simd: S, values: S::f64s) -> S::f64s {
        self.low = simd.min_f64s(values, self.low);
        self.high = simd.max_f64s(values, self.high);
        simd.mul_f64s(simd.sub_f64s(values, self.first), self.factor)
    }

    #[inline(always)]
    fn extent(&self, simd: S, first: f64) -> Extent {
        Extent {
            first,
            low: simd.reduce_min_f64s(self.low),
            high: simd.reduce_max_f64s(self.high),
        }
    }
}

/// q + i p as it stands in memory.
#[inline(always)]
fn interleave<S: Simd>(packed: &mut [S::f64s; 2], q: S::f64s, p: S::f64s) {
    let (packed, _) = cast_slice_mut::<_, f64>(packed).as_chunks_mut::<2>();
    for ((packed, q), p) in (packed.iter_mut())
        .zip(cast_slice::<_, f64>(&[q]))
        .zip(cast_slice::<_, f64>(&[p]))
    {
        *packed = [*q, *p];
    }
}

/// Exact for powers of two; of a constant row nothing but zeros is multiplied by it.
#[inline(always)]
fn inverse(unit: f64) -> f64 {
    if unit == 0.0 { 1.0 } else { 1.0 / unit }
}

/// Whether neighbouring samples of a position, round the loop, lie about half a period apart or more
/// somewhere. Where they do not, [`unwrap_row`](crate::unwrap_row) would change nothing. A period of 0 means
/// not periodic.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
pub(super) fn wraps(row: &[f64], period: f64) -> bool {
    if period == 0.0 {
        return false;
    }
    // A little less than half, for the rounding of the division there.
    let limit = 0.499 * period;
    let closing = row[0] - row[row.len() - 1];
    row.iter()
        .zip(&row[1..])
        .fold(closing.abs() > limit, |wraps, (a, b)| {
            wraps | ((b - a).abs() > limit)
        })
}

#[cfg(test)]
mod tests {
    use super::super::vectors::{on, widths};
    use super::*;

    /// What [`pack`] makes of two rows, with each width of registers.
    fn at_each_width(rows: [&[f64]; 2], units: [f64; 2]) -> Vec<(Vec<Complex64>, [Extent; 2])> {
        widths()
            .into_iter()
            .map(|width| {
                let mut packed = vec![Complex64::ZERO; rows[0].len()];
                let extents = on(width, Pack::new(&mut packed, rows, units));
                (packed, extents)
            })
            .collect()
    }

    #[test]
    fn rows_are_packed_and_measured_at_every_length() {
        for n in 1..70 {
            let row = |slope: f64| -> Vec<f64> {
                let at = |k: usize| (slope * k as f64 + n as f64).sin();
                (0..n).map(at).collect()
            };
            let (q, p) = (row(1.7), row(2.9));
            for (packed, extents) in at_each_width([&q, &p], [0.25, 2.0]) {
                for (k, z) in packed.iter().enumerate() {
                    assert_eq!(z.re, 4.0 * (q[k] - q[0]), "N = {n}");
                    assert_eq!(z.im, 0.5 * (p[k] - p[0]), "N = {n}");
                }
                for (extent, row) in extents.iter().zip([&q, &p]) {
                    let most = |f: fn(f64, f64) -> f64| {
                        row.iter().fold(0.0, |m: f64, &v| m.max(f(v, row[0])))
                    };
                    assert_eq!(extent.largest(), most(|v, _| v.abs()), "N = {n}");
                    let (unit, distance) = (extent.unit(), most(|v, first| (v - first).abs()));
                    assert!(unit <= distance && distance < 2.0 * unit || n == 1 && unit == 0.0);
                    assert!(unit == 0.0 || unit.log2().fract() == 0.0);
                }
            }
        }
    }

    #[test]
    fn units_reach_from_the_smallest_to_the_largest_number() {
        for size in [5e-324, 1e-310, f64::MIN_POSITIVE, 1.0, 1e300] {
            let rows: [&[f64]; 2] = [&[0.0, size], &[1.0, 1.0]];
            let (_, extents) = &at_each_width(rows, [1.0; 2])[0];
            let [q_unit, p_unit] = extents.map(|extent| extent.unit());
            for (packed, _) in at_each_width(rows, [q_unit, p_unit]) {
                assert_eq!(packed[1].re * q_unit, size);
                assert!(packed[1].re < 2.0);
                assert_eq!((packed[1].im, p_unit), (0.0, 0.0));
            }
        }
    }

    #[test]
    fn rows_that_do_not_wrap_are_those_that_unwrapping_leaves_alone() {
        let period = 3.0;
        for n in 3..40 {
            for step in [0.1, 1.4, 1.496, 1.5, 1.6, 2.9] {
                let mut row: Vec<f64> = (0..n).map(|k| (step * k as f64) % period).collect();
                row[n - 1] = row[0];
                let before = row.clone();
                let wrapped = wraps(&row, period);
                let winding = crate::signal::unwrap_row(&mut row, period);
                assert!(wrapped || (row == before && winding == 0), "{n}, {step}");
            }
        }
        assert!(!wraps(&[0.0, 1e9, -1e9], 0.0));
        assert!(wraps(&[0.0, 0.4, 0.8], 1.0), "the closing cell counts");
    }
}

//! What is done to a row of samples before its transform.

use std::array::from_fn;

use multiversion::multiversion;
use rustfft::num_complex::Complex64;

/// Values in a vector register of AVX-512.
const LANES: usize = 8;

/// Where the samples of a row lie.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    first: f64,
    low: f64,
    high: f64,
}

impl Extent {
    /// Of a row that is not empty.
    pub fn of(row: &[f64]) -> Self {
        let (low, high) = low_and_high(row);
        Extent {
            first: row[0],
            low,
            high,
        }
    }

    /// The largest absolute value.
    pub fn largest(&self) -> f64 {
        larger(-self.low, self.high)
    }

    /// The power of two at or below the largest distance from the first sample; 0 if all are the same.
    pub fn unit(&self) -> f64 {
        let distance = larger(self.high - self.first, self.first - self.low);
        if distance == 0.0 {
            return 0.0;
        }
        /// Sign and mantissa cut away.
        const EXPONENT: u64 = 0x7FF0_0000_0000_0000;
        // Of subnormal distances nothing is left: the smallest normal number, then.
        f64::from_bits(distance.to_bits() & EXPONENT).max(f64::MIN_POSITIVE)
    }
}

/// In one go, at the speed of the memory. Two registers for either bound, so that neither waits for itself; with
/// names, since arrays of them would stay in memory.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn low_and_high(row: &[f64]) -> (f64, f64) {
    let (chunks, rest) = row.as_chunks::<{ 2 * LANES }>();
    let [mut low, mut other_low, mut high, mut other_high] = [[row[0]; LANES]; 4];
    for chunk in chunks {
        let (values, other_values) = chunk.split_at(LANES);
        low = each(low, values, smaller);
        high = each(high, values, larger);
        other_low = each(other_low, other_values, smaller);
        other_high = each(other_high, other_values, larger);
    }
    let (low, high) = (
        each(low, &other_low, smaller),
        each(high, &other_high, larger),
    );
    let mut bounds = (low[0], high[0]);
    for &value in low.iter().chain(&high).chain(rest) {
        bounds = (smaller(value, bounds.0), larger(value, bounds.1));
    }
    bounds
}

#[inline(always)]
fn each(chosen: [f64; LANES], values: &[f64], choose: fn(f64, f64) -> f64) -> [f64; LANES] {
    from_fn(|lane| choose(values[lane], chosen[lane]))
}

/// The smaller of two numbers, in one instruction.
#[inline(always)]
fn smaller(x: f64, y: f64) -> f64 {
    if x < y { x } else { y }
}

/// The larger of two numbers, in one instruction.
#[inline(always)]
pub(super) fn larger(x: f64, y: f64) -> f64 {
    if x > y { x } else { y }
}

/// Writes (q − q_0)/`q_unit` + i (p − p_0)/`p_unit`; the units are powers of two, or 0 for a constant row.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
pub(super) fn pack(packed: &mut [Complex64], q: &[f64], q_unit: f64, p: &[f64], p_unit: f64) {
    let (q_first, p_first) = (q[0], p[0]);
    let (q_factor, p_factor) = (inverse(q_unit), inverse(p_unit));
    for ((z, q), p) in packed.iter_mut().zip(q).zip(p) {
        *z = Complex64::new((q - q_first) * q_factor, (p - p_first) * p_factor);
    }
}

/// Exact for powers of two; of a constant row nothing but zeros is multiplied by it.
#[inline(always)]
fn inverse(unit: f64) -> f64 {
    if unit == 0.0 { 1.0 } else { 1.0 / unit }
}

/// Whether neighbouring samples of a position, round the loop, lie about half a period apart or more
/// somewhere. Where they do not, [`unwrap_row`](super::unwrap_row) would change nothing. A period of 0 means
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
    use super::*;

    #[test]
    fn extents_are_those_of_a_search_at_every_length() {
        for n in 1..70 {
            let row: Vec<f64> = (0..n).map(|k| (1.7 * k as f64 + n as f64).sin()).collect();
            let extent = Extent::of(&row);
            let largest = row.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            let distance = row.iter().fold(0.0, |m: f64, v| m.max((v - row[0]).abs()));
            assert_eq!(extent.largest(), largest, "N = {n}");
            let unit = extent.unit();
            assert!(unit <= distance && distance < 2.0 * unit || n == 1 && unit == 0.0);
            assert!(unit == 0.0 || unit.log2().fract() == 0.0);
        }
    }

    #[test]
    fn units_reach_from_the_smallest_to_the_largest_number() {
        for size in [5e-324, 1e-310, f64::MIN_POSITIVE, 1.0, 1e300] {
            let mut packed = [Complex64::ZERO; 2];
            let (q, p) = ([0.0, size], [1.0, 1.0]);
            let (q_unit, p_unit) = (Extent::of(&q).unit(), Extent::of(&p).unit());
            pack(&mut packed, &q, q_unit, &p, p_unit);
            assert_eq!(packed[1].re * q_unit, size);
            assert!(packed[1].re < 2.0);
            assert_eq!((packed[1].im, p_unit), (0.0, 0.0));
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
                let winding = super::super::unwrap_row(&mut row, period);
                assert!(wrapped || (row == before && winding == 0), "{n}, {step}");
            }
        }
        assert!(!wraps(&[0.0, 1e9, -1e9], 0.0));
        assert!(wraps(&[0.0, 0.4, 0.8], 1.0), "the closing cell counts");
    }
}

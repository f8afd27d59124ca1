//! Preparation of the rows of a degree of freedom for their transform.

use multiversion::multiversion;
use symplint_fft::Complex64;

/// A row is transformed as (x − `first`)/`unit`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scaling {
    pub first: f64,
    /// The power of two at or below the largest distance from the first sample; 0 if all are the same.
    pub unit: f64,
    /// The largest absolute value.
    pub largest: f64,
}

impl Scaling {
    /// # Panics
    /// If the row is empty.
    pub fn of(row: &[f64]) -> Self {
        /// Sign and mantissa cut away.
        const EXPONENT: u64 = 0x7FF0_0000_0000_0000;
        let [largest, distance] = sizes(row);
        let unit = match distance {
            0.0 => 0.0,
            // Of subnormal distances nothing is left: the smallest normal number, then.
            _ => f64::from_bits(distance.to_bits() & EXPONENT).max(f64::MIN_POSITIVE),
        };
        Scaling {
            first: row[0],
            unit,
            largest,
        }
    }

    /// Exact for powers of two; of a constant row nothing but zeros is multiplied by it.
    fn factor(&self) -> f64 {
        if self.unit == 0.0 {
            1.0
        } else {
            1.0 / self.unit
        }
    }
}

/// The largest |x| and |x − x_0|.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn sizes(row: &[f64]) -> [f64; 2] {
    // Absolute values are ordered as their bits are, and the largest integer is found in vector registers.
    let (mut largest, mut distance) = (0, 0);
    for x in row {
        largest = largest.max(x.abs().to_bits());
        distance = distance.max((x - row[0]).abs().to_bits());
    }
    [largest, distance].map(f64::from_bits)
}

/// Writes the scaled q + i p, and says how they were scaled.
///
/// # Panics
/// If the lengths differ, or are 0.
pub(super) fn pack(packed: &mut [Complex64], q: &[f64], p: &[f64]) -> [Scaling; 2] {
    let scalings = [q, p].map(Scaling::of);
    write(packed, q, p, &scalings);
    scalings
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn write(packed: &mut [Complex64], q: &[f64], p: &[f64], [of_q, of_p]: &[Scaling; 2]) {
    assert!(q.len() == packed.len() && p.len() == packed.len());
    let (q_factor, p_factor) = (of_q.factor(), of_p.factor());
    for ((z, q), p) in packed.iter_mut().zip(q).zip(p) {
        *z = Complex64::new((q - of_q.first) * q_factor, (p - of_p.first) * p_factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_packed_and_measured_at_every_length() {
        for n in 1..70 {
            let row = |slope: f64| -> Vec<f64> {
                let at = |k: usize| 3.0 * (slope * k as f64 + n as f64).sin() - 0.2;
                (0..n).map(at).collect()
            };
            let (q, p) = (row(1.7), row(2.9));
            let mut packed = vec![Complex64::ZERO; n];
            let scalings = pack(&mut packed, &q, &p);
            let units = scalings.map(|scaling| scaling.unit);
            for (k, z) in packed.iter().enumerate() {
                assert_eq!(z.re * units[0], q[k] - q[0], "N = {n}");
                assert_eq!(z.im * units[1], p[k] - p[0], "N = {n}");
            }
            for (scaling, row) in scalings.iter().zip([&q, &p]) {
                let most =
                    |f: fn(f64, f64) -> f64| row.iter().fold(0.0, |m: f64, &v| m.max(f(v, row[0])));
                assert_eq!(scaling.largest, most(|v, _| v.abs()), "N = {n}");
                let (unit, distance) = (scaling.unit, most(|v, first| (v - first).abs()));
                assert!(unit <= distance && distance < 2.0 * unit || n == 1 && unit == 0.0);
                assert!(unit == 0.0 || unit.log2().fract() == 0.0);
            }
        }
    }

    #[test]
    fn units_reach_from_the_smallest_to_the_largest_number() {
        for size in [5e-324, 1e-310, f64::MIN_POSITIVE, 1.0, 1e300] {
            let mut packed = [Complex64::ZERO; 2];
            let [of_q, of_p] = pack(&mut packed, &[0.0, size], &[1.0, 1.0]);
            assert_eq!(packed[1].re * of_q.unit, size);
            assert!(packed[1].re < 2.0);
            assert_eq!((packed[1].im, of_p.unit), (0.0, 0.0));
        }
    }
}

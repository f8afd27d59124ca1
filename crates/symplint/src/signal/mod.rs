//! One-dimensional numerics that several modules need.

mod barycentric;
mod compensated_sum;
mod digits;
mod extent;
mod largest;
mod lattice;
pub(crate) mod noise;
mod prefetch;
mod random;
mod richardson;
mod unwrap;

pub(crate) use barycentric::Barycentric;
pub(crate) use compensated_sum::{CompensatedSum, UNIT_ROUNDOFF};
pub(crate) use digits::{
    BITS_OF_SINGLE, Digits, FEW_BITS, Format, MAX_ROUNDINGS_OF_SINGLE, binary_digits,
};
pub(crate) use extent::Extent;
pub(crate) use largest::largest;
pub(crate) use lattice::Levels;
pub(crate) use prefetch::prefetch;
pub(crate) use random::{GOLDEN_RATIO, parameter, parameters, unit};
pub(crate) use richardson::extrapolate;
pub use unwrap::unwrap_row;
pub(crate) use unwrap::{Turns, nearest, wraps};

/// Numbers of one vector operation: as many as the widest register holds.
pub(crate) const LANES: usize = 8;

/// Σ a b, in lanes that do not wait for each other.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a_groups, a_rest) = a.as_chunks::<LANES>();
    let (b_groups, b_rest) = b.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for (a, b) in a_groups.iter().zip(b_groups) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let rest = a_rest.iter().zip(b_rest).map(|(a, b)| a * b);
    sums.iter().sum::<f64>() + rest.sum::<f64>()
}

/// Rounding inside a map may change a coordinate by this part of its range, more than rounding of the coordinate itself. Conventional:
/// half of the digits of double precision.
pub(crate) const MAX_RELATIVE_ROUNDING_INSIDE: f64 = 1.5e-8;

/// A defect this many times its uncertainty is significant.
///
/// Conventional. Uncertainties are estimates of systematic errors, not standard deviations: in the truth table
/// true errors exceed them by a factor of three at most.
pub(crate) const SIGNIFICANT: f64 = 10.0;

/// A defect this many times its uncertainty needs no second measurement. Conventional: significant by another factor of ten.
pub(crate) const CERTAIN: f64 = SIGNIFICANT * SIGNIFICANT;

/// A difference of more than this many times its uncertainty is not explained by it. Conventional: true errors exceed estimates by a factor
/// of three at most.
pub(crate) const UNEXPLAINED: f64 = 3.0;

/// A part of a quantity that counts as zero when quantities are compared. Conventional: three digits.
pub(crate) const NEGLIGIBLE: f64 = 1e-3;

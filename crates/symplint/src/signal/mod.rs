//! One-dimensional numerics that several modules need.

mod compensated_sum;
mod largest;
mod random;
mod unwrap;

pub(crate) use compensated_sum::{CompensatedSum, UNIT_ROUNDOFF};
pub(crate) use largest::largest;
pub(crate) use random::unit;
pub use unwrap::unwrap_row;
pub(crate) use unwrap::{nearest, wraps};

//! One-dimensional numerics that several modules need.

mod barycentric;
mod compensated_sum;
mod extent;
pub(crate) mod noise;
mod random;
mod unwrap;

pub(crate) use barycentric::Barycentric;
pub(crate) use compensated_sum::{CompensatedSum, UNIT_ROUNDOFF};
pub(crate) use extent::Extent;
pub(crate) use random::unit;
pub(crate) use unwrap::nearest;
pub use unwrap::unwrap_row;

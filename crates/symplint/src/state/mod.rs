//! States: rows of coordinates, blocks of samples, ensembles, and what coordinates mean.

mod block;
mod buffer;
mod coordinates;
mod ensemble;
mod rows;
pub mod scratch;
mod threads;

pub use block::Block;
pub use coordinates::Coordinates;
pub use ensemble::Ensemble;
pub(crate) use ensemble::*;
pub(crate) use rows::CACHE_LINE;
pub use rows::{Rows, RowsMut};
pub(crate) use threads::{each_in_parallel, in_parallel};

//! Tells whether a time-advance map is symplectic.
mod block;
mod coordinates;
mod ensemble;
mod error;
pub mod map;
mod rows;
pub mod scratch;

pub use block::Block;
pub use coordinates::Coordinates;
pub use ensemble::Ensemble;
pub use error::Error;
pub use map::{PerSample, StepFailure, TimeAdvance};
pub use rows::{Rows, RowsMut};

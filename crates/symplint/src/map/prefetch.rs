//! States that will be advanced, known beforehand.

use crate::state::Block;

/// A map that can begin to advance states before they are asked for: one that sends them to other processes or
/// machines, which would be idle meanwhile.
///
/// The diagnostic tells of states as soon as it is sure to ask for them: samples of the same loop for all step sizes, those of
/// all random loops. They are asked for later by [`advance`](super::TimeAdvance::advance), in the same blocks.
pub trait Prefetch: Sync {
    /// The states of `block` will be advanced by a step of size `h`.
    fn begin(&self, h: f64, block: &Block<'_>);
}

//! Closed loops of initial states γ(s), s in [0, 1).

mod circle;
mod closed;
mod fourier;
mod sampled;
mod sampling;
mod turn;

pub use circle::{Circle, Phases};
pub(crate) use closed::check_closed;
pub use fourier::FourierLoop;
pub use sampled::SampledLoop;
pub(crate) use sampling::sample_block;

use crate::state::Block;

/// A few samples: they tell the ranges of a loop to two digits for a few Fourier modes, and how it winds. Every loop that is resolved has as
/// many, if the budget and memory allow them.
pub(crate) const FEW_SAMPLES: usize = 64;

/// The most samples of automatic doubling.
pub(crate) const MAX_SAMPLES_OF_DOUBLING: usize = 1 << 16;

/// A closed curve in phase space that can be sampled at any s.
///
/// s runs once round the loop in [0, 1); the loop is periodic in s, except that a
/// periodic position may gain whole periods in one turn.
pub trait Loop: Send + Sync {
    /// Degrees of freedom of the phase space.
    fn dof(&self) -> usize;

    /// Writes γ(`s[k]`) into sample k of `block`.
    ///
    /// `s` and `block` have the same length. The state written for one sample must not
    /// depend on the others.
    fn sample(&self, s: &[f64], block: &mut Block<'_>);

    /// Evaluations of the map that were made to choose the loop, as by [`balanced_radii`](crate::map::balanced_radii). A report counts
    /// them in addition to its budget. By default there are 0.
    fn evaluations(&self) -> usize {
        0
    }
}

macro_rules! forward_loop {
    ($($pointer:ty),*) => {$(
        impl<L: Loop + ?Sized> Loop for $pointer {
            fn dof(&self) -> usize {
                (**self).dof()
            }
            fn sample(&self, s: &[f64], block: &mut Block<'_>) {
                (**self).sample(s, block);
            }
            fn evaluations(&self) -> usize {
                (**self).evaluations()
            }
        }
    )*};
}
forward_loop!(&L, Box<L>, std::sync::Arc<L>);

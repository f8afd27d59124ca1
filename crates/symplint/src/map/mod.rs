//! Time-advance maps Φ_h: what is tested.

mod capabilities;
mod closures;
mod constraint;
mod count;
mod evaluator;
mod grain;
mod image_loop;
mod loop_size;
mod notes;
mod one_form;
mod prefetch;
mod repeat;
mod substeps;
mod tangent;
mod witnesses;

pub use capabilities::{Capabilities, Difference, Differences, Energy, Question, Reversal};
pub use closures::{PerBlock, PerSample, StepOutcome};
pub use constraint::{Constraint, ProjectedLoop};
pub(crate) use count::EvaluationCount;
pub(crate) use evaluator::{Evaluator, states_at};
pub(crate) use grain::{Grain, SamplesBefore};
pub(crate) use image_loop::ImageLoop;
pub(crate) use loop_size::{ActionGroup, LoopSize};
pub use loop_size::{BalancedRadii, balanced_radii};
pub(crate) use notes::Feature;
pub use one_form::{NonCanonical, OneForm};
pub use prefetch::Prefetch;
pub use repeat::Repeat;
pub use substeps::{Parts, Substeps};
pub use tangent::TangentMap;
pub(crate) use witnesses::Witnesses;

use crate::state::Block;

/// A map from states to states that advances by one step of size h.
///
/// Implement this for blocks of samples; a map that takes one state at a time is
/// wrapped by [`PerSample`]. The map must treat each sample by itself: what it does to
/// one must not depend on the others of the block nor on what was advanced before.
///
/// ```
/// use symplint::{Block, StepFailure, TimeAdvance};
///
/// /// A unit mass on a unit spring, q advanced first (symplectic Euler).
/// struct Spring;
///
/// impl TimeAdvance for Spring {
///     fn dof(&self) -> usize {
///         1
///     }
///     fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
///         for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row_mut(0)) {
///             *q += h * *p;
///             *p -= h * *q;
///         }
///         Ok(())
///     }
/// }
/// ```
pub trait TimeAdvance: Send + Sync {
    /// Degrees of freedom d: the map acts on R^2d.
    fn dof(&self) -> usize;

    /// Advances every sample of `block` by one step of size `h`, in place.
    ///
    /// # Errors
    /// A step that cannot be taken (a solver that does not converge, say) names the
    /// sample of the block and the reason. States that are not finite need not be
    /// looked for: the diagnostic checks.
    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure>;

    /// Capabilities besides, and the meaning of the coordinates. By default nothing is periodic, all momenta are canonical, and the
    /// map has a step and nothing else.
    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities::plain(self.dof())
    }
}

/// Why a map could not advance a sample.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("sample {sample} of the block: {reason}")]
pub struct StepFailure {
    /// Column of the block.
    pub sample: usize,
    /// What went wrong, as the map says it.
    pub reason: String,
}

macro_rules! forward_time_advance {
    ($($pointer:ty),*) => {$(
        impl<M: TimeAdvance + ?Sized> TimeAdvance for $pointer {
            fn dof(&self) -> usize {
                (**self).dof()
            }
            fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
                (**self).advance(h, block)
            }
            fn capabilities(&self) -> Capabilities<'_> {
                (**self).capabilities()
            }
        }
    )*};
}
forward_time_advance!(&M, Box<M>, std::sync::Arc<M>);

//! Time-advance maps Φ_h: what is tested.

mod closures;
mod constraint;
mod evaluator;
mod grain;
mod image_loop;
mod loop_size;
mod one_form;
mod prefetch;
mod repeat;
mod tangent;
mod witnesses;

pub use closures::{PerBlock, PerSample, StepOutcome};
pub use constraint::{Constraint, ProjectedLoop};
pub(crate) use evaluator::{EvaluationCount, Evaluator, Feature, states_at};
pub(crate) use grain::{Before, Grain};
pub(crate) use image_loop::ImageLoop;
pub(crate) use loop_size::{ActionGroup, LoopSize};
pub use loop_size::{BalancedRadii, balanced_radii};
pub use one_form::{NonCanonical, OneForm};
pub use prefetch::Prefetch;
pub use repeat::Repeat;
pub use tangent::TangentMap;
pub(crate) use witnesses::Witnesses;

#[cfg(doc)]
use crate::error::Error;
use crate::loops::Loop;
use crate::state::{Block, Coordinates, Ensemble, Rows};

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

    /// Advances as [`advance`](Self::advance) does, and says whether all states are finite then. By
    /// default it looks afterwards; a map that has every state at hand anyway saves a pass over
    /// memory. "Finite" is taken on trust, the other answer is not.
    ///
    /// # Errors
    /// As those of [`advance`](Self::advance).
    fn advance_and_look(&self, h: f64, block: &mut Block<'_>) -> Result<bool, StepFailure> {
        self.advance(h, block)?;
        Ok(block.all_finite())
    }

    /// Samples that [`advance`](Self::advance) is given at once, at most. By default a block fits into the cache of a
    /// core. A map whose calls are expensive, because they go through another language or start a program, takes more.
    /// What happens to a sample does not depend on it.
    fn block_width(&self) -> usize {
        Ensemble::block_width(self.dof())
    }

    /// Number of substeps, for a step that is a composition of maps of phase space, such as
    /// the drifts and kicks of a splitting method. By default the step is one whole.
    fn substeps(&self) -> usize {
        1
    }

    /// Takes one substep of a step of size `h`: all of them, 0 first, are what
    /// [`advance`](Self::advance) does, to the last bit.
    ///
    /// # Errors
    /// As those of [`advance`](Self::advance).
    fn advance_substep(
        &self,
        substep: usize,
        h: f64,
        block: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        assert_eq!(substep, 0, "the step is one whole");
        self.advance(h, block)
    }

    /// What a substep is called where a report speaks of it: `kick of 0.5 h`, say.
    fn substep_name(&self, substep: usize) -> String {
        format!("part {}", substep + 1)
    }

    /// Where a step of size `h` breaks or bends a loop, as far as the map can tell beforehand: loop
    /// parameters s in [0, 1), in any order. None by default.
    ///
    /// The piecewise rule begins to look there, which saves evaluations. It needs none of them, trusts
    /// none, and looks elsewhere as well.
    fn known_breaks(&self, phase_loop: &dyn Loop, h: f64) -> Vec<f64> {
        let _ = (phase_loop, h);
        Vec::new()
    }

    /// Which coordinates are periodic, what makes momenta canonical, and where the grid is.
    fn coordinates(&self) -> Coordinates {
        Coordinates::plain(self.dof())
    }

    /// Whether to end the diagnosis, because the user asked for it, say: it then ends with [`Error::Stopped`] before the next
    /// evaluation. Unlike a [`StepFailure`], which leaves out the loop or the step size where it happened.
    fn is_stopped(&self) -> bool {
        false
    }

    /// How the map gets states before they are requested, if it makes use of that.
    fn prefetch(&self) -> Option<&dyn Prefetch> {
        None
    }

    /// The derivative of the step, if the map has it exactly. Without one, which is the default,
    /// derivatives are central differences.
    fn tangent(&self) -> Option<&dyn TangentMap> {
        None
    }

    /// The manifold on which the map acts, if there is one: with rods of fixed length, say. By default it acts on all of
    /// phase space.
    fn constraint(&self) -> Option<&dyn Constraint> {
        None
    }

    /// A function that gives the energy of states, in any unit, or another number that a step may conserve. The diagnosis tells
    /// whether it does. `None` by default.
    fn energy(&self) -> Option<Energy<'_>> {
        None
    }
}

/// A function of states that writes one number for each of them: an [`Observable`](crate::trace::Observable) that is owned. Positions
/// and momenta have d rows and one column for each state, in the coordinates that the map advances.
pub type Energy<'a> = Box<dyn Fn(Rows<'_>, Rows<'_>, &mut [f64]) + Sync + 'a>;

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
            fn advance_and_look(
                &self,
                h: f64,
                block: &mut Block<'_>,
            ) -> Result<bool, StepFailure> {
                (**self).advance_and_look(h, block)
            }
            fn block_width(&self) -> usize {
                (**self).block_width()
            }
            fn substeps(&self) -> usize {
                (**self).substeps()
            }
            fn advance_substep(
                &self,
                substep: usize,
                h: f64,
                block: &mut Block<'_>,
            ) -> Result<(), StepFailure> {
                (**self).advance_substep(substep, h, block)
            }
            fn substep_name(&self, substep: usize) -> String {
                (**self).substep_name(substep)
            }
            fn known_breaks(&self, phase_loop: &dyn Loop, h: f64) -> Vec<f64> {
                (**self).known_breaks(phase_loop, h)
            }
            fn coordinates(&self) -> Coordinates {
                (**self).coordinates()
            }
            fn is_stopped(&self) -> bool {
                (**self).is_stopped()
            }
            fn prefetch(&self) -> Option<&dyn Prefetch> {
                (**self).prefetch()
            }
            fn tangent(&self) -> Option<&dyn TangentMap> {
                (**self).tangent()
            }
            fn constraint(&self) -> Option<&dyn Constraint> {
                (**self).constraint()
            }
            fn energy(&self) -> Option<Energy<'_>> {
                (**self).energy()
            }
        }
    )*};
}
forward_time_advance!(&M, Box<M>, std::sync::Arc<M>);

//! Maps that can be undone.

use symplint::map::Repeat;
use symplint::{Block, StepFailure, TimeAdvance};

/// A map Φ_h whose inverse can be computed, up to round-off.
///
/// [`Splitting`](crate::integrators::Splitting) methods are, since each substep is. The step of an
/// explicit Runge–Kutta method is not: its inverse exists for small h, but is the solution of
/// nonlinear equations. (A step with −h is not the inverse, but the inverse of the adjoint.)
pub trait Invertible: TimeAdvance {
    /// Applies (Φ_h)^{-1} to every sample of `block`, in place.
    ///
    /// # Errors
    /// As [`TimeAdvance::advance`].
    fn advance_inverse(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure>;
}

macro_rules! forward_invertible {
    ($($pointer:ty),*) => {$(
        impl<M: Invertible + ?Sized> Invertible for $pointer {
            fn advance_inverse(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
                (**self).advance_inverse(h, block)
            }
        }
    )*};
}
forward_invertible!(&M, Box<M>, std::sync::Arc<M>);

impl<M: Invertible> Invertible for Repeat<M> {
    fn advance_inverse(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        (0..self.steps()).try_for_each(|_| self.map().advance_inverse(h, block))
    }
}

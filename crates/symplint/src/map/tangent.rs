//! Derivatives of maps along tangent vectors.

use super::StepFailure;
use crate::state::Block;

/// The tangent map of a map Φ_h: it advances states z and, with each, a tangent vector u by the
/// derivative of the step, (z, u) → (Φ_h(z), DΦ_h(z) u).
///
/// This is forward-mode differentiation: every operation of the step is followed by its derivative, and
/// no matrix is formed. [`JacobianTest`](crate::JacobianTest) then has the Jacobian to
/// round-off where differences have about 11 digits. A map says that it has one by
/// [`Capabilities::tangent`](super::Capabilities::tangent).
///
/// At jumps and kinks the derivative is that of the piece in which the state lies, so it exists almost
/// everywhere, and knows nothing of the jumps.
///
/// ```
/// use symplint::{Block, Circle, JacobianTest, StepFailure, TimeAdvance};
/// use symplint::jacobian::JacobianMethod;
/// use symplint::map::{Capabilities, TangentMap};
///
/// /// The pendulum H = p²/2 − cos q, kicked first.
/// struct Pendulum;
///
/// impl TimeAdvance for Pendulum {
///     fn dof(&self) -> usize {
///         1
///     }
///     fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
///         for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row_mut(0)) {
///             *p -= h * q.sin();
///             *q += h * *p;
///         }
///         Ok(())
///     }
///     fn capabilities(&self) -> Capabilities<'_> {
///         Capabilities { tangent: Some(self), ..Capabilities::plain(1) }
///     }
/// }
///
/// impl TangentMap for Pendulum {
///     fn advance_tangents(
///         &self,
///         h: f64,
///         states: &mut Block<'_>,
///         tangents: &mut Block<'_>,
///     ) -> Result<(), StepFailure> {
///         let pairs = tangents.q.row_mut(0).iter_mut().zip(tangents.p.row_mut(0));
///         for ((dq, dp), q) in pairs.zip(states.q.row(0)) {
///             *dp -= h * q.cos() * *dq;
///             *dq += h * *dp;
///         }
///         self.advance(h, states)
///     }
/// }
///
/// let circle = Circle::new(vec![0.3], vec![-0.2], 1.0)?;
/// let report = JacobianTest::default().run(&Pendulum, &circle, 0.5)?;
/// assert_eq!(report.method, JacobianMethod::TangentMap);
/// assert!(report.bound.unwrap() < 1e-14);
/// # Ok::<(), symplint::Error>(())
/// ```
pub trait TangentMap: Send + Sync {
    /// Advances every state, and the tangent vector in the same column of `tangents`, by one step of
    /// size `h`, in place.
    ///
    /// Both blocks have d rows and one column for each state; `tangents.q` holds the components along
    /// positions, dq, and `tangents.p` those along momenta, dp. States are advanced as
    /// [`advance`](crate::TimeAdvance::advance) leaves them, to the last bit. Columns do not
    /// depend on each other.
    ///
    /// # Errors
    /// A step that cannot be taken, as for [`advance`](crate::TimeAdvance::advance). Tangent vectors
    /// that are not finite need not be looked for.
    fn advance_tangents(
        &self,
        h: f64,
        states: &mut Block<'_>,
        tangents: &mut Block<'_>,
    ) -> Result<(), StepFailure>;
}

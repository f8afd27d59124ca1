//! Maps that act on a manifold in phase space.

use super::TimeAdvance;
use crate::loops::Loop;
use crate::state::Block;

/// The manifold on which a map acts, such as the states of rods of fixed length.
///
/// A map of constrained mechanics (SHAKE, RATTLE) is symplectic on its manifold, and takes states off the manifold onto it: there
/// it has no inverse, and conserves nothing. A map that says by [`Capabilities::constraint`](super::Capabilities::constraint) where its manifold is
/// is tested there: the states of all loops and of the [`JacobianTest`](crate::JacobianTest) are projected.
pub trait Constraint: Send + Sync {
    /// Puts every state of `block` on the manifold, in place.
    ///
    /// It is a projection: states on the manifold stay where they are, to round-off. It must be smooth near the manifold.
    /// A state that cannot be projected is set to NaN, which becomes an error.
    fn project(&self, block: &mut Block<'_>);

    /// Whether states between the substeps of a step are on the manifold, too. By default they need not be.
    fn holds_between_substeps(&self) -> bool {
        false
    }

    /// Whether the momenta of all states are the values ϑ(q) of a one-form of the positions. By default they are not.
    fn is_of_one_form(&self) -> bool {
        false
    }
}

/// A loop whose states are projected onto the manifold of a map; of a map without one, the loop itself.
///
/// ```
/// use symplint::map::ProjectedLoop;
/// use symplint::{Circle, Ensemble, PerSample};
///
/// // Two rotors on a common axis, geared together: q1 = q2 and p1 = p2.
/// let map = PerSample::new(2, |h, q, p| {
///     let q_mean = 0.5 * (q[0] + q[1]);
///     let p_mean = 0.5 * (p[0] + p[1]) - h * q_mean.sin();
///     p.fill(p_mean);
///     q.fill(q_mean + h * p_mean);
/// })
/// .with_projection(|q, p| {
///     for x in [q, p] {
///         let mean = 0.5 * (x[0] + x[1]);
///         x.fill(mean);
///     }
/// });
/// let circle = Circle::new(vec![0.3, 0.3], vec![0.0, 0.0], 0.5)?;
/// let states = Ensemble::sample(&ProjectedLoop::new(circle, &map), 16)?;
/// assert_eq!(states.q().row(0), states.q().row(1));
/// # Ok::<(), symplint::Error>(())
/// ```
pub struct ProjectedLoop<'a, L> {
    inner: L,
    constraint: Option<Box<dyn Constraint + 'a>>,
}

/// The manifold of a map that has one.
struct ProjectionMap<M>(M);

impl<M: TimeAdvance> Constraint for ProjectionMap<M> {
    fn project(&self, block: &mut Block<'_>) {
        if let Some(constraint) = self.0.capabilities().constraint {
            constraint.project(block);
        }
    }
}

impl<C: Constraint + ?Sized> Constraint for &C {
    fn project(&self, block: &mut Block<'_>) {
        (**self).project(block);
    }
}

impl<'a, L: Loop> ProjectedLoop<'a, L> {
    /// `inner` on the manifold of `map`.
    pub fn new(inner: L, map: impl TimeAdvance + 'a) -> Self {
        ProjectedLoop {
            inner,
            constraint: Some(Box::new(ProjectionMap(map))),
        }
    }

    /// `inner` on the manifold of this constraint.
    pub(crate) fn on(inner: L, constraint: Option<&'a dyn Constraint>) -> Self {
        ProjectedLoop {
            inner,
            constraint: constraint.map(|constraint| Box::new(constraint) as Box<dyn Constraint>),
        }
    }
}

impl<L: Loop> Loop for ProjectedLoop<'_, L> {
    fn dof(&self) -> usize {
        self.inner.dof()
    }

    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        self.inner.sample(s, block);
        if let Some(constraint) = &self.constraint {
            constraint.project(block);
        }
    }

    fn evaluations(&self) -> usize {
        self.inner.evaluations()
    }
}

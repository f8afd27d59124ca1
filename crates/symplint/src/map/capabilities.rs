//! Capabilities of a map besides its step.

use super::{Constraint, Prefetch, Substeps, TangentMap};
#[cfg(doc)]
use super::{StepFailure, TimeAdvance};
#[cfg(doc)]
use crate::error::Error;
use crate::state::{Block, Coordinates, Ensemble, Rows};

/// Capabilities of a map besides its step, and the meaning of its coordinates.
///
/// A map states what it has, and takes the rest from [`plain`](Self::plain):
///
/// ```
/// use std::f64::consts::TAU;
/// use symplint::map::Capabilities;
/// use symplint::{Block, Coordinates, StepFailure, TimeAdvance};
///
/// /// A pendulum, kicked first. Its angle has the period 2π.
/// struct Pendulum {
///     coordinates: Coordinates,
/// }
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
///         Capabilities {
///             coordinates: self.coordinates.clone(),
///             energy: Some(Box::new(|q, p, energies| {
///                 for (energy, (q, p)) in energies.iter_mut().zip(q.row(0).iter().zip(p.row(0))) {
///                     *energy = 0.5 * p * p - q.cos();
///                 }
///             })),
///             ..Capabilities::plain(1)
///         }
///     }
/// }
///
/// let pendulum = Pendulum { coordinates: Coordinates::plain(1).with_periods(vec![TAU])? };
/// assert!(pendulum.capabilities().energy.is_some());
/// # Ok::<(), symplint::Error>(())
/// ```
///
/// A wrapper takes those of the map inside: all of them if it takes the same step, or
/// [`for_another_step`](Self::for_another_step) if it changes the step.
pub struct Capabilities<'a> {
    /// Which coordinates are periodic, what makes momenta canonical, and how wide the cells of a grid are.
    pub coordinates: Coordinates,
    /// Samples that [`advance`](TimeAdvance::advance) is given at once, at most. A block of [`plain`](Self::plain) maps fits into the
    /// cache of a core. A map whose calls are expensive, because they go through another language or start a program, takes more.
    /// What happens to a sample does not depend on it.
    pub block_width: usize,
    /// The parts of the step, if it is a composition of maps of phase space.
    pub substeps: Option<&'a dyn Substeps>,
    /// The derivative of the step, if the map has it exactly. Without one, derivatives are central differences.
    pub tangent: Option<&'a dyn TangentMap>,
    /// The manifold on which the map acts, if there is one: with rods of fixed length, say.
    pub constraint: Option<&'a dyn Constraint>,
    /// The energy of states, in any unit, or another number that a step may conserve. The diagnosis tells whether it does.
    pub energy: Option<Energy<'a>>,
    /// The map of states ρ that reverses time: it is its own inverse, and the step is time-reversible if ρ Φ ρ Φ is the identity. Without
    /// one, ρ changes the signs of all momenta, or those that a diagnosis is given.
    pub reversal: Option<Reversal<'a>>,
    /// How the map gets states before they are requested, if it makes use of that.
    pub prefetch: Option<&'a dyn Prefetch>,
    /// The difference between results for one state, if the map knows one without a further evaluation: several workers may have taken
    /// the same step. The diagnosis asks at its end.
    pub difference: Option<Differences<'a>>,
    /// Whether the user asked to end the diagnosis: it then ends with [`Error::Stopped`] before the next evaluation. Unlike this, a
    /// [`StepFailure`] leaves out the loop or the step size where it happened.
    pub is_stopped: Option<Question<'a>>,
}

/// A function of states that writes one number for each of them: an [`Observable`](crate::trace::Observable) that is owned. Positions
/// and momenta have d rows and one column for each state, in the coordinates that the map advances.
pub type Energy<'a> = Box<dyn Fn(Rows<'_>, Rows<'_>, &mut [f64]) + Send + Sync + 'a>;

/// The largest difference between results for one state; `None` if they are equal.
pub type Differences<'a> = Box<dyn Fn() -> Option<Difference> + Send + Sync + 'a>;

/// A difference between two results for one state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// `'q'` or `'p'`: the coordinate that differs most.
    pub coordinate: char,
    /// Its degree of freedom.
    pub dof: usize,
    /// The size of the difference.
    pub size: f64,
}

/// A function that changes states where they lie.
pub type Reversal<'a> = Box<dyn Fn(&mut Block<'_>) + Send + Sync + 'a>;

/// A question whose answer is yes or no.
pub type Question<'a> = Box<dyn Fn() -> bool + Send + Sync + 'a>;

impl Capabilities<'_> {
    /// A step and nothing else: nothing is periodic, all momenta are canonical, and the map has no grid.
    pub fn plain(dof: usize) -> Self {
        Self::of_coordinates(Coordinates::plain(dof))
    }

    /// A step in these coordinates, and nothing else.
    pub fn of_coordinates(coordinates: Coordinates) -> Self {
        Capabilities {
            block_width: Ensemble::block_width(coordinates.dof()),
            coordinates,
            substeps: None,
            tangent: None,
            constraint: None,
            energy: None,
            reversal: None,
            prefetch: None,
            difference: None,
            is_stopped: None,
        }
    }

    /// The same for a wrapper that takes another step in the same phase space: without substeps, the derivative of the step, and
    /// prefetching.
    #[must_use]
    pub fn for_another_step(self) -> Self {
        Capabilities {
            substeps: None,
            tangent: None,
            prefetch: None,
            ..self
        }
    }
}

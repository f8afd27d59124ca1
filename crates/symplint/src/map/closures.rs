//! Maps written as closures: of one state, or of a block of states.

use std::convert::Infallible;
use std::fmt::Display;

use super::{Capabilities, Constraint, StepFailure, TimeAdvance};
use crate::error::Error;
use crate::state::{Block, Coordinates, scratch};

/// The result of a closure that advances one state: nothing, or a `Result` whose error says why it cannot.
pub trait StepOutcome {
    /// The reason of a failure, as the closure says it.
    ///
    /// # Errors
    /// If the step was not taken.
    fn into_result(self) -> Result<(), String>;
}

impl StepOutcome for () {
    fn into_result(self) -> Result<(), String> {
        Ok(())
    }
}

impl<E: Display> StepOutcome for Result<(), E> {
    fn into_result(self) -> Result<(), String> {
        self.map_err(|reason| reason.to_string())
    }
}

/// Wraps a closure `step(h, q, p)` that advances one state in place.
///
/// `q` and `p` are slices of length d. The closure returns nothing, or a `Result<(), E>` with any error that can be
/// printed.
///
/// ```
/// use symplint::{Coordinates, PerSample, TimeAdvance};
///
/// let drift = PerSample::new(2, |h, q, p| {
///     for (q, p) in q.iter_mut().zip(p) {
///         *q += h * *p;
///     }
/// });
/// assert_eq!(drift.dof(), 2);
///
/// // The implicit midpoint rule for a pendulum, by fixed-point iteration; its angle has the period 2π.
/// let midpoint = PerSample::new(1, |h, q, p| {
///     let (mut angle, mut momentum) = (q[0], p[0]);
///     for _ in 0..100 {
///         let previous = momentum;
///         angle = q[0] + 0.5 * h * momentum;
///         momentum = p[0] - 0.5 * h * angle.sin();
///         if (momentum - previous).abs() < 1e-15 {
///             (q[0], p[0]) = (2.0 * angle - q[0], 2.0 * momentum - p[0]);
///             return Ok(());
///         }
///     }
///     Err("the iteration does not converge")
/// });
/// let periods = vec![std::f64::consts::TAU];
/// let midpoint = midpoint.with_coordinates(Coordinates::plain(1).with_periods(periods)?)?;
/// assert_eq!(midpoint.capabilities().coordinates.period(0), std::f64::consts::TAU);
/// # Ok::<(), symplint::Error>(())
/// ```
pub struct PerSample<F> {
    coordinates: Coordinates,
    step: F,
    projection: Option<Box<dyn Constraint>>,
}

/// A projection of one state, given as a closure.
struct PerSampleProjection<P>(P);

impl<P: Fn(&mut [f64], &mut [f64]) + Send + Sync> Constraint for PerSampleProjection<P> {
    fn project(&self, block: &mut Block<'_>) {
        let Ok(()) = each_state(block, |q, p| {
            (self.0)(q, p);
            Ok::<(), Infallible>(())
        });
    }
}

/// Calls `act(q, p)` on a copy of every state, and writes it back. An error comes with its sample.
fn each_state<E>(
    block: &mut Block<'_>,
    act: impl Fn(&mut [f64], &mut [f64]) -> Result<(), E>,
) -> Result<(), (usize, E)> {
    let dof = block.q.count();
    scratch::with_buffer(2 * dof, |state| {
        let (q, p) = state.split_at_mut(dof);
        for sample in 0..block.len() {
            read(block, sample, q, p);
            act(q, p).map_err(|error| (sample, error))?;
            write(block, sample, q, p);
        }
        Ok(())
    })
}

// These three are compiled once, not for each closure.

fn read(block: &Block<'_>, sample: usize, q: &mut [f64], p: &mut [f64]) {
    for (i, (q, p)) in q.iter_mut().zip(p).enumerate() {
        *q = block.q.row(i)[sample];
        *p = block.p.row(i)[sample];
    }
}

fn write(block: &mut Block<'_>, sample: usize, q: &[f64], p: &[f64]) {
    for (i, (q, p)) in q.iter().zip(p).enumerate() {
        block.q.row_mut(i)[sample] = *q;
        block.p.row_mut(i)[sample] = *p;
    }
}

fn capabilities<'a>(
    coordinates: &Coordinates,
    projection: &'a Option<Box<dyn Constraint>>,
) -> Capabilities<'a> {
    Capabilities {
        constraint: projection.as_deref(),
        ..Capabilities::of_coordinates(coordinates.clone())
    }
}

impl<F> PerSample<F> {
    /// A map on `dof` degrees of freedom, none of them periodic, with canonical momenta.
    pub fn new<R>(dof: usize, step: F) -> Self
    where
        F: Fn(f64, &mut [f64], &mut [f64]) -> R + Send + Sync,
        R: StepOutcome,
    {
        PerSample {
            coordinates: Coordinates::plain(dof),
            step,
            projection: None,
        }
    }

    /// The same with periods, weights or a grid.
    ///
    /// # Errors
    /// If the coordinates are those of other degrees of freedom.
    pub fn with_coordinates(self, coordinates: Coordinates) -> Result<Self, Error> {
        let coordinates = coordinates.of_dof(self.coordinates.dof())?;
        Ok(PerSample {
            coordinates,
            ..self
        })
    }

    /// The same on the manifold that `projection(q, p)` puts a state on, in place: see [`Constraint`].
    ///
    /// ```
    /// use symplint::{Circle, Diagnostic, PerSample, VerdictKind};
    /// use symplint::map::ProjectedLoop;
    ///
    /// // A pendulum of length 1 in Cartesian coordinates by RATTLE: the rod pulls before and after the drift.
    /// let rod = |q: &[f64], p: &[f64]| q[0] * p[0] + q[1] * p[1];
    /// let rattle = PerSample::new(2, move |h, q, p| {
    ///     let at_start = [q[0], q[1]];
    ///     p[1] -= 0.5 * h;
    ///     let moved = [q[0] + h * p[0], q[1] + h * p[1]];
    ///     // |moved + h λ q| = 1 is quadratic in hλ.
    ///     let (a, b) = (rod(q, q), rod(&moved, q));
    ///     let pull = (-b + (b * b - a * (rod(&moved, &moved) - 1.0)).sqrt()) / a;
    ///     for i in 0..2 {
    ///         q[i] = moved[i] + pull * at_start[i];
    ///         p[i] += pull / h * at_start[i];
    ///     }
    ///     p[1] -= 0.5 * h;
    ///     let along = rod(q, p);
    ///     (0..2).for_each(|i| p[i] -= along * q[i]);
    /// })
    /// .with_projection(move |q, p| {
    ///     let length = rod(q, q).sqrt();
    ///     q.iter_mut().for_each(|q| *q /= length);
    ///     let along = rod(q, p);
    ///     (0..2).for_each(|i| p[i] -= along * q[i]);
    /// });
    /// let circle = Circle::new(vec![0.6, -0.8], vec![0.4, 0.3], 0.3)?;
    /// let circle = ProjectedLoop::new(circle, &rattle);
    /// let diagnosis = Diagnostic::halving(-1, -4).run(&rattle, &circle)?;
    /// assert_eq!(diagnosis.verdict.kind, VerdictKind::Symplectic);
    /// # Ok::<(), symplint::Error>(())
    /// ```
    pub fn with_projection(
        self,
        projection: impl Fn(&mut [f64], &mut [f64]) + Send + Sync + 'static,
    ) -> Self {
        PerSample {
            projection: Some(Box::new(PerSampleProjection(projection))),
            ..self
        }
    }
}

impl<F, R> TimeAdvance for PerSample<F>
where
    F: Fn(f64, &mut [f64], &mut [f64]) -> R + Send + Sync,
    R: StepOutcome,
{
    fn dof(&self) -> usize {
        self.coordinates.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        each_state(block, |q, p| (self.step)(h, q, p).into_result())
            .map_err(|(sample, reason)| StepFailure { sample, reason })
    }

    fn capabilities(&self) -> Capabilities<'_> {
        capabilities(&self.coordinates, &self.projection)
    }
}

/// Wraps a closure `step(h, block)` that advances all samples of a block in place.
///
/// Rows of the block are degrees of freedom, columns are samples: loops over a row are vectorised.
///
/// ```
/// use symplint::{PerBlock, TimeAdvance};
///
/// let drift = PerBlock::new(2, |h, block| {
///     for i in 0..2 {
///         for (q, p) in block.q.row_mut(i).iter_mut().zip(block.p.row(i)) {
///             *q += h * p;
///         }
///     }
///     Ok(())
/// });
/// assert_eq!(drift.dof(), 2);
/// ```
pub struct PerBlock<F> {
    coordinates: Coordinates,
    step: F,
    projection: Option<Box<dyn Constraint>>,
}

/// A projection of all states of a block, given as a closure.
struct PerBlockProjection<P>(P);

impl<P: Fn(&mut Block<'_>) + Send + Sync> Constraint for PerBlockProjection<P> {
    fn project(&self, block: &mut Block<'_>) {
        (self.0)(block);
    }
}

impl<F> PerBlock<F>
where
    F: Fn(f64, &mut Block<'_>) -> Result<(), StepFailure> + Send + Sync,
{
    /// A map on `dof` degrees of freedom, none of them periodic, with canonical momenta.
    pub fn new(dof: usize, step: F) -> Self {
        PerBlock {
            coordinates: Coordinates::plain(dof),
            step,
            projection: None,
        }
    }

    /// The same with periods, weights or a grid.
    ///
    /// # Errors
    /// If the coordinates are those of other degrees of freedom.
    pub fn with_coordinates(self, coordinates: Coordinates) -> Result<Self, Error> {
        let coordinates = coordinates.of_dof(self.coordinates.dof())?;
        Ok(PerBlock {
            coordinates,
            ..self
        })
    }

    /// The same on the manifold that `projection(block)` puts all states of a block on, in place: see [`Constraint`].
    pub fn with_projection(
        self,
        projection: impl Fn(&mut Block<'_>) + Send + Sync + 'static,
    ) -> Self {
        PerBlock {
            projection: Some(Box::new(PerBlockProjection(projection))),
            ..self
        }
    }
}

impl<F> TimeAdvance for PerBlock<F>
where
    F: Fn(f64, &mut Block<'_>) -> Result<(), StepFailure> + Send + Sync,
{
    fn dof(&self) -> usize {
        self.coordinates.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        (self.step)(h, block)
    }

    fn capabilities(&self) -> Capabilities<'_> {
        capabilities(&self.coordinates, &self.projection)
    }
}

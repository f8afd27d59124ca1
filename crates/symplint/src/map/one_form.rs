//! Maps in non-canonical coordinates, tested by a one-form.
//!
//! In coordinates z in which the symplectic form is ω = dϑ, the loop integral is ∮ Σ ϑ_i(z) dz_i. The points (z, ϑ(z)) are a
//! manifold in a phase space of n degrees of freedom, on which the canonical loop integral ∮ p·dq is this one, and the canonical
//! form is ω. A map of z is a map of this manifold, so that all that is known of canonical coordinates and of constraints
//! holds.

use super::{Capabilities, Constraint, Parts, StepFailure, Substeps, TimeAdvance};
use crate::error::Error;
use crate::loops::Loop;
use crate::state::{Block, Coordinates};

/// A one-form ϑ = Σ ϑ_i(z) dz_i of n coordinates z, whose derivative dϑ is the symplectic form.
///
/// ```
/// use symplint::Block;
/// use symplint::map::OneForm;
///
/// /// Lotka–Volterra: ω = dx∧dy/(xy), as of ϑ = −(ln y / x) dx.
/// struct Populations;
///
/// impl OneForm for Populations {
///     fn dimension(&self) -> usize {
///         2
///     }
///     fn evaluate(&self, block: &mut Block<'_>) {
///         for k in 0..block.len() {
///             let (x, y) = (block.q.row(0)[k], block.q.row(1)[k]);
///             block.p.row_mut(0)[k] = -y.ln() / x;
///             block.p.row_mut(1)[k] = 0.0;
///         }
///     }
/// }
/// ```
pub trait OneForm: Send + Sync {
    /// The number n of coordinates.
    fn dimension(&self) -> usize;

    /// Reads z from the positions of `block`, one row for each coordinate, and writes ϑ(z) to its momenta. It must be smooth
    /// on the loops and between the ends of their breaks. If it has no value, it writes NaN, which becomes an error.
    fn evaluate(&self, block: &mut Block<'_>);

    /// Puts the positions z of `block` on one leaf of the form, in place. By default it does nothing: dϑ has full rank.
    ///
    /// In Lie–Poisson coordinates, such as spins or angular momenta, dϑ is degenerate, and a map is symplectic on the leaves, on
    /// which the Casimir functions are constant. Loops and tangent vectors are kept to the leaf by this projection. States on the
    /// leaf stay where they are, to round-off, and the projection is smooth near the leaf. Without it, a map in such coordinates is
    /// never called not symplectic.
    fn project(&self, block: &mut Block<'_>) {
        let _ = block;
    }
}

impl<F: OneForm + ?Sized> OneForm for &F {
    fn dimension(&self) -> usize {
        (**self).dimension()
    }
    fn evaluate(&self, block: &mut Block<'_>) {
        (**self).evaluate(block);
    }
    fn project(&self, block: &mut Block<'_>) {
        (**self).project(block);
    }
}

impl<F: OneForm + ?Sized> OneForm for Box<F> {
    fn dimension(&self) -> usize {
        (**self).dimension()
    }
    fn evaluate(&self, block: &mut Block<'_>) {
        (**self).evaluate(block);
    }
    fn project(&self, block: &mut Block<'_>) {
        (**self).project(block);
    }
}

/// A map in non-canonical coordinates z as a canonical one of the points (z, ϑ(z)).
///
/// The map takes states as all maps do: the first half of the coordinates are its "positions", the others its "momenta", such
/// as x and v of a charged particle. [`of_positions`](Self::of_positions) is for other numbers of coordinates. The tested map has n degrees
/// of freedom: its positions are all coordinates z, its momenta
/// are ϑ(z). Reports number them so: degree of freedom i is the coordinate z_i.
///
/// ```
/// use symplint::map::{NonCanonical, OneForm};
/// use symplint::{Block, Circle, Diagnostic, PerSample, VerdictKind};
/// # struct Populations;
/// # impl OneForm for Populations {
/// #     fn dimension(&self) -> usize { 2 }
/// #     fn evaluate(&self, block: &mut Block<'_>) {
/// #         for k in 0..block.len() {
/// #             let (x, y) = (block.q.row(0)[k], block.q.row(1)[k]);
/// #             block.p.row_mut(0)[k] = -y.ln() / x;
/// #             block.p.row_mut(1)[k] = 0.0;
/// #         }
/// #     }
/// # }
///
/// // The flows of x' = x (1 − y) and y' = y (x − 1), one after the other.
/// let step = PerSample::new(1, |h, x, y| {
///     x[0] *= (h * (1.0 - y[0])).exp();
///     y[0] *= (h * (x[0] - 1.0)).exp();
/// });
/// let map = NonCanonical::new(step, Populations)?;
/// // A circle in the plane of x and y.
/// let circle = Circle::new(vec![1.0], vec![1.5], 0.4)?;
/// let diagnosis = Diagnostic::halving(-1, -6).run(&map, &map.loop_of(circle))?;
/// assert_eq!(diagnosis.verdict.kind, VerdictKind::Symplectic);
/// # Ok::<(), symplint::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct NonCanonical<M, F> {
    map: M,
    form: F,
    coordinates: Coordinates,
}

impl<M: TimeAdvance, F: OneForm> NonCanonical<M, F> {
    /// `map` with the symplectic form of `form`. Periods of positions and momenta of the map become those of coordinates; its
    /// weights are not used, as the one-form says what momenta are.
    ///
    /// # Errors
    /// If the form has not twice as many coordinates as the map has degrees of freedom.
    pub fn new(map: M, form: F) -> Result<Self, Error> {
        let n = 2 * map.dof();
        Self::of_dimension(map, form, n)
    }

    /// The same for a map whose positions are all coordinates z, and which does not use its momenta: three of a spin.
    ///
    /// # Errors
    /// If the form has not as many coordinates as the map has degrees of freedom.
    pub fn of_positions(map: M, form: F) -> Result<Self, Error> {
        let n = map.dof();
        Self::of_dimension(map, form, n)
    }

    fn of_dimension(map: M, form: F, n: usize) -> Result<Self, Error> {
        let dof = map.dof();
        if form.dimension() != n {
            let dimension = form.dimension();
            return Err(Error::FormDimension { dimension, dof });
        }
        let of_map = map.capabilities().coordinates;
        let periods = (0..dof).map(|i| of_map.period(i));
        let periods = periods.chain((0..n - dof).map(|i| of_map.momentum_period(i)));
        let coordinates = Coordinates::plain(n).with_periods(periods.collect())?;
        Ok(NonCanonical {
            map,
            form,
            coordinates,
        })
    }

    /// A loop of states of the map as one of points (z, ϑ(z)), on the leaf of the form.
    pub fn loop_of<L: Loop>(&self, states: L) -> impl Loop {
        LoopOfForm {
            states,
            form: &self.form,
        }
    }

    fn on_states(
        &self,
        block: &mut Block<'_>,
        advance: impl FnOnce(&mut Block<'_>) -> Result<(), StepFailure>,
    ) -> Result<(), StepFailure> {
        with_states(block, self.map.dof(), advance)?;
        self.form.evaluate(block);
        Ok(())
    }
}

/// Calls a function with the coordinates of a block, the first half of them as positions, the others as momenta; with all of them
/// as positions if the states have as many degrees of freedom.
fn with_states<T>(block: &mut Block<'_>, dof: usize, call: impl FnOnce(&mut Block<'_>) -> T) -> T {
    if dof == block.dof() {
        return call(block);
    }
    let (q, p) = block.q.reborrow().split_at_row(dof);
    call(&mut Block::new(q, p))
}

impl<M: TimeAdvance, F: OneForm> TimeAdvance for NonCanonical<M, F> {
    fn dof(&self) -> usize {
        self.form.dimension()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.on_states(block, |states| self.map.advance(h, states))
    }

    fn capabilities(&self) -> Capabilities<'_> {
        let of_map = self.map.capabilities();
        Capabilities {
            coordinates: self.coordinates.clone(),
            block_width: of_map.block_width,
            substeps: of_map.substeps.map(|_| self as &dyn Substeps),
            constraint: Some(self),
            difference: of_map.difference,
            is_stopped: of_map.is_stopped,
            ..Capabilities::plain(self.dof())
        }
    }
}

impl<M: TimeAdvance, F: OneForm> Substeps for NonCanonical<M, F> {
    fn substeps(&self) -> usize {
        Parts::of(&self.map).count()
    }

    fn advance_substep(
        &self,
        substep: usize,
        h: f64,
        block: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        self.on_states(block, |states| {
            Parts::of(&self.map).advance(substep, h, states)
        })
    }

    fn substep_name(&self, substep: usize) -> String {
        Parts::of(&self.map).name(substep)
    }
}

impl<M: TimeAdvance, F: OneForm> Constraint for NonCanonical<M, F> {
    fn project(&self, block: &mut Block<'_>) {
        self.form.project(block);
        self.form.evaluate(block);
    }

    fn holds_between_substeps(&self) -> bool {
        true
    }

    fn is_of_one_form(&self) -> bool {
        true
    }
}

/// A loop of states as one of points (z, ϑ(z)).
struct LoopOfForm<L, F> {
    states: L,
    form: F,
}

impl<L: Loop, F: OneForm> Loop for LoopOfForm<L, F> {
    fn dof(&self) -> usize {
        let (dof, n) = (self.states.dof(), self.form.dimension());
        if dof == n { n } else { 2 * dof }
    }

    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        let dof = self.states.dof();
        with_states(block, dof, |states| self.states.sample(s, states));
        self.form.project(block);
        self.form.evaluate(block);
    }
}

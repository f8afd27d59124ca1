//! The unknowns of stages: the slopes of a system, or their derivatives along tangent vectors.

use symplint::state::{Rows, RowsMut};

use crate::hamiltonian::Hamiltonian;
use crate::tangent::{PhasePoints, SlopeTangent};

/// Where in a step slopes are asked for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place {
    /// The state before the step.
    Start,
    /// A stage.
    Stage(usize),
    /// The mean of the stages.
    Mean,
}

/// Slopes as a function of the state. Tables hold 2d coordinates, positions before momenta, each as a
/// row of samples.
pub(super) trait SlopeField {
    /// Adds velocity and force at `state`, of the shape (d, samples).
    fn add_slopes(&self, place: Place, shape: (usize, usize), state: &[f64], out: &mut [f64]);
}

/// The slopes of a Hamiltonian: the same function everywhere.
pub(super) struct SystemSlopes<'a, H>(pub &'a H);

impl<H: Hamiltonian> SlopeField for SystemSlopes<'_, H> {
    fn add_slopes(&self, _place: Place, shape: (usize, usize), state: &[f64], out: &mut [f64]) {
        let PhasePoints { q, p } = points(shape, state);
        let (mut velocity, mut force) = halves(shape, out);
        self.0.add_velocity(1.0, q, p, &mut velocity);
        self.0.add_force(1.0, q, p, &mut force);
    }
}

/// The derivatives of the slopes at the states of a step that is solved, a linear function of the
/// tangent vectors at each place.
pub(super) struct TangentSlopes<'a> {
    pub derivative: SlopeTangent<'a>,
    /// States: at the start, at the mean, and at the stages in turn.
    pub states: &'a [f64],
}

impl SlopeField for TangentSlopes<'_> {
    fn add_slopes(&self, place: Place, shape: (usize, usize), tangent: &[f64], out: &mut [f64]) {
        let table = match place {
            Place::Start => 0,
            Place::Mean => 1,
            Place::Stage(i) => 2 + i,
        };
        let state = &self.states[table * tangent.len()..][..tangent.len()];
        let (at, along) = (points(shape, state), points(shape, tangent));
        let (mut velocity, mut force) = halves(shape, out);
        self.derivative.add_velocity(1.0, at, along, &mut velocity);
        self.derivative.add_force(1.0, at, along, &mut force);
    }
}

fn points((dof, len): (usize, usize), table: &[f64]) -> PhasePoints<'_> {
    let (q, p) = table.split_at(dof * len);
    PhasePoints {
        q: Rows::new(q, dof, len, len),
        p: Rows::new(p, dof, len, len),
    }
}

fn halves((dof, len): (usize, usize), table: &mut [f64]) -> (RowsMut<'_>, RowsMut<'_>) {
    let (velocity, force) = table.split_at_mut(dof * len);
    (
        RowsMut::new(velocity, dof, len, len),
        RowsMut::new(force, dof, len, len),
    )
}

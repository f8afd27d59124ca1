//! Steps of systems in non-canonical coordinates, on blocks of samples.

use symplint::map::{NonCanonical, OneForm};
use symplint::state::{Rows, RowsMut};
use symplint::{Block, StepFailure, TimeAdvance};

use super::{NonCanonicalSystem, State};
use crate::error::ModelError;
use crate::hamiltonian::Hamiltonian;
use crate::integrators::{RungeKutta, Tableau};

/// The one-form of a system.
#[derive(Clone, Copy, Debug)]
pub struct SystemOneForm<S, const D: usize>(pub S);

impl<S: NonCanonicalSystem<D>, const D: usize> OneForm for SystemOneForm<S, D> {
    fn dimension(&self) -> usize {
        2 * D
    }

    fn evaluate(&self, block: &mut Block<'_>) {
        for k in 0..block.len() {
            let z = [0, D].map(|first| std::array::from_fn(|i| block.q.row(first + i)[k]));
            for (i, value) in self.0.one_form(z).as_flattened().iter().enumerate() {
                block.p.row_mut(i)[k] = *value;
            }
        }
    }
}

/// A map of states of D "positions" and D "momenta", one at a time.
struct Steps<F, const D: usize>(F);

impl<F, const D: usize> TimeAdvance for Steps<F, D>
where
    F: Fn(f64, State<D>) -> Result<State<D>, &'static str> + Send + Sync,
{
    fn dof(&self) -> usize {
        D
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        for sample in 0..block.len() {
            let z = [
                std::array::from_fn(|i| block.q.row(i)[sample]),
                std::array::from_fn(|i| block.p.row(i)[sample]),
            ];
            let [q, p] = (self.0)(h, z).map_err(|reason| StepFailure {
                sample,
                reason: reason.to_owned(),
            })?;
            for i in 0..D {
                block.q.row_mut(i)[sample] = q[i];
                block.p.row_mut(i)[sample] = p[i];
            }
        }
        Ok(())
    }
}

/// The equations of motion as slopes for Runge–Kutta methods.
struct Equations<S, const D: usize>(S);

fn state<const D: usize>(q: Rows<'_>, p: Rows<'_>, sample: usize) -> State<D> {
    [q, p].map(|rows| std::array::from_fn(|i| rows.row(i)[sample]))
}

impl<S: NonCanonicalSystem<D>, const D: usize> Hamiltonian for Equations<S, D> {
    fn dof(&self) -> usize {
        D
    }

    fn energy(&self, q: Rows<'_>, p: Rows<'_>, out: &mut [f64]) {
        for (k, out) in out.iter_mut().enumerate() {
            *out = self.0.energy(state(q, p, k));
        }
    }

    fn add_velocity(&self, tau: f64, q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>) {
        for k in 0..q.len() {
            let [velocity, _] = self.0.velocity(state::<D>(q, p, k));
            for (i, velocity) in velocity.into_iter().enumerate() {
                out.row_mut(i)[k] += tau * velocity;
            }
        }
    }

    fn add_force(&self, tau: f64, q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>) {
        for k in 0..q.len() {
            let [_, force] = self.0.velocity(state::<D>(q, p, k));
            for (i, force) in force.into_iter().enumerate() {
                out.row_mut(i)[k] += tau * force;
            }
        }
    }
}

/// A system advanced by its symplectic step.
pub fn by_symplectic_steps<S: NonCanonicalSystem<D>, const D: usize>(
    system: S,
) -> Result<impl TimeAdvance, ModelError> {
    let of_steps = system.clone();
    by_steps(system, move |h, z| of_steps.symplectic_step(h, z))
}

/// A system advanced by an explicit Runge–Kutta method.
///
/// # Errors
/// If the method is not explicit.
pub fn by_runge_kutta<S: NonCanonicalSystem<D>, const D: usize>(
    system: S,
    method: Tableau,
) -> Result<impl TimeAdvance, ModelError> {
    let steps = RungeKutta::new(method, Equations(system.clone()))?;
    Ok(NonCanonical::new(steps, SystemOneForm(system)).expect("both have D degrees of freedom"))
}

/// A system advanced by other steps.
pub fn by_steps<S: NonCanonicalSystem<D>, const D: usize>(
    system: S,
    step: impl Fn(f64, State<D>) -> Result<State<D>, &'static str> + Send + Sync + 'static,
) -> Result<impl TimeAdvance, ModelError> {
    let map = NonCanonical::new(Steps(step), SystemOneForm(system));
    Ok(map.expect("both have D degrees of freedom"))
}

/// The state (z, ϑ(z)) of the map, as positions and momenta of 2 D degrees of freedom.
pub fn states_of<S: NonCanonicalSystem<D>, const D: usize>(
    system: &S,
    z: State<D>,
) -> [Vec<f64>; 2] {
    [z, system.one_form(z)].map(|state| state.as_flattened().to_vec())
}

//! Systems in non-canonical coordinates, each with the one-form ϑ of its symplectic form, dϑ = ω.
//!
//! The equations of motion are ω(ż, ·) = −dH, as they are of ϑ = p·dq. [`by_symplectic_steps`] and [`by_runge_kutta`] advance a system; both maps are tested by
//! its one-form, see [`NonCanonical`].

mod guiding_center;
mod lotka_volterra;
mod massless_charge;
mod steps;
mod velocities;

pub use guiding_center::GuidingCenter;
pub use lotka_volterra::LotkaVolterra;
pub use massless_charge::MasslessCharge;
pub use steps::{SystemOneForm, by_runge_kutta, by_steps, by_symplectic_steps, states_of};
pub use velocities::{Velocities, VelocityStep};

#[cfg(doc)]
use symplint::map::NonCanonical;

/// A state of 2 D coordinates: the first half and the second half of them.
pub type State<const D: usize> = [[f64; D]; 2];

/// A system of 2 D coordinates.
pub trait NonCanonicalSystem<const D: usize>: Clone + Send + Sync + 'static {
    /// ż of the equations of motion.
    fn velocity(&self, z: State<D>) -> State<D>;

    /// H.
    fn energy(&self, z: State<D>) -> f64;

    /// ϑ(z).
    fn one_form(&self, z: State<D>) -> State<D>;

    /// A step of size h that conserves dϑ exactly, of order 1 or higher.
    ///
    /// # Errors
    /// Why it cannot be taken.
    fn symplectic_step(&self, h: f64, z: State<D>) -> Result<State<D>, &'static str>;
}

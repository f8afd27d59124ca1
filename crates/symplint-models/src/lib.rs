//! Hamiltonian systems and the integrators that advance them, to be tested by [`symplint`].
//!
//! * [`systems`]: pendula, a wedge, oscillators, Hénon–Heiles, Kepler, chains, a charge in a magnetic
//!   field, a force without a potential.
//! * [`discrete`]: maps that are given, not integrated: the Hénon map and the standard map.
//! * [`non_canonical`]: Lotka–Volterra, a massless charge, a guiding centre, a charge by its velocity.
//! * [`integrators`]: splitting and Runge–Kutta methods, explicit and implicit, as data, and a
//!   [catalogue](integrators::catalogue) of them by name.
//! * [`maps`]: maps made from maps: sequences, repetitions, inverses, adjoints, and maps with a fault.
//! * [`Separable`], [`Hamiltonian`], [`SplitHamiltonian`] and [`DriftKick`]: what a system of your own supplies;
//!   [`Model`] is any of them.
//! * [`DriftKickTangent`] and [`HamiltonianTangent`]: what gives its steps exact Jacobians.
//! * [`elementary`]: sines and cosines of rows of states, fast and the same in every system.
//! * [`bspline`], [`PeriodicGrid`] and [`PeriodicSpline`]: interpolation on a grid.
//! * [`random`]: random numbers that are the same on every machine.
//!
//! Particle-in-cell plasmas are in the crate `symplint-plasma`.
//!
//! A system acts on blocks of samples, one row for each degree of freedom. An integrator makes a
//! [`TimeAdvance`](symplint::TimeAdvance) map of it, which needs no more than the block, the step
//! size and scratch memory of its thread:
//!
//! ```
//! use symplint::{Block, TimeAdvance};
//! use symplint::state::RowsMut;
//! use symplint_models::integrators::{Splitting, Variant, splitting_methods};
//! use symplint_models::systems::{Pendulum, PendulumPotential};
//!
//! let pendulum = Pendulum::new(PendulumPotential::Cos);
//! let step = Splitting::new(splitting_methods::strang(Variant::PositionFirst), pendulum);
//!
//! // Three samples of one degree of freedom.
//! let (mut q, mut p) = ([3.0, 3.1, 3.2], [0.0, 0.1, 0.2]);
//! let mut block = Block::new(RowsMut::new(&mut q, 1, 3, 3), RowsMut::new(&mut p, 1, 3, 3));
//! step.advance(0.1, &mut block)?;
//!
//! let kicked = 0.1 + 0.1 * (3.1_f64 + 0.05 * 0.1).sin();
//! assert!((p[1] - kicked).abs() < 1e-15);
//! assert!((q[1] - (3.1 + 0.05 * (0.1 + kicked))).abs() < 1e-15);
//! # Ok::<(), symplint::StepFailure>(())
//! ```
//!
//! Names and equations are those of W. Barham & J. Burby, "Diagnosing symplecticity in
//! simulations of high-dimensional Hamiltonian systems"; HLW is E. Hairer, C. Lubich & G. Wanner,
//! "Geometric Numerical Integration", 2nd edition.

#![forbid(unsafe_code)]

pub mod bspline;
pub mod discrete;
pub mod elementary;
mod error;
mod hamiltonian;
pub mod integrators;
pub mod maps;
mod model;
pub mod non_canonical;
mod periodic_grid;
mod periodic_spline;
pub mod random;
mod split_hamiltonian;
pub mod systems;
mod tangent;

pub use error::ModelError;
pub use hamiltonian::{DriftKick, Hamiltonian, Separable};
pub use model::Model;
pub use periodic_grid::{PeriodicGrid, Place};
pub use periodic_spline::PeriodicSpline;
pub use split_hamiltonian::{PartFlow, SplitHamiltonian};
pub use tangent::{DriftKickTangent, HamiltonianTangent, PhasePoints, SlopeTangent};

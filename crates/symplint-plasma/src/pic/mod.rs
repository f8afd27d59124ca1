//! Electrostatic particle-in-cell plasmas: Barham & Burby, section 5.
//!
//! A [`Pic`] is a separable Hamiltonian system like any other: [`Pic1d`] on a line, [`Pic2d`] in a
//! plane. Its particles start as in [`Landau`] or [`TwoStream`], or wherever they are put:
//!
//! ```
//! use std::sync::Arc;
//! use symplint::{Circle, Defect, Ensemble, LoopIntegral, Rule};
//! use symplint_models::integrators::catalogue;
//! use symplint_plasma::pic::{Pic1d, PicConfig, TwoStream};
//!
//! let pic = Arc::new(Pic1d::new(PicConfig::default())?);
//! let (x, v) = TwoStream::default().sample(&pic, 1)?;
//! let step = catalogue::build("strang", None, pic)?;
//!
//! let mut ensemble = Ensemble::sample(&Circle::new(x, v, 1.0)?, 1024)?;
//! let integral = |e: &_| LoopIntegral::in_coordinates(e, &Rule::Pseudospectral, &step.capabilities().coordinates);
//! let initial = integral(&ensemble)?;
//! ensemble.advance(&*step, 0.1)?;
//! let defect = Defect::between(&initial, &integral(&ensemble)?)?;
//! assert!(defect.magnitude() < 1e-7, "{defect:?}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! From the particles to the force: `shape` knows the basis functions of a cell, `mesh` numbers the
//! nodes, `deposit` carries charge to them and gradients back, `element` has the
//! matrices of one axis and one Fourier mode, `field` solves for the potential (`packed` where it can be faster), `system` is the
//! Hamiltonian. On a line there is a faster way, `line`: `place` finds the particles' cells,
//! `polynomials` has what all particles of a cell share, `runs` does without that where cells are
//! more than particles (`carrier` has both), and `pairs` without a mesh where there are few. In a plane, `plane` goes by
//! `runs` on both axes. If there are many particles, `portions` shares them out to the threads. `tangent` has the derivative of the force.
//!
//! `momentum_conserving` is the scheme of textbooks, [`MomentumConservingPic`], whose force is not a gradient. It shares nothing
//! with the others but the particles' weights and initial states.

mod by_functions;
mod carrier;
mod deposit;
mod element;
mod field;
mod initial;
mod line;
mod mesh;
mod momentum_conserving;
mod packed;
mod pairs;
mod place;
mod plane;
mod polynomials;
mod portions;
mod runs;
mod scratch;
mod shape;
mod system;
mod tangent;
mod weights;

pub(crate) use initial::wave_quantile;
pub use initial::{Landau, TwoStream, VelocityConvention};
pub use momentum_conserving::{MomentumConservingConfig, MomentumConservingPic};
pub use shape::ShapeFamily;
pub use system::{Pic, Pic1d, Pic2d, PicConfig};
pub use weights::ParticleWeights;

//! Electromagnetic particle-in-cell plasmas in one dimension of space and two of velocity (1D2V), geometric.
//!
//! GEMPIC: M. Kraus, K. Kormann, P. J. Morrison & E. Sonnendrücker, GEMPIC: geometric electromagnetic particle-in-cell
//! methods, J. Plasma Phys. 83 (2017) 905830401.
//!
//! A [`Gempic`] is a [`SplitHamiltonian`](symplint_models::SplitHamiltonian) in canonical variables, so every splitting and every
//! Runge–Kutta method of the catalogue advances it. Its particles start as an [`InitialPlasma`], or wherever they are
//! put:
//!
//! ```
//! use symplint::{Circle, Defect, Ensemble, LoopIntegral, Rule};
//! use symplint_plasma::gempic::{Gempic, GempicConfig, InitialPlasma};
//! use symplint_models::integrators::catalogue;
//! use symplint_models::Model;
//!
//! let plasma = Gempic::new(GempicConfig { degree: 4, ..GempicConfig::default() })?;
//! let (q, p) = InitialPlasma::Random.sample(&plasma, 0.1, 1)?;
//! assert!(plasma.gauss_residual(&q, &p) < 1e-13);
//! let step = catalogue::build("strang", None, Model::from(plasma))?;
//!
//! let mut ensemble = Ensemble::sample(&Circle::new(q, p, 0.2)?, 1024)?;
//! let integral = |e: &_| LoopIntegral::in_coordinates(e, &Rule::Pseudospectral, &step.capabilities().coordinates);
//! let initial = integral(&ensemble)?;
//! ensemble.advance(&*step, 0.1)?;
//! let defect = Defect::between(&initial, &integral(&ensemble)?)?;
//! assert!(defect.magnitude() < 1e-9, "{defect:?}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! `electromagnetic` is the system with the flows of the fields, `part` numbers its four parts, `pass` has the flows of
//! the particles, any number of them in one pass, `energy` has H and its gradient, `physical` the way to velocities and
//! fields, and what is watched. `overlap` and `mass` make and solve the mass matrices, `polynomials` goes between
//! splines and cells, `particles` has what particles and splines share. `initial` and `quiet` are initial states.
//!
//! `schemes` has what other particle-in-cell codes do with the same particles and fields.

mod electromagnetic;
mod energy;
mod initial;
mod mass;
mod overlap;
mod part;
mod particles;
mod pass;
mod physical;
mod polynomials;
mod quiet;
mod schemes;

pub use electromagnetic::{Fields, Gempic, GempicConfig};
pub use initial::InitialPlasma;
pub use physical::{FieldEnergies, PhysicalState};
pub use schemes::{Boris1d2v, Orbit, PlasmaStep};

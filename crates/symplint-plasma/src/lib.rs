//! Particle-in-cell plasmas, to be tested by [`symplint`].
//!
//! * [`pic`]: electrostatic plasmas in one and two dimensions.
//! * [`gempic`]: electromagnetic plasmas in one dimension of space and two of velocity, and schemes of other codes.
//! * [`CATALOGUE`]: the integrators of [`symplint_models`] and those schemes by name.
//!
//! Names and equations are those of W. Barham & J. Burby, "Diagnosing symplecticity in
//! simulations of high-dimensional Hamiltonian systems".

#![forbid(unsafe_code)]

mod catalogue;
pub mod gempic;
pub mod pic;

pub use catalogue::CATALOGUE;

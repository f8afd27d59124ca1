//! Electromagnetic particle-in-cell plasmas in one dimension of space and two of velocity (1D2V), geometric.
//!
//! GEMPIC: M. Kraus, K. Kormann, P. J. Morrison & E. Sonnendrücker, GEMPIC: geometric electromagnetic particle-in-cell
//! methods, J. Plasma Phys. 83 (2017) 905830401, section 6.

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

pub use electromagnetic::{Gempic, GempicConfig};
pub use initial::InitialPlasma;
pub use physical::{FieldEnergies, PhysicalState};

//! The four parts of the Hamiltonian, as they are numbered.

/// H_E: the energy of the electric field.
pub(super) const ELECTRIC: usize = 0;
/// H_B: the energy of the magnetic field.
pub(super) const MAGNETIC: usize = 1;
/// H_p1 = Σ ½ w m v1².
pub(super) const ALONG: usize = 2;
/// H_p2 = Σ ½ w m v2².
pub(super) const ACROSS: usize = 3;

/// Their names in reports, by their numbers.
pub(super) const NAMES: [&str; 4] = ["H_E", "H_B", "H_p1", "H_p2"];

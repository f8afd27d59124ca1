//! The energy of states, whose change a diagnosis reports.

use crate::state::Rows;

/// The energy of a system, or another function of one state that its steps may conserve.
pub trait Energy: Send + Sync {
    /// Writes the energy of each state into `energies`; `q` and `p` have d rows and one column for each state. The coordinates are
    /// those that the map advances.
    fn energies(&self, q: Rows<'_>, p: Rows<'_>, energies: &mut [f64]);
}

impl<F: Fn(Rows<'_>, Rows<'_>, &mut [f64]) + Send + Sync> Energy for F {
    fn energies(&self, q: Rows<'_>, p: Rows<'_>, energies: &mut [f64]) {
        self(q, p, energies);
    }
}

//! The geometric electromagnetic particle-in-cell plasma against its definition, and its properties.

mod bracket;
mod energy_conserving;
mod flows;
mod hamiltonian;
mod initial;
mod invariants;
mod loops;
mod physics;
mod reference;
mod schemes;

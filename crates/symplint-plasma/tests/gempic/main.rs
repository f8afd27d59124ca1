//! The geometric electromagnetic particle-in-cell plasma against its definition, and its properties.

mod bracket;
#[path = "../../../symplint-models/tests/common/mod.rs"]
mod common;
mod energy_conserving;
mod flows;
mod hamiltonian;
mod initial;
mod invariants;
mod loops;
mod physics;
mod reference;
mod schemes;

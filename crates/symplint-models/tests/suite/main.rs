//! The tests of this crate in one program, which is linked once.

mod array;
mod common;
mod discrete_gradient;
mod elementary;
mod faults;
mod forces;
mod implicit;
mod maps;
mod non_canonical;
mod orders;
mod reference_figures;
#[path = "common/rotor.rs"]
mod rotor;
mod symplecticity;
mod systems;
#[path = "common/two_form.rs"]
mod two_form;

//! The tests of this crate in one program, which is linked once.

#[path = "../../../symplint-models/tests/suite/common/mod.rs"]
mod common;
mod gempic;
mod pic_dense;
mod pic_discrete_gradient;
mod pic_es1;
mod pic_forces;
mod pic_initial;
mod pic_places;
mod pic_reference;

//! The tests of this crate in one program, which is linked once.

mod book;
#[path = "../../../symplint-models/tests/suite/common/mod.rs"]
mod common;
mod forces;
mod measured;
mod preserved_form;
mod progress;
mod properties;
#[path = "../../../symplint-models/tests/suite/common/rotor.rs"]
mod rotor;
mod solver_tolerance;
mod tangents;
mod traps;
mod truth_set;
mod truth_table;
mod verdicts;

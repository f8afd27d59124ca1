//! Verdicts on maps whose answer is known. The tests of this crate are the content; the library holds what several of
//! them share.
//!
//! * `truth_table`: single maps, systems and loops, each with the reason for its answer.
//! * `truth_set`: families of random maps (docs/truth.md).
//! * `traps`: features that samples or pieces step over.
//! * `verdicts`: rules chosen by hand, failures, sizes.
//! * `measured`: loops of other codes, measured from their samples alone.
//! * `solver_tolerance`: maps whose solver stops at a tolerance.
//! * `tangents`: exact Jacobians of all systems with all integrators.

pub mod kept;
pub mod scaled;

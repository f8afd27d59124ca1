//! Numbers that were recorded, so that no change of them goes unnoticed: integrals with their error estimates, breaks,
//! pieces and evaluations of each rule, whole diagnoses, and sentences.
//!
//! That they are right is the matter of the other tests, with closed forms. Where a change is meant, run
//! `RECORD=1 cargo test --release -p symplint recorded::`, and read the difference.

mod diagnoses;
mod maps;
mod record;
mod rules;
mod sentences;
mod snapshots;

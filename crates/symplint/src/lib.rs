//! Tells whether a time-advance map is symplectic.
mod block;
mod breaks;
mod coordinates;
mod defect;
mod diagnosis;
mod ensemble;
mod error;
mod integral;
mod loops;
mod map;
mod random;
mod rows;
pub mod scratch;
mod trace;
mod turn;
mod verdict;

pub use block::Block;
pub use breaks::{Break, find_break};
pub use coordinates::Coordinates;
pub use defect::{Defect, logarithmic_defect};
pub use diagnosis::{
    Diagnosis, Diagnostic, Event, Point, RuleChoice, SampleCount, SampleSweep, Sweep,
};
pub use ensemble::Ensemble;
pub use error::Error;
pub use integral::{Cutoff, Cutoffs, LoopIntegral, OmittedCell, Rule, unwrap_row};
pub use loops::{Circle, FourierLoop, Loop, SampledLoop};
pub use map::{PerSample, StepFailure, TimeAdvance};
pub use rows::{Rows, RowsMut};
pub use trace::{Observable, Orbit, Trace, TracePoint, TraceRecord};
pub use verdict::{Fit, LoopEvidence, StepEvidence, Verdict, VerdictKind, judge};

//! Tells whether a time-advance map is symplectic.
//!
//! A Hamiltonian simulation should preserve the symplectic form. Its time-advance map does
//! if and only if it conserves the Poincaré loop integral ∮ p·dq of every closed loop of initial
//! states. This crate sends loops through one step of a map and compares, while the step size h and
//! the number of samples N_s vary, as in W. Barham & J. Burby, "Diagnosing symplecticity in
//! simulations of high-dimensional Hamiltonian systems".
//!
//! ```text
//! Loop ──sample──▶ Ensemble ──advance(h)──▶ Ensemble ──integrate──▶ I(h)
//!                      │                                             │
//!                      └───────────────── integrate ──▶ I(0) ──compare──▶ Defect
//!                                          sweep over h and N_s ──▶ Verdict
//! ```
//!
//! Each noun is a type: [`Loop`] ([`Circle`], [`FourierLoop`], [`SampledLoop`]), [`Ensemble`],
//! [`TimeAdvance`] for maps ([`PerSample`] wraps a function of one state), [`LoopIntegral`] by a
//! [`Rule`], [`Defect`], and [`Diagnostic`] for the whole line with its [`Verdict`]. [`Trace`] follows
//! a loop in time, and [`JacobianTest`] checks the Jacobian without loop integrals.
//!
//! ```
//! use symplint::{Circle, Diagnostic, PerSample, VerdictKind};
//!
//! // A pendulum by the explicit midpoint rule.
//! let force = |q: f64| -q.sin();
//! let map = PerSample::new(1, move |h, q, p| {
//!     let (q_half, p_half) = (q[0] + 0.5 * h * p[0], p[0] + 0.5 * h * force(q[0]));
//!     q[0] += h * p_half;
//!     p[0] += h * force(q_half);
//! });
//! let circle = Circle::new(vec![1.0], vec![0.5], 1.0)?;
//! let verdict = Diagnostic::default().run(&map, &circle)?.verdict;
//! assert_eq!(verdict.kind, VerdictKind::NotSymplectic);
//! assert_eq!(verdict.order, Some(3.0));
//! # Ok::<(), symplint::Error>(())
//! ```
//!
//! # What is promised
//!
//! * No false verdict: if the numbers do not decide, the verdict is undecided and says what to change.
//! * Every loop integral comes with an estimate of its quadrature error and with its round-off.
//! * Results do not depend on the number of threads, to the last bit. Work is spread over the
//!   current Rayon pool.
//! * Bad input and maps that fail give an [`Error`] with the numbers in it, never a panic.

pub mod breaks;
pub mod diagnosis;
pub mod error;
pub mod evidence;
pub mod field;
pub mod jacobian;
pub mod loops;
pub mod map;
pub mod request;
pub mod rules;
pub mod signal;
pub mod snapshots;
pub mod state;
mod survey;
mod text;
pub mod trace;
pub mod verdict;

pub use diagnosis::Diagnostic;
pub use error::Error;
pub use evidence::Evidence;
pub use jacobian::JacobianTest;
pub use loops::{Circle, FourierLoop, Loop, Phases, SampledLoop};
pub use map::{PerBlock, PerSample, StepFailure, TimeAdvance};
pub use rules::{Defect, LoopIntegral, Rule};
pub use snapshots::Snapshot;
pub use state::{Block, Coordinates, Ensemble};
pub use trace::Trace;
pub use verdict::{Diagnosis, Verdict, VerdictKind, judge, measure};

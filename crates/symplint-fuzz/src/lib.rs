//! Hostile input: for any bytes, each function here returns, and does not panic.
//!
//! libFuzzer calls them from `fuzz/`, and `tests/` runs them on seeds and on mutations of these.
//!
//! | module | the bytes are |
//! | --- | --- |
//! | [`configuration`] | a configuration |
//! | [`npy`], [`npz`], [`csv`] | a file of a loop, or of an initial state |
//! | [`journal`] | a journal, and a round of calls |
//! | [`report`] | what `symplint judge` reads |
//! | [`evidence`] | changes of real evidence: which numbers, lists and variants, and what they become |
//! | [`integrals`] | loops, coordinates and rules |
//! | [`check`] | a map of a few operations, a loop and a diagnostic |
//!
//! If a whole file is refused early, as a journal with one wrong checksum is, the target also makes a valid file of the
//! bytes and damages it.

pub mod check;
pub mod configuration;
pub mod csv;
pub mod evidence;
mod files;
pub mod integrals;
pub mod journal;
mod loops;
pub mod npy;
pub mod npz;
mod numbers;
pub mod report;
pub mod seeds;
mod verdicts;

/// A target: its name, and the function.
pub type Target = (&'static str, fn(&[u8]));

/// All targets.
pub const TARGETS: [Target; 9] = [
    ("configuration", configuration::configuration),
    ("npy", npy::npy),
    ("npz", npz::npz),
    ("csv", csv::csv),
    ("journal", journal::journal),
    ("report", report::report),
    ("evidence", evidence::evidence),
    ("integrals", integrals::integrals),
    ("check", check::check),
];

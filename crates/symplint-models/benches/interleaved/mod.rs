//! A kernel and its control, in turn, so that both see the same machine.
//!
//! Times are of this machine; ratios are what can be claimed.

use std::time::{Duration, Instant};

/// Each case runs this often, in turn with its control; the medians are printed.
const ROUNDS: usize = 11;

/// Long enough for the clock, and for the waking of a second core, about half a millisecond here, to count
/// little; short enough for a round of two to see the same machine.
const SLICE: Duration = Duration::from_millis(15);

/// Prints what the columns of [`report`] are.
pub fn heading(what: &str) {
    println!("{what}; ns, medians of {ROUNDS} interleaved rounds");
    println!(
        "{:<42}{:>10}{:>10}{:>8}",
        "", "symplint", "control", "ratio"
    );
}

/// Prints the time of both, each divided by the size of its data, and the ratio of the two.
pub fn report(
    name: &str,
    units: f64,
    control_units: f64,
    mut work: impl FnMut(),
    mut control: impl FnMut(),
) {
    if !wanted(name) {
        return;
    }
    let (mut times, mut control_times) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        times.push(nanoseconds(&mut work) / units);
        control_times.push(nanoseconds(&mut control) / control_units);
    }
    print_ratio(name, median(times), median(control_times));
}

/// As [`report`], compared with a time that was measured elsewhere.
#[allow(dead_code, reason = "not every bench has one")]
pub fn compare(name: &str, units: f64, mut work: impl FnMut(), control: f64) {
    let times = (0..ROUNDS).map(|_| nanoseconds(&mut work) / units);
    print_ratio(name, median(times.collect()), control);
}

/// Whether the command line asks for this case.
pub fn wanted(name: &str) -> bool {
    let part = std::env::args().skip(1).find(|arg| !arg.starts_with('-'));
    part.is_none_or(|part| name.contains(&part))
}

fn print_ratio(name: &str, time: f64, control: f64) {
    println!(
        "{name:<42}{time:>10.2}{control:>10.2}{:>8.2}",
        control / time
    );
}

/// The time of one call, over as many as fill a slice.
fn nanoseconds(work: &mut impl FnMut()) -> f64 {
    let start = Instant::now();
    let mut calls = 0;
    while calls == 0 || start.elapsed() < SLICE {
        work();
        calls += 1;
    }
    start.elapsed().as_nanos() as f64 / f64::from(calls)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

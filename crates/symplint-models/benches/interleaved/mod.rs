//! A kernel beside its control, in turn, so that both see the same machine.
//!
//! Times are of this machine; ratios are what can be claimed.

use std::time::{Duration, Instant};

/// Each case runs this often, in turn with its control; the medians are printed.
const ROUNDS: usize = 51;

/// Long enough for the clock, short enough for a round of two to see the same machine.
const SLICE: Duration = Duration::from_micros(1000);

/// Prints what the columns of [`report`] are.
pub fn heading(what: &str) {
    println!("{what}; ns, medians of {ROUNDS} interleaved rounds");
    println!(
        "{:<38}{:>10}{:>10}{:>8}",
        "", "symplint", "control", "ratio"
    );
}

/// Prints the time of both, each divided by what it works on, and the ratio of the two.
pub fn report(
    name: &str,
    units: f64,
    control_units: f64,
    mut work: impl FnMut(),
    mut control: impl FnMut(),
) {
    let wanted = std::env::args().skip(1).find(|arg| !arg.starts_with('-'));
    if wanted.is_some_and(|part| !name.contains(&part)) {
        return;
    }
    let (mut times, mut control_times) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        times.push(nanoseconds(&mut work) / units);
        control_times.push(nanoseconds(&mut control) / control_units);
    }
    let (time, control) = (median(times), median(control_times));
    println!(
        "{name:<38}{time:>10.2}{control:>10.2}{:>8.2}",
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

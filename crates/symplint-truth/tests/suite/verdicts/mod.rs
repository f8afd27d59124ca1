//! Cases beyond the truth table: rules chosen by hand, steps that are not evidence, failures, sizes.

mod failures;
mod large;
mod localisation;
mod no_evidence;
mod noise;

mod rounding;
mod rules;
mod streaming;
mod units;
mod wrapping;

use symplint::{Circle, Diagnosis, Diagnostic, Loop, PerSample, TimeAdvance, VerdictKind};

fn diagnose(diagnostic: &Diagnostic, map: &dyn TimeAdvance, phase_loop: &dyn Loop) -> Diagnosis {
    diagnostic.run(map, phase_loop).unwrap()
}

fn circle(q0: &[f64], p0: &[f64], radius: f64) -> Circle {
    Circle::new(q0.to_vec(), p0.to_vec(), radius).unwrap()
}

/// One degree of freedom, step by step, with the default diagnostic on the circle round (0.4, 0.7).
fn verdict_of(
    step: impl Fn(f64, &mut f64, &mut f64) + Send + Sync,
) -> (VerdictKind, Option<f64>, Option<f64>) {
    let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        step(h, &mut q[0], &mut p[0]);
    });
    let verdict = diagnose(&Diagnostic::default(), &map, &circle(&[0.4], &[0.7], 1.0)).verdict;
    (verdict.kind, verdict.order, verdict.digits)
}

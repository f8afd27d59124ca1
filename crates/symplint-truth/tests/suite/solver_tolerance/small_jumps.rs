//! Jumps that are too small to break a loop, 1e-11 of it, bound the digits of a verdict.

use symplint::rules::Piecewise;
use symplint::{Rule, VerdictKind};

use crate::solver_tolerance::diagnose;
use crate::solver_tolerance::midpoint::{Charged, Field, HenonHeiles, Pendulum};
use crate::solver_tolerance::truth::{Circle, truth};

fn check<F: Field>(centre: &'static [f64], radius: f64, step_sizes: &[f64], tolerances: &[f64]) {
    let circle = Circle { centre, radius };
    for &h in step_sizes {
        for &tolerance in tolerances {
            let truth = truth::<F>(&circle, h, tolerance);
            if truth.breaks.is_empty() {
                continue;
            }
            for rule in [Rule::Auto, Rule::Piecewise(Piecewise::default())] {
                let found = diagnose::<F>(&circle, h, tolerance, rule);
                let what = format!("{centre:?}, h = {h}, {tolerance:e}, {:?}", rule);
                let verdict = &found.verdict;
                assert_ne!(
                    verdict.kind,
                    VerdictKind::NotSymplectic,
                    "{what}: {verdict}"
                );
                let point = &found.points()[0];
                let stated = point.quadrature_error.unwrap() + point.roundoff;
                let off = (point.signed_defect - truth.defect).abs();
                assert!(off < stated, "{what}: off by {off:e}, stated {stated:e}");
                if verdict.kind == VerdictKind::Symplectic {
                    let bound = 10f64.powf(-verdict.digits.unwrap());
                    assert!(truth.defect.abs() < bound, "{what}: {verdict}");
                }
            }
        }
    }
}

#[test]
fn jumps_too_small_to_break_a_loop_are_in_the_error() {
    let steps = [1.0, 0.5, 0.25, 0.125];
    check::<Pendulum>(&[0.3, 0.5], 1.0, &steps, &[1e-10, 1e-11]);
    check::<HenonHeiles>(&[0.1, 0.05, 0.2, -0.1], 0.2, &steps[1..], &[1e-10, 1e-11]);
    check::<Charged>(&[0.1, 0.3, 0.4, 0.2], 0.5, &steps[1..], &[1e-10]);
}

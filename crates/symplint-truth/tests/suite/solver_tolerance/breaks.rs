//! Every change of the number of iterations is a break, and the integral between breaks is known to its error.

use symplint::rules::Piecewise;
use symplint::{Rule, VerdictKind};

use crate::solver_tolerance::diagnose;
use crate::solver_tolerance::midpoint::{Charged, Field, HenonHeiles, Pendulum};
use crate::solver_tolerance::truth::{Circle, Truth, truth};

const TOLERANCES: [f64; 5] = [1e-5, 1e-6, 1e-7, 1e-8, 1e-9];

/// True over stated errors of all cases, with the rules that find their own samples.
fn check<F: Field>(centre: &'static [f64], radius: f64, step_sizes: &[f64]) -> Vec<f64> {
    let circle = Circle { centre, radius };
    let mut ratios = Vec::new();
    for &h in step_sizes {
        for tolerance in TOLERANCES {
            let Truth { defect, breaks, .. } = truth::<F>(&circle, h, tolerance);
            if breaks.is_empty() {
                continue;
            }
            for rule in [Rule::Auto, Rule::Piecewise(Piecewise::default())] {
                let found = diagnose::<F>(&circle, h, tolerance, rule);
                let what = format!("{centre:?}, h = {h}, {tolerance:e}, {:?}", rule);
                let point = &found.points()[0];
                assert_eq!(
                    found.verdict.kind,
                    VerdictKind::BrokenLoops,
                    "{what}: {}",
                    found.verdict
                );
                assert_eq!(point.jumps, Some(breaks.len()), "{what}");
                assert!(found.evidence.evaluations.made <= 50_000, "{what}");
                let stated = point.quadrature_error.unwrap() + point.roundoff;
                ratios.push((point.signed_defect - defect).abs() / stated);
                assert!(
                    ratios[ratios.len() - 1] < 1.0,
                    "{what}: {:e} ± {stated:e}, true {defect:e}",
                    point.signed_defect
                );
            }
        }
    }
    ratios
}

#[test]
fn all_breaks_are_found_and_the_integral_between_them_is_known() {
    let ratios = [
        check::<Pendulum>(&[0.3, 0.5], 1.0, &[1.0, 0.5, 0.25, 0.125]),
        check::<HenonHeiles>(&[0.1, 0.05, 0.2, -0.1], 0.2, &[0.5, 0.25, 0.125]),
        check::<Charged>(&[0.1, 0.3, 0.4, 0.2], 0.5, &[0.5, 0.25, 0.125]),
    ]
    .concat();
    // The error allows for as many breaks as were found, so the true one is far below it here, where none is missed.
    assert!(ratios.len() > 80, "{}", ratios.len());
}

#[test]
fn the_truth_of_a_converged_symplectic_step_is_no_defect() {
    let circle = |centre, radius| Circle { centre, radius };
    let defects = [
        truth::<Pendulum>(&circle(&[0.3, 0.5], 1.0), 0.5, 1e-14).defect,
        truth::<HenonHeiles>(&circle(&[0.1, 0.05, 0.2, -0.1], 0.2), 0.5, 1e-14).defect,
        truth::<Charged>(&circle(&[0.1, 0.3, 0.4, 0.2], 0.5), 0.5, 1e-14).defect,
    ];
    assert!(
        defects.iter().all(|defect| defect.abs() < 2e-14),
        "{defects:?}"
    );
}

//! Verdicts on evidence that is written by hand.

use symplint::{Circle, Diagnostic, Evidence, PerSample, VerdictKind, judge};

#[test]
fn without_a_loop_nothing_is_decided() {
    let verdict = judge(&Evidence::default());
    assert_eq!(verdict.kind, VerdictKind::Undecided);
    assert!(verdict.fits.is_empty());
    assert!(verdict.summary().contains("No loop"), "{verdict}");
}

/// Its jumps and its defect are the same at every h.
#[test]
fn a_broken_loop_whose_defect_has_no_trend_has_no_order() {
    let map = PerSample::new(1, |h, q: &mut [f64], p: &mut [f64]| {
        p[0] += 0.1 * (q[0] - 0.2).signum() * (1.0 + q[0]);
        q[0] += h * p[0];
        p[0] *= 0.9;
    });
    let circle = Circle::new(vec![0.1], vec![0.2], 1.0).unwrap();
    let diagnosis = (Diagnostic::halving(-4, -8).run(&map, &circle)).unwrap();
    assert_eq!(diagnosis.verdict.kind, VerdictKind::BrokenLoops);
    assert_eq!(diagnosis.verdict.order, None, "{:?}", diagnosis.fits());
}

//! Rounding is not a defect.

use symplint::{Diagnostic, PerSample, Verdict, VerdictKind};

use crate::verdicts::{circle, diagnose, verdict_of};

#[test]
fn single_precision_is_symplectic_to_single_precision() {
    let (kind, _, digits) = verdict_of(|h, q, p| {
        let (mut x, mut y, h) = (*q as f32, *p as f32, h as f32);
        x += 0.5 * h * y;
        y -= h * x.sin();
        x += 0.5 * h * y;
        (*q, *p) = (f64::from(x), f64::from(y));
    });
    assert_eq!(kind, VerdictKind::Symplectic);
    let digits = digits.unwrap();
    assert!((6.0..9.5).contains(&digits), "{digits} digits");
}

#[test]
fn a_floor_that_rises_as_h_falls_is_no_defect() {
    let (kind, _, _) = verdict_of(|h, q, p| {
        // The kick is formed by dividing by h: its rounding grows as h falls.
        *q += 0.5 * h * *p;
        let kick = ((1.0 / h) + h * q.sin()) - 1.0 / h;
        *p -= kick;
        *q += 0.5 * h * *p;
    });
    assert_ne!(kind, VerdictKind::NotSymplectic);
    assert_ne!(kind, VerdictKind::BrokenLoops);
}

/// The verdict on a pendulum whose momenta are rounded in some way.
fn rounded(round: impl Fn(f64) -> f64 + Send + Sync) -> Verdict {
    let map = PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        p[0] -= h * q[0].sin();
        q[0] += h * p[0];
        p[0] = round(p[0]);
    });
    diagnose(
        &Diagnostic::halving(-1, -6),
        &map,
        &circle(&[0.3], &[0.4], 0.8),
    )
    .verdict
}

#[test]
fn a_map_that_rounds_what_it_returns_is_told_so() {
    let six_decimals = |p: f64| (p * 1e6).round() / 1e6;
    let and_a_product = |p: f64| (p * 1e6).round() * 1e-6;
    let printed = |p: f64| format!("{p:.5e}").parse().unwrap();
    let single = |p: f64| f64::from(p as f32);
    for (name, verdict, to) in [
        ("six decimals", rounded(six_decimals), "about 1e-6"),
        ("and a product", rounded(and_a_product), "about 1e-6"),
        ("printed", rounded(printed), "about 1e-5"),
        ("single precision", rounded(single), "about 1e-7"),
    ] {
        let said = |line: &String| line.contains("rounds what it returns") && line.contains(to);
        assert!(verdict.sentences().iter().any(said), "{name}: {verdict:?}");
        let advised = verdict
            .advice()
            .iter()
            .any(|line| line.contains("17 digits"));
        assert!(advised, "{name}: {verdict:?}");
        assert_ne!(verdict.kind, VerdictKind::NotSymplectic, "{name}");
    }
    let verdict = rounded(|p| p);
    assert!(
        !verdict
            .sentences()
            .iter()
            .any(|line| line.contains("rounds"))
    );
}

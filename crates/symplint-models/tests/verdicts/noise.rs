//! Rounding is no defect.

use symplint::VerdictKind;

use crate::verdict_of;

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

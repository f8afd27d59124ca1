//! Maps written as closures: what they may return and declare.

use std::f64::consts::TAU;

use symplint::error::StateLocation;
use symplint::{
    Circle, Coordinates, Diagnostic, Error, PerBlock, PerSample, StepFailure, TimeAdvance,
    VerdictKind,
};

fn verdict(map: &dyn TimeAdvance, centre: f64) -> VerdictKind {
    let circle = Circle::new(vec![centre], vec![0.5], 1.0).unwrap();
    let diagnosis = Diagnostic::halving(-1, -5).run(map, &circle).unwrap();
    diagnosis.verdict.kind
}

#[test]
fn a_closure_of_a_state_may_fail_and_says_why() {
    let map = PerSample::new(1, |h, q, p| {
        if q[0] > 1.9 {
            return Err(format!("no convergence at q = {:.1}", q[0]));
        }
        p[0] -= h * q[0].sin();
        q[0] += h * p[0];
        Ok(())
    });
    let circle = Circle::new(vec![1.0], vec![0.5], 1.0).unwrap();
    let error = Diagnostic::default().run(&map, &circle).unwrap_err();
    let Error::StepFailed { at, reason, .. } = &error else {
        panic!("{error}");
    };
    let StateLocation::SampleOf { sample, samples } = at else {
        panic!("{error}");
    };
    // q = 1 + sin 2πs is above 1.9 there.
    let s = *sample as f64 / *samples as f64;
    assert!((TAU * s).sin() > 0.9, "{error}");
    assert!(error.to_string().contains(&format!("s = {s:?}")), "{error}");
    assert!(reason.starts_with("no convergence at q = "), "{error}");
}

#[test]
fn declared_periods_make_wrapped_positions_continuous() {
    let step = |h: f64, q: &mut [f64], p: &mut [f64]| {
        p[0] -= h * q[0].sin();
        q[0] = (q[0] + h * p[0]).rem_euclid(TAU);
    };
    // The loop is cut where it leaves the interval.
    assert_eq!(
        verdict(&PerSample::new(1, step), 6.0),
        VerdictKind::BrokenLoops
    );
    let periodic = || Coordinates::plain(1).with_periods(vec![TAU]).unwrap();
    let wrapped = PerSample::new(1, step)
        .with_coordinates(periodic())
        .unwrap();
    assert_eq!(verdict(&wrapped, 6.0), VerdictKind::Symplectic);
    let other = PerSample::new(1, step).with_coordinates(Coordinates::plain(2));
    assert!(matches!(other, Err(Error::Length { .. })));
}

#[test]
fn a_closure_of_a_block_is_that_of_its_states() {
    let of_state = PerSample::new(1, |h, q, p| {
        p[0] -= h * q[0].sin();
        q[0] += h * p[0];
    });
    let of_block = PerBlock::new(1, |h, block| {
        for (q, p) in block.q.row_mut(0).iter_mut().zip(block.p.row_mut(0)) {
            *p -= h * q.sin();
            *q += h * *p;
        }
        Ok(())
    });
    let circle = Circle::new(vec![1.0], vec![0.5], 1.0).unwrap();
    let run = |map: &dyn TimeAdvance| Diagnostic::halving(-1, -5).run(map, &circle).unwrap();
    assert_eq!(run(&of_state).evidence, run(&of_block).evidence);

    let failing = PerBlock::new(1, |_, _| {
        Err(StepFailure {
            sample: 2,
            reason: "out of the table".into(),
        })
    });
    let error = Diagnostic::default().run(&failing, &circle).unwrap_err();
    assert!(error.to_string().contains("out of the table"), "{error}");
}

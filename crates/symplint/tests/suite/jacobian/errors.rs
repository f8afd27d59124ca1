//! Bad input and maps that fail.

use symplint::error::StateLocation;
use symplint::jacobian::JacobianEvidence;
use symplint::{
    Block, Circle, Error, FourierLoop, JacobianTest, PerSample, StepFailure, TimeAdvance,
};

use crate::jacobian::{circle, kick_drift};

#[test]
fn bad_input_is_an_error() {
    let map = kick_drift(|x| -x);
    let unit = circle(1);
    let test = JacobianTest::default();
    for h in [0.0, f64::NAN, f64::INFINITY] {
        let error = test.run(&map, &unit, h).unwrap_err();
        assert!(matches!(
            error,
            Error::OutOfRange {
                what: "step size",
                ..
            }
        ));
    }
    let none = [
        JacobianTest { points: 0, ..test },
        JacobianTest {
            directions: 1,
            ..test
        },
        JacobianTest {
            budget: 8 * 37 - 1,
            ..test
        },
    ];
    for test in none {
        assert!(matches!(
            test.run(&map, &unit, 0.5),
            Err(Error::OutOfRange { .. })
        ));
    }
    let error = test.run(&map, &circle(2), 0.5).unwrap_err();
    assert!(matches!(error, Error::DofMismatch { .. }));
    let flat = FourierLoop::random(vec![1.0], vec![1.0], &[1.0], &[0.0], 1).unwrap();
    // Coordinates that the loop leaves at rest are displaced as the map suggests.
    let found = test.run(&map, &flat, 0.5).unwrap();
    assert!(found.bound.unwrap() < 1e-9, "{found:?}");
}

/// Free motion that fails outside the disc |q| ≤ 1, as a step or by a NaN.
struct OnlyInside(bool);

impl TimeAdvance for OnlyInside {
    fn dof(&self) -> usize {
        1
    }
    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        for sample in 0..block.len() {
            if block.q.row(0)[sample].abs() > 1.0 {
                if self.0 {
                    let reason = "outside".into();
                    return Err(StepFailure { sample, reason });
                }
                block.q.row_mut(0)[sample] = f64::NAN;
            }
            block.q.row_mut(0)[sample] += h * block.p.row(0)[sample];
        }
        Ok(())
    }
}

#[test]
fn a_failure_near_the_loop_names_its_point_and_that_the_state_is_displaced() {
    let unit = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
    for fails in [true, false] {
        let error = JacobianTest::default().run(&OnlyInside(fails), &unit, 0.5);
        let error = error.unwrap_err();
        let displaced = |at| matches!(at, StateLocation::Displaced(_));
        assert!(
            matches!(error, Error::NotFinite { at, .. } | Error::StepFailed { at, .. } if displaced(at)),
            "{error}"
        );
        let text = error.to_string();
        for part in ["s = 0.", "displaced", "h = 0.5"] {
            assert!(text.contains(part), "{text}");
        }
        assert!(!text.contains("sample"), "{text}");
    }
}

#[test]
fn the_form_beyond_double_precision_is_no_form_and_evidence_survives_json() {
    // Both coordinates 1e200 times as large: the determinant overflows.
    let map = PerSample::new(1, |_, q, p| {
        q[0] *= 1e200;
        p[0] *= 1e200;
    });
    let large = JacobianTest::default().run(&map, &circle(1), 0.5).unwrap();
    assert_eq!(large.not_differentiable, large.points.len());
    assert!(large.deformation.is_finite() && large.noise.is_finite());
    let smooth = JacobianTest::default().run(&kick_drift(|x| -x.sin()), &circle(1), 0.5);
    for evidence in [large, smooth.unwrap()] {
        let text = serde_json::to_string(&evidence).unwrap();
        assert!(!text.contains("\"signed\":null"), "{text}");
        let again: JacobianEvidence = serde_json::from_str(&text).unwrap();
        assert_eq!(again, evidence);
        assert_eq!(again.verdict(), evidence.verdict());
    }
}

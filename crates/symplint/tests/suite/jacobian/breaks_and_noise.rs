//! Maps with jumps, kinks and noise: no false verdict.

use symplint::verdict::{InconclusiveReason, JacobianVerdict};
use symplint::{Circle, JacobianTest};

use crate::jacobian::{
    assert_determinant, assert_symplectic, circle, kick_drift, run, single_precision, worst_of,
};

#[test]
fn single_precision_leaves_a_bound() {
    let test = JacobianTest {
        points: 100,
        ..JacobianTest::default()
    };
    for radius in [1.0, 0.1] {
        for phase_loop in [
            Circle::new(vec![0.3], vec![-0.2], radius).unwrap(),
            Circle::new(vec![50.0], vec![0.0], radius).unwrap(),
        ] {
            let report = test.run(&single_precision(1.0), &phase_loop, 0.5).unwrap();
            let JacobianVerdict::Undecided {
                reason: InconclusiveReason::WeakBound { bound, .. },
            } = report.verdict()
            else {
                panic!("{}", report.verdict());
            };
            assert!((1e-6..0.05).contains(&bound), "{bound:e}");
            assert_determinant(&report, 0.0, 0.05);
            // The damped map's determinant is its factor: 0.5 is 0.5 in any precision.
            let damped = test.run(&single_precision(0.5), &phase_loop, 0.5).unwrap();
            assert_determinant(&damped, -0.5, 0.05);
            worst_of(&damped);
        }
    }
}

#[test]
fn single_precision_beyond_its_resolution_makes_no_claim() {
    // Far away from the origin values are coarser than the differences, then than the loop.
    for q in [1e3, 1e4, 1e5, 1e6, 1e7] {
        let phase_loop = Circle::new(vec![q], vec![0.0], 1.0).unwrap();
        let report = run(&single_precision(1.0), &phase_loop, 0.5);
        assert!(
            matches!(report.verdict(), JacobianVerdict::Undecided { .. }),
            "q = {q}: {}",
            report.verdict()
        );
    }
}

#[test]
fn a_wedge_is_symplectic_off_its_break() {
    let test = JacobianTest {
        points: 200,
        ..JacobianTest::default()
    };
    let unit = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
    for h in [1.9, 0.5, 0.1] {
        let report = test.run(&kick_drift(|x| -x.signum()), &unit, h).unwrap();
        assert!(report.not_differentiable <= 1);
        if h > 0.2 {
            assert_symplectic(&report, 9.0);
        } else {
            // The drift alone deforms the loop by h.
            assert!(matches!(
                report.verdict(),
                JacobianVerdict::Undecided {
                    reason: InconclusiveReason::LittleDeformation { .. }
                }
            ));
        }
    }
}

#[test]
fn a_point_on_a_jump_or_kink_is_named_and_left_out() {
    // The first point of the test: the map breaks right there, or within the smallest differences.
    let unit = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
    let s = run(&kick_drift(|x| -x), &unit, 0.5).points[0].s;
    let q = (std::f64::consts::TAU * s).sin();
    for distance in [0.0, 1e-12, 1e-8, -1e-6] {
        let at = q + distance;
        type Force = Box<dyn Fn(f64) -> f64 + Send + Sync>;
        let forces: [(&str, Force); 3] = [
            (
                "jump",
                Box::new(move |x: f64| if x < at { 1.0 } else { -1.0 }),
            ),
            (
                "small jump",
                Box::new(move |x: f64| x.sin() + if x < at { 1e-4 } else { 0.0 }),
            ),
            ("kink", Box::new(move |x: f64| -(x - at).abs())),
        ];
        for (name, force) in forces {
            let report = run(&kick_drift(force), &unit, 0.5);
            assert!(report.not_differentiable >= 1, "{name} at {distance:e}");
            assert!(report.points[0].worst.is_none(), "{name} at {distance:e}");
            assert_symplectic(&report, 9.0);
        }
    }
}

#[test]
fn steps_of_every_size_make_no_false_verdict() {
    // A force in steps, flat between them: symplectic almost everywhere, noise where steps are small.
    for exponent in 0..=14 {
        let width = 10f64.powi(-exponent);
        let map = kick_drift(move |x| -(x / width).floor() * width);
        let verdict = run(&map, &circle(1), 0.5).verdict();
        assert!(
            !matches!(verdict, JacobianVerdict::NotSymplectic { .. }),
            "steps of {width:e}: {verdict}"
        );
    }
}

#[test]
fn a_map_without_derivatives_is_told() {
    let rough = |x: f64| {
        (0..30)
            .map(|k| (2f64.powi(k) * 7.0 * x).sin().abs() * 0.8f64.powi(k))
            .sum()
    };
    let report = run(&kick_drift(rough), &circle(1), 0.5);
    assert!(
        matches!(
            report.verdict(),
            JacobianVerdict::Undecided {
                reason: InconclusiveReason::NoDerivative { .. }
                    | InconclusiveReason::WeakBound { .. }
            }
        ),
        "{}",
        report.verdict()
    );
}

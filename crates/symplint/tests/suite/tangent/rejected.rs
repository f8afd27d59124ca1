//! Tangent maps that do not belong to their map.

use symplint::error::StateLocation;
use symplint::jacobian::{JacobianMethod, TangentRejection};
use symplint::map::{Capabilities, TangentMap};
use symplint::verdict::JacobianVerdict;
use symplint::{Block, Error, JacobianTest, StepFailure, TimeAdvance};

use crate::tangent::given::Given;
use crate::tangent::{circle, run};

/// The pendulum kicked, then drifting, with what its tangent map adds to the tangent vector by mistake.
fn pendulum(mistake: impl Fn([f64; 2]) -> f64 + Send + Sync) -> impl TimeAdvance {
    let step = |h: f64, [q, p]: [f64; 2]| {
        let p = p - h * q.sin();
        [q + h * p, p]
    };
    Given {
        step,
        tangent: move |h, z: [f64; 2], [dq, dp]: [f64; 2]| {
            let dp = dp - h * z[0].cos() * dq + mistake(z) * dq;
            (step(h, z), [dq + h * dp, dp])
        },
        period: 0.0,
    }
}

#[test]
fn a_wrong_tangent_map_is_found_out_and_not_used() {
    let right = run(&pendulum(|_| 0.0), 0.5);
    assert_eq!(right.method, JacobianMethod::TangentMap);
    let JacobianVerdict::SymplecticAlmostEverywhere { digits } = right.verdict() else {
        panic!("{}", right.verdict());
    };
    assert!(digits >= 14.0, "{digits}");

    // Everywhere, in part of phase space, or by a little: the differences say the same of the map.
    type Mistake = fn([f64; 2]) -> f64;
    let mistakes: [Mistake; 4] = [
        |_| 1e-3,
        |_| 1e-8,
        |[q, _]| if q < 0.0 { 0.1 } else { 0.0 },
        |[_, p]| 1e-4 * p,
    ];
    for (k, mistake) in mistakes.into_iter().enumerate() {
        let wrong = run(&pendulum(mistake), 0.5);
        let JacobianMethod::CentralDifferences {
            rejected:
                Some(TangentRejection::WrongDerivative {
                    difference: off, ..
                }),
        } = wrong.method
        else {
            panic!("mistake {k}: {}", wrong.method);
        };
        assert!(off > 1e-10 && off < 0.2, "mistake {k}: {off:e}");
        let JacobianVerdict::SymplecticAlmostEverywhere { digits } = wrong.verdict() else {
            panic!("mistake {k}: {}", wrong.verdict());
        };
        assert!((10.0..13.0).contains(&digits), "mistake {k}: {digits}");
    }
}

#[test]
fn a_wrong_tangent_map_makes_no_map_symplectic() {
    // The wrong sign in the map, the right one in the tangent map.
    let map = Given {
        step: |h: f64, [q, p]: [f64; 2]| [q + h * (p + h * q.sin()), p - h * q.sin()],
        tangent: |h: f64, [q, p]: [f64; 2], [dq, dp]: [f64; 2]| {
            let dp_new = dp - h * q.cos() * dq;
            let state = [q + h * (p + h * q.sin()), p - h * q.sin()];
            (state, [dq + h * dp_new, dp_new])
        },
        period: 0.0,
    };
    let report = run(&map, 0.5);
    assert!(matches!(
        report.verdict(),
        JacobianVerdict::NotSymplectic { .. }
    ));
    let text = report.method.to_string();
    assert!(text.contains("not the derivative of the map"), "{text}");
}

#[test]
fn a_tangent_map_that_moves_states_otherwise_is_not_used() {
    let step = |h: f64, [q, p]: [f64; 2]| [q + h * p, p];
    let map = Given {
        step,
        tangent: move |h, [q, p]: [f64; 2], u| ([q + h * p + 1e-9, p], step(h, u)),
        period: 0.0,
    };
    let rejected = match run(&map, 0.5).method {
        JacobianMethod::CentralDifferences { rejected } => rejected,
        JacobianMethod::TangentMap => None,
    };
    assert!(
        matches!(rejected, Some(TangentRejection::WrongState { difference: off, .. }) if (0.9e-9..1.1e-9).contains(&off)),
        "{rejected:?}"
    );
    // Whole periods are no other state.
    let rotor = |turns: f64| Given {
        step,
        tangent: move |h, [q, p]: [f64; 2], u| ([q + h * p + turns, p], step(h, u)),
        period: 1.0,
    };
    let wrapped = run(&rotor(3.0), 0.5).method;
    assert_eq!(wrapped, JacobianMethod::TangentMap);
}

#[test]
fn a_tangent_map_that_cannot_be_checked_is_not_used() {
    // Stairs of a millionth: flat almost everywhere, and of the slope of a line to any difference.
    let stairs = |q: f64| (q * 1e6).floor() * 1e-6;
    let step = move |h: f64, [q, p]: [f64; 2]| {
        let p = p - h * stairs(q);
        [q + h * p, p]
    };
    let map = Given {
        step,
        tangent: move |h, z, [dq, dp]: [f64; 2]| (step(h, z), [dq + h * dp, dp]),
        period: 0.0,
    };
    let report = run(&map, 0.5);
    assert!(
        matches!(
            report.method,
            JacobianMethod::CentralDifferences { rejected: Some(_) }
        ),
        "{}",
        report.method
    );
    assert!(!matches!(
        report.verdict(),
        JacobianVerdict::NotSymplectic { .. }
    ));
}

#[test]
fn a_step_that_fails_for_tangents_is_an_error_that_says_where() {
    struct Failing;
    impl TimeAdvance for Failing {
        fn dof(&self) -> usize {
            1
        }
        fn advance(&self, _h: f64, _block: &mut Block<'_>) -> Result<(), StepFailure> {
            Ok(())
        }

        fn capabilities(&self) -> Capabilities<'_> {
            Capabilities {
                tangent: Some(self),
                ..Capabilities::plain(self.dof())
            }
        }
    }
    impl TangentMap for Failing {
        fn advance_tangents(
            &self,
            _h: f64,
            _states: &mut Block<'_>,
            _tangents: &mut Block<'_>,
        ) -> Result<(), StepFailure> {
            Err(StepFailure {
                sample: 7,
                reason: "no reason".into(),
            })
        }
    }
    let error = JacobianTest::default().run(&Failing, &circle(1), 0.5);
    let error = error.unwrap_err();
    assert!(
        matches!(
            error,
            Error::StepFailed {
                at: StateLocation::Loop(_),
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn a_tangent_vector_that_is_no_number_is_no_derivative() {
    // NaN where q < 0, with the right states everywhere.
    let report = run(
        &pendulum(|[q, _]| if q < 0.0 { f64::NAN } else { 0.0 }),
        0.5,
    );
    let JacobianVerdict::SymplecticAlmostEverywhere { digits } = report.verdict() else {
        panic!("{}", report.verdict());
    };
    // By differences, or at the points where the tangent map is one.
    assert!(digits >= 10.0, "{digits}");
    assert!(report.bound.is_some_and(f64::is_finite));
}

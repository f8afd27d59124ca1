//! The Jacobian test by tangent maps: digits and error bars; kinks; tangent maps that are refused.

#[allow(dead_code, reason = "the other test uses the rest")]
mod given;
mod rejected;

use crate::dual::{Method, SYSTEMS, Step, System};
use given::Given;
use symplint::jacobian::{JacobianEvidence, JacobianMethod, TangentDefect};
use symplint::state::RowsMut;
use symplint::verdict::{InconclusiveReason, JacobianVerdict};
use symplint::{Block, Circle, JacobianTest, Loop, TimeAdvance};

fn circle(dof: usize) -> Circle {
    let circle = Circle::new(vec![0.3; dof], vec![-0.2; dof], 1.0).unwrap();
    circle.with_phases(symplint::Phases::Random { seed: 4 })
}

fn run(map: &dyn TimeAdvance, h: f64) -> JacobianEvidence {
    JacobianTest::default()
        .run(map, &circle(map.dof()), h)
        .unwrap()
}

fn found(report: &JacobianEvidence) -> impl Iterator<Item = TangentDefect> {
    report.points.iter().map(|point| point.worst.unwrap())
}

#[test]
fn error_bars_hold_the_closed_form() {
    let test = JacobianTest {
        points: 100,
        ..JacobianTest::default()
    };
    for system in SYSTEMS {
        for method in [Method::SymplecticEuler, Method::Strang] {
            for h in [0.9, 0.5, 0.3, 0.123] {
                for (centre, radius) in [(0.3, 1.0), (0.3, 0.01), (7.0, 0.5)] {
                    let map = Step(system, method);
                    let dof = map.dof();
                    let circle = Circle::new(vec![centre; dof], vec![-0.2; dof], radius).unwrap();
                    let report = test.run(&map, &circle, h).unwrap();
                    let mut worst = 0.0_f64;
                    for found in found(&report) {
                        let name = format!("{map:?}, h = {h}, {radius} round {centre}: {found:?}");
                        assert!(found.magnitude() <= found.uncertainty, "{name}");
                        worst = worst.max(found.uncertainty);
                    }
                    // Terms of the form are products of two components.
                    let growth = (1.0 + report.deformation).powi(2);
                    assert!(worst <= 1e-14 * growth, "{map:?}, h = {h}: {worst:e}");
                }
            }
        }
    }
}

#[test]
fn round_off_that_a_step_enlarges_is_in_the_error_bars() {
    // Chaotic steps, undone one by one, and a step of a pendulum: symplectic, with entries of the size of
    // 1 that have been through much larger ones.
    fn kick(tau: f64, [q, p]: [f64; 2], [dq, dp]: [f64; 2]) -> ([f64; 2], [f64; 2]) {
        ([q, p - tau * q.sin()], [dq, dp - tau * q.cos() * dq])
    }
    fn drift(tau: f64, [q, p]: [f64; 2], [dq, dp]: [f64; 2]) -> ([f64; 2], [f64; 2]) {
        ([q + tau * p, p], [dq + tau * dp, dp])
    }
    let map = |count: usize| {
        let tangent = move |h: f64, mut z: [f64; 2], mut u: [f64; 2]| {
            for _ in 0..count {
                (z, u) = kick(2.0, z, u);
                (z, u) = drift(2.0, z, u);
            }
            for _ in 0..count {
                (z, u) = drift(-2.0, z, u);
                (z, u) = kick(-2.0, z, u);
            }
            (z, u) = kick(h, z, u);
            drift(h, z, u)
        };
        Given {
            step: move |h, z| tangent(h, z, [0.0; 2]).0,
            tangent,
            period: 0.0,
        }
    };
    let test = JacobianTest {
        points: 400,
        ..JacobianTest::default()
    };
    let mut largest = 0.0_f64;
    for count in [1, 3, 5] {
        let report = test.run(&map(count), &circle(1), 0.5).unwrap();
        assert_eq!(report.method, JacobianMethod::TangentMap);
        for found in found(&report) {
            assert!(found.magnitude() <= found.uncertainty, "{count}: {found:?}");
            largest = largest.max(found.magnitude());
        }
    }
    // Without what the trials show, a few 1e-15 would be left.
    assert!(largest > 1e-13, "{largest:e}");
}

#[test]
fn tangent_vectors_of_single_precision_are_derivatives() {
    // Chaotic steps, undone one by one, as above.
    let tangent = |h: f64, z: [f64; 2], u: [f64; 2]| {
        let [mut q, mut p] = z.map(|x| x as f32);
        let [mut dq, mut dp] = u.map(|x| x as f32);
        let mut kick_and_drift = |tau: f32, kick_first: bool| {
            for is_kick in [kick_first, !kick_first] {
                match is_kick {
                    true => (p, dp) = (p - tau * q.sin(), dp - tau * q.cos() * dq),
                    false => (q, dq) = (q + tau * p, dq + tau * dp),
                }
            }
        };
        kick_and_drift(2.0, true);
        kick_and_drift(2.0, true);
        kick_and_drift(-2.0, false);
        kick_and_drift(-2.0, false);
        kick_and_drift(h as f32, true);
        ([q, p].map(f64::from), [dq, dp].map(f64::from))
    };
    let map = Given {
        step: move |h, z| tangent(h, z, [0.0; 2]).0,
        tangent,
        period: 0.0,
    };
    let report = run(&map, 0.5);
    assert_eq!(report.method, JacobianMethod::TangentMap);
    assert_eq!(report.not_differentiable, 0, "{report:?}");
    for found in found(&report) {
        assert!(found.magnitude() <= found.uncertainty, "{found:?}");
        assert!(found.uncertainty < 1e-3, "{found:?}");
    }
}

#[test]
fn round_off_of_a_linear_map_is_in_the_error_bars() {
    // Squeezes by shears, undone one by one: tangent vectors round in the same way from every state.
    fn shear([q, p]: [f64; 2], a: f64, b: f64) -> [f64; 2] {
        let p = p + a * q;
        [q + b * p, p]
    }
    fn unshear([q, p]: [f64; 2], a: f64, b: f64) -> [f64; 2] {
        let q = q - b * p;
        [q, p - a * q]
    }
    let step = |h: f64, mut z: [f64; 2]| {
        for k in 0..5 {
            z = shear(z, 2.3 + 0.1 * f64::from(k), 1.7);
        }
        for k in (0..5).rev() {
            z = unshear(z, 2.3 + 0.1 * f64::from(k), 1.7);
        }
        shear(z, -h, h)
    };
    let map = Given {
        step,
        tangent: move |h, z, u| (step(h, z), step(h, u)),
        period: 0.0,
    };
    let random = JacobianTest {
        points: 200,
        full_up_to: 0,
        ..JacobianTest::default()
    };
    let report = random.run(&map, &circle(1), 0.5).unwrap();
    assert_eq!(report.method, JacobianMethod::TangentMap);
    let mut largest = 0.0_f64;
    for found in found(&report) {
        assert!(found.magnitude() <= found.uncertainty, "{found:?}");
        largest = largest.max(found.magnitude());
    }
    assert!(largest > 1e-12, "{largest:e}");
}

#[test]
fn the_midpoint_rule_on_a_spring_has_its_determinant() {
    // det DΦ = 1 + h⁴/4, a number without rounding for these h.
    for h in [2.0, 1.0, 0.5, 0.25, -0.5, 0.125] {
        let spring = Given {
            step: move |h: f64, [q, p]: [f64; 2]| {
                let (q_half, p_half) = (q + 0.5 * h * p, p - 0.5 * h * q);
                [q + h * p_half, p - h * q_half]
            },
            tangent: move |h: f64, [q, p]: [f64; 2], [dq, dp]: [f64; 2]| {
                let step = |[q, p]: [f64; 2]| {
                    let (q_half, p_half) = (q + 0.5 * h * p, p - 0.5 * h * q);
                    [q + h * p_half, p - h * q_half]
                };
                (step([q, p]), step([dq, dp]))
            },
            period: 0.0,
        };
        let report = run(&spring, h);
        assert_eq!(report.method, JacobianMethod::TangentMap);
        for found in found(&report) {
            let exact = h.powi(4) / 4.0;
            assert!(
                (found.signed - exact).abs() <= found.uncertainty,
                "{found:?}"
            );
            assert!(
                found.uncertainty < 1e-14 * (1.0 + h * h).powi(2),
                "{found:?}"
            );
        }
    }
}

#[test]
fn a_kink_that_is_nearer_than_differences_reach_leaves_the_derivative() {
    let unit = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
    let kinked = |at: f64| {
        let slope = move |q: f64| if q < at { -1.0 } else { 1.0 };
        let step = move |h: f64, [q, p]: [f64; 2]| {
            let p = p - h * slope(q) * (q - at);
            [q + h * p, p]
        };
        Given {
            step,
            tangent: move |h, z: [f64; 2], [dq, dp]: [f64; 2]| {
                let dp = dp - h * slope(z[0]) * dq;
                (step(h, z), [dq + h * dp, dp])
            },
            period: 0.0,
        }
    };
    let test = JacobianTest::default();
    let s = test.run(&kinked(0.0), &unit, 0.5).unwrap().points[0].s;
    let (mut q, mut p) = ([0.0], [0.0]);
    let rows = RowsMut::new(&mut q, 1, 1, 1);
    unit.sample(&[s], &mut Block::new(rows, RowsMut::new(&mut p, 1, 1, 1)));
    let q = q[0];
    for distance in [1e-12, 1e-8, -1e-6] {
        let report = test.run(&kinked(q + distance), &unit, 0.5).unwrap();
        assert_eq!(report.method, JacobianMethod::TangentMap);
        assert_eq!(report.not_differentiable, 0, "{distance:e}");
        assert!(report.bound.unwrap() < 1e-14);
    }
    // On the kink itself the last digit of the state decides, and nothing is claimed there.
    let report = test.run(&kinked(q), &unit, 0.5).unwrap();
    assert_eq!(report.method, JacobianMethod::TangentMap);
    assert_eq!(report.not_differentiable, 1);
    assert!(report.points[0].worst.is_none());
}

#[test]
fn the_cost_is_known_beforehand() {
    for system in SYSTEMS {
        let map = Step(system, Method::Strang);
        let directions = 2 * map.dof();
        assert_eq!(run(&map, 0.3).evaluations, 8 * (25 + 7 * directions));
        let random = JacobianTest {
            full_up_to: 0,
            ..JacobianTest::default()
        };
        let report = random.run(&map, &circle(map.dof()), 0.3).unwrap();
        assert_eq!(report.evaluations, random.evaluations(map.dof(), true));
        assert_eq!(report.evaluations, 8 * (25 + 7 * 4));
        assert!(report.bound.unwrap() < 1e-12, "{system:?}");
    }
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let test = JacobianTest {
        points: 400,
        ..JacobianTest::default()
    };
    let map = Step(System::HenonHeiles, Method::Heun);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let run = || test.run(&map, &circle(2), 0.3).unwrap();
        pool.unwrap().install(run)
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn a_step_that_deforms_nothing_tests_nothing() {
    let map = Given {
        step: |h: f64, [q, p]: [f64; 2]| [q + h, p],
        tangent: |h: f64, [q, p]: [f64; 2], u: [f64; 2]| ([q + h, p], u),
        period: 0.0,
    };
    assert!(matches!(
        run(&map, 0.5).verdict(),
        JacobianVerdict::Undecided {
            reason: InconclusiveReason::LittleDeformation { .. }
        }
    ));
}

#[test]
fn small_defects_are_told_from_none() {
    // Momenta are stretched by so much: det DΦ − 1.
    let stretched = |by: f64| {
        let step = move |h: f64, [q, p]: [f64; 2]| {
            let p = (p - h * q.sin()) * (1.0 + by);
            [q + h * p, p]
        };
        let tangent = move |h: f64, z: [f64; 2], [dq, dp]: [f64; 2]| {
            let dp = (dp - h * z[0].cos() * dq) * (1.0 + by);
            (step(h, z), [dq + h * dp, dp])
        };
        Given {
            step,
            tangent,
            period: 0.0,
        }
    };
    for by in [1e-6, 1e-9, 3e-12] {
        match run(&stretched(by), 0.5).verdict() {
            JacobianVerdict::NotSymplectic { worst } => {
                assert!((worst.signed - by).abs() <= worst.uncertainty, "{worst:?}");
            }
            other => panic!("{by:e}: {other}"),
        }
    }
    // A smaller defect can be round-off of an iterative solver, and only bounds the digits.
    match run(&stretched(3e-13), 0.5).verdict() {
        JacobianVerdict::SymplecticAlmostEverywhere { digits } => assert_eq!(digits, 12.5),
        other => panic!("{other}"),
    }
}

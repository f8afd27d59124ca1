//! Differences compared with the exact Jacobians of the same steps by dual numbers.

use symplint::JacobianTest;
use symplint::jacobian::{JacobianEvidence, JacobianMethod};

use crate::dual::{METHODS, SYSTEMS, Step};
use crate::jacobian::{Bare, assert_symplectic, circle, worst_of};

/// Two tests of one map agree within their error bars at every point.
#[track_caller]
fn assert_consistent(name: &str, a: &JacobianEvidence, b: &JacobianEvidence) {
    for (a, b) in a.points.iter().zip(&b.points) {
        let (x, y) = (a.worst.unwrap(), b.worst.unwrap());
        // The worst of either need not be the same pair, but neither exceeds the other's bound.
        for (x, other) in [(x, b), (y, a)] {
            assert!(
                x.magnitude() - x.uncertainty <= other.bound.unwrap(),
                "{name} at {}: {x:?} and {other:?}",
                a.s
            );
        }
    }
}

#[test]
fn differences_agree_with_dual_numbers() {
    let test = JacobianTest {
        points: 24,
        ..JacobianTest::default()
    };
    for system in SYSTEMS {
        for method in METHODS {
            let map = Step(system, method);
            let phase_loop = circle(system.dof()).with_phases(symplint::Phases::Random { seed: 4 });
            let exact = test.run(&map, &phase_loop, 0.5).unwrap();
            let differences = test.run(&Bare(map), &phase_loop, 0.5).unwrap();
            let name = format!("{system:?}, {method:?}");
            assert_eq!(exact.method, JacobianMethod::TangentMap, "{name}");
            assert_consistent(&name, &exact, &differences);
            for (exact, found) in exact.points.iter().zip(&differences.points) {
                let (exact, found) = (exact.worst.unwrap(), found.worst.unwrap());
                assert!(exact.uncertainty < 2e-13, "{name}: {exact:?}");
                assert!(found.uncertainty < 1e-9, "{name}: {found:?}");
            }
            if method.is_symplectic() {
                assert_symplectic(&differences, 9.0);
                assert_symplectic(&exact, 13.0);
            } else {
                assert!(worst_of(&exact).dofs.is_some(), "{name}");
                assert_eq!(worst_of(&exact).dofs, worst_of(&differences).dofs, "{name}");
            }
        }
    }
}

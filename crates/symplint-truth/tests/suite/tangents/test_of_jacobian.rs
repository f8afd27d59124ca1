//! The Jacobian test of the library's own maps: by tangent map and by differences.

use rayon::prelude::*;
use symplint::jacobian::{JacobianEvidence, JacobianMethod};
use symplint::map::Capabilities;
use symplint::verdict::JacobianVerdict;
use symplint::{Block, Circle, JacobianTest, StepFailure, TimeAdvance};

use crate::tangents::systems::{Subject, all};

/// A map without its tangent map.
struct Bare<M>(M);

impl<M: TimeAdvance> TimeAdvance for Bare<M> {
    fn dof(&self) -> usize {
        self.0.dof()
    }
    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.0.advance(h, block)
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities::of_coordinates(self.0.capabilities().coordinates)
    }
}

fn report(subject: &Subject, map: &dyn TimeAdvance) -> JacobianEvidence {
    let (q, p) = subject.at.clone();
    let circle = Circle::new(q, p, 0.1)
        .unwrap()
        .with_phases(symplint::Phases::Random { seed: 3 });
    JacobianTest::default().run(map, &circle, 0.5).unwrap()
}

#[test]
fn tangent_maps_are_confirmed_and_say_the_same_with_more_digits() {
    all().into_par_iter().for_each(|subject| {
        for (name, info, map) in subject.maps() {
            let exact = report(&subject, &map);
            assert_eq!(exact.method, JacobianMethod::TangentMap, "{name}");
            let differences = report(&subject, &Bare(&map));
            for (a, b) in exact.points.iter().zip(&differences.points) {
                let (Some(x), Some(y)) = (a.worst, b.worst) else {
                    assert!(!subject.nonlinear || a.worst.is_some(), "{name} at {}", a.s);
                    continue;
                };
                for (x, other) in [(x, b), (y, a)] {
                    let least = x.magnitude() - x.uncertainty;
                    assert!(least <= other.bound.unwrap(), "{name} at {}", a.s);
                }
            }
            let (fine, coarse) = (exact.bound.unwrap(), differences.bound.unwrap());
            if info.symplectic && subject.name != "rotational force" {
                // Terms of the form are products of two components.
                let growth = (1.0 + exact.deformation).powi(2);
                assert!(fine < 4e-14 * growth, "{name}: {fine:e} of {growth:e}");
                assert!(fine < 0.1 * coarse, "{name}: {fine:e} and {coarse:e}");
                let wrong = matches!(exact.verdict(), JacobianVerdict::NotSymplectic { .. });
                assert!(!wrong, "{name}: {}", exact.verdict());
            }
        }
    });
}

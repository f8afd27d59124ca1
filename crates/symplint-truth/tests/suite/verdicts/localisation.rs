//! Which substep a defect comes from.

use std::sync::Arc;

use symplint::evidence::SubstepDefect;
use symplint::{Diagnostic, TimeAdvance};
use symplint_models::integrators::catalogue::build;
use symplint_models::maps::DampedMap;
use symplint_models::systems::{AbsoluteValue, Pendulum, RotationalForce};
use symplint_models::{Model, Separable};

use crate::verdicts::{circle, diagnose};

fn stages(map: &dyn TimeAdvance, dof: usize) -> Vec<SubstepDefect> {
    let (q0, p0) = (vec![0.2; dof], vec![0.1; dof]);
    let found = diagnose(&Diagnostic::halving(-1, -4), map, &circle(&q0, &p0, 1.0));
    found
        .evidence
        .localisation
        .map_or(Vec::new(), |found| found.substeps)
}

fn is_conserved(stage: &SubstepDefect) -> bool {
    stage.change.abs() < 1e-12 && stage.uncertainty.unwrap() < 1e-10
}

#[test]
fn friction_is_the_substep_that_shrinks_areas() {
    let pendulum: Arc<dyn Separable> = Arc::new(Pendulum::default());
    let map = DampedMap::new(build("strang", None, pendulum).unwrap(), 0.1).unwrap();
    let [drift, kick, other, friction] = &stages(&map, 1)[..] else {
        panic!("three flows and a friction");
    };
    assert!([drift, kick, other].into_iter().all(is_conserved));
    assert_eq!(
        (&*kick.name, &*other.name, &*friction.name),
        ("kick of h", "drift of 0.5 h", "friction")
    );
    // Everything shrinks by exp(−γh).
    assert!((friction.change - (-0.05f64).exp_m1()).abs() < 1e-14);
}

#[test]
fn a_force_without_a_potential_is_found_in_the_kick() {
    let force = Model::Forced(Arc::new(RotationalForce::new(0.3).unwrap()));
    let map = build("strang", None, force).unwrap();
    let [drift, kick, other] = &stages(&*map, 2)[..] else {
        panic!("three flows");
    };
    assert!(is_conserved(drift) && is_conserved(other));
    assert!(kick.change.abs() > 1e-2, "{kick:?}");
}

#[test]
fn a_force_that_jumps_breaks_the_loop_in_the_kick() {
    let wedge: Arc<dyn Separable> = Arc::new(AbsoluteValue::new(0.0).unwrap());
    for (variant, breaks) in [("position-first", [0, 2, 2]), ("momentum-first", [2, 2, 4])] {
        let map = build("strang", Some(variant), Arc::clone(&wedge)).unwrap();
        let found = stages(&*map, 1);
        assert_eq!(found.iter().map(|s| s.breaks).collect::<Vec<_>>(), breaks);
        // With the breaks closed every flow is symplectic.
        assert!(found.iter().all(is_conserved), "{found:?}");
    }
}

#[test]
fn nothing_is_looked_for_where_nothing_is_wrong() {
    let pendulum: Arc<dyn Separable> = Arc::new(Pendulum::default());
    assert!(stages(&*build("strang", None, Arc::clone(&pendulum)).unwrap(), 1).is_empty());
    // A Runge–Kutta step is one whole.
    assert!(stages(&*build("rk2", None, pendulum).unwrap(), 1).is_empty());
}

//! Inverses, adjoints, repetitions and compositions.

use crate::common::{State, distance, stepped};
use crate::rotor::Rotor;
use proptest::prelude::*;
use symplint::map::Repeat;
use symplint::{Circle, Coordinates, Ensemble, TimeAdvance};
use symplint_models::ModelError;
use symplint_models::integrators::{RungeKutta, Splitting, Variant, splitting_methods, tableaus};
use symplint_models::maps::{Adjoint, Compose, DampedMap, Inverse, Invertible, SinglePrecision};
use symplint_models::systems::{AbsoluteValue, HenonHeiles, Pendulum, PendulumArray};

const VARIANTS: [Variant; 2] = [Variant::PositionFirst, Variant::MomentumFirst];

type Map = Splitting<HenonHeiles>;

/// Every splitting method, for Hénon–Heiles.
fn splittings() -> Vec<Map> {
    let methods = [
        splitting_methods::lie_trotter,
        splitting_methods::strang,
        splitting_methods::mclachlan4,
        splitting_methods::yoshida4,
        splitting_methods::yoshida6,
        splitting_methods::yoshida8,
    ];
    let methods = methods.iter().flat_map(|method| VARIANTS.map(method));
    methods
        .map(|method| Splitting::new(method, HenonHeiles))
        .collect()
}

fn lie_trotter(variant: Variant) -> Map {
    Splitting::new(splitting_methods::lie_trotter(variant), HenonHeiles)
}

fn strang(variant: Variant) -> Map {
    Splitting::new(splitting_methods::strang(variant), HenonHeiles)
}

fn state() -> impl Strategy<Value = State> {
    let pair = || prop::collection::vec(-0.4_f64..0.4, 2);
    (pair(), pair())
}

proptest! {
    #[test]
    fn an_inverse_returns_the_state(start in state(), h in -0.3_f64..0.3) {
        for map in splittings() {
            let there = stepped(&map, h, &start);
            prop_assert!(distance(&stepped(&Inverse(&map), h, &there), &start) < 2e-14);
            let there = stepped(&Inverse(&map), h, &start);
            prop_assert!(distance(&stepped(&Inverse(Inverse(&map)), h, &there), &start) < 2e-14);
        }
        let [first, second] = VARIANTS.map(lie_trotter);
        let sequence = Compose::new(vec![(0.4, &first), (0.7, &second), (-0.3, &first)]).unwrap();
        let several = Repeat::new(sequence, 3).unwrap();
        let there = stepped(&several, h, &start);
        prop_assert!(distance(&there, &start) > 1e-3 * h.abs() * distance(&start, &(vec![0.0; 2], vec![0.0; 2])));
        prop_assert!(distance(&stepped(&Inverse(several), h, &there), &start) < 2e-14);
    }

    #[test]
    fn the_adjoint_of_the_adjoint_is_the_map(start in state(), h in -0.3_f64..0.3) {
        for map in splittings() {
            let twice = Adjoint(Adjoint(&map));
            prop_assert_eq!(stepped(&twice, h, &start), stepped(&map, h, &start));
            // Φ*_h is the inverse of Φ_{−h}.
            let back = stepped(&map, -h, &stepped(&Adjoint(&map), h, &start));
            prop_assert!(distance(&back, &start) < 2e-14);
            let back = stepped(&Inverse(Adjoint(&map)), h, &stepped(&Adjoint(&map), h, &start));
            prop_assert!(distance(&back, &start) < 2e-14);
        }
    }

    #[test]
    fn lie_trotter_variants_are_adjoint_and_make_strang(start in state(), h in -0.3_f64..0.3) {
        let [position, momentum] = VARIANTS.map(lie_trotter);
        prop_assert_eq!(
            stepped(&Adjoint(&position), h, &start),
            stepped(&momentum, h, &start)
        );
        let halves = Compose::new(vec![(0.5, &position), (0.5, &momentum)]).unwrap();
        let strang = strang(Variant::PositionFirst);
        prop_assert!(distance(&stepped(&halves, h, &start), &stepped(&strang, h, &start)) < 1e-15);
    }

    #[test]
    fn symmetric_methods_are_their_own_adjoints(start in state(), h in -0.3_f64..0.3) {
        // All but the two variants of Lie–Trotter.
        for map in &splittings()[2..] {
            let difference = distance(&stepped(&Adjoint(map), h, &start), &stepped(map, h, &start));
            prop_assert!(difference < 2e-14, "{}: {difference:e}", map.method().name());
        }
    }

    #[test]
    fn composition_reproduces_the_composed_methods(start in state(), h in -0.3_f64..0.3) {
        for variant in VARIANTS {
            let step = strang(variant);
            let outer = 1.0 / (2.0 - 2.0_f64.cbrt());
            let fractions = [outer, 1.0 - 2.0 * outer, outer];
            let parts = fractions.iter().map(|&fraction| (fraction, &step)).collect();
            let composed = Compose::new(parts).unwrap();
            let yoshida = Splitting::new(splitting_methods::yoshida4(variant), HenonHeiles);
            prop_assert!(distance(&stepped(&composed, h, &start), &stepped(&yoshida, h, &start)) < 1e-14);
            // McLachlan's method as HLW write it: the step and its adjoint in turn.
            let base = lie_trotter(match variant {
                Variant::PositionFirst => Variant::MomentumFirst,
                Variant::MomentumFirst => Variant::PositionFirst,
            });
            let root = 19.0_f64.sqrt();
            let beta = [
                (14.0 - root) / 108.0,
                (-23.0 - 20.0 * root) / 270.0,
                0.2,
                (-2.0 + 10.0 * root) / 135.0,
                (146.0 + 5.0 * root) / 540.0,
            ];
            let mut parts: Vec<(f64, Box<dyn Invertible>)> = Vec::new();
            for i in 0..5 {
                parts.push((beta[i], Box::new(Adjoint(base.clone()))));
                parts.push((beta[4 - i], Box::new(base.clone())));
            }
            let composed = Compose::new(parts).unwrap();
            let mclachlan = Splitting::new(splitting_methods::mclachlan4(variant), HenonHeiles);
            prop_assert!(distance(&stepped(&composed, h, &start), &stepped(&mclachlan, h, &start)) < 1e-14);
        }
    }
}

#[test]
fn lie_trotter_is_not_symmetric() {
    let (map, start) = (
        lie_trotter(Variant::PositionFirst),
        (vec![0.2, 0.1], vec![0.3, -0.2]),
    );
    assert!(
        distance(
            &stepped(&Adjoint(&map), 0.1, &start),
            &stepped(&map, 0.1, &start)
        ) > 1e-4
    );
}

#[test]
fn repetition_is_step_after_step() {
    let map = RungeKutta::separable(tableaus::rk4(), HenonHeiles).unwrap();
    let start = (vec![0.2, 0.1], vec![0.3, -0.2]);
    let by_hand = (0..5).fold(start.clone(), |state, _| stepped(&map, 0.1, &state));
    assert_eq!(
        stepped(&Repeat::new(&map, 5).unwrap(), 0.1, &start),
        by_hand
    );
}

#[test]
fn coordinates_are_passed_on() {
    let strang = splitting_methods::strang(Variant::PositionFirst);
    let rotor = Splitting::new(strang, Rotor(Pendulum::default()));
    let of_rotor = rotor.capabilities().coordinates;
    assert_ne!(of_rotor, Coordinates::plain(1));
    let maps: [&dyn TimeAdvance; 7] = [
        &Inverse(&rotor),
        &Adjoint(&rotor),
        &Repeat::new(&rotor, 2).unwrap(),
        &Compose::new(vec![(1.0, &rotor)]).unwrap(),
        &DampedMap::new(&rotor, 0.1).unwrap(),
        &SinglePrecision(&rotor),
        &RungeKutta::separable(tableaus::rk4(), Rotor(Pendulum::default())).unwrap(),
    ];
    for map in maps {
        assert_eq!(map.capabilities().coordinates, of_rotor);
        assert_eq!(map.dof(), 1);
    }
}

#[test]
fn combinations_without_meaning_are_refused() {
    let strang = |system| -> Box<dyn TimeAdvance> {
        let system: Box<dyn symplint_models::Separable> = system;
        Box::new(Splitting::new(
            splitting_methods::strang(Variant::PositionFirst),
            system,
        ))
    };
    let pendulum = || strang(Box::new(Rotor(Pendulum::default())));
    let error =
        |parts: Vec<(f64, Box<dyn TimeAdvance>)>| Compose::new(parts).map(|_| ()).unwrap_err();
    assert_eq!(error(vec![]), ModelError::EmptyComposition);
    assert!(matches!(
        error(vec![(f64::NAN, pendulum())]),
        ModelError::OutOfRange { .. }
    ));
    let array = Box::new(PendulumArray::new(3, 1.0, 1.0).unwrap());
    assert_eq!(
        error(vec![(0.5, pendulum()), (0.5, strang(array))]),
        ModelError::ComposedDof {
            part: 1,
            expected: 1,
            got: 3
        }
    );
    let wedge = Box::new(AbsoluteValue::new(0.0).unwrap());
    assert_eq!(
        error(vec![(0.5, pendulum()), (0.5, strang(wedge))]),
        ModelError::ComposedCoordinates { part: 1 }
    );
    let error = Repeat::new(pendulum(), 0).map(|_| ()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "number of repetitions is 0; give 1 or more"
    );
}

#[test]
fn composing_with_the_inverse_returns_the_loop() {
    let method = || splitting_methods::mclachlan4(Variant::MomentumFirst);
    let forth: Box<dyn TimeAdvance> = Box::new(Splitting::new(method(), HenonHeiles));
    let back: Box<dyn TimeAdvance> = Box::new(Inverse(Splitting::new(method(), HenonHeiles)));
    let both = Compose::new(vec![(1.0, forth), (1.0, back)]).unwrap();
    let phase_loop = Circle::new(vec![0.0, 0.1], vec![0.2, 0.1], 0.3).unwrap();
    let before = Ensemble::sample(&phase_loop, 100).unwrap();
    let mut after = before.clone();
    after.advance(&both, 0.5).unwrap();
    for (rows, again) in [(before.q(), after.q()), (before.p(), after.p())] {
        for i in 0..2 {
            for (a, b) in rows.row(i).iter().zip(again.row(i)) {
                assert!((a - b).abs() < 1e-15);
            }
        }
    }
}

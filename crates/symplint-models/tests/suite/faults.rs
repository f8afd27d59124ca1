//! Maps with a fault, and what is known of it.

use crate::common::{State, distance, stepped};
use crate::two_form::{jacobian, two_form_defect};
use symplint::{Circle, Diagnostic, TimeAdvance, VerdictKind};
use symplint_models::integrators::{
    AdaptiveStrang, Flow, RungeKutta, Splitting, SplittingMethod, Substep, Variant,
    splitting_methods, tableaus,
};
use symplint_models::maps::{Adjoint, Compose, DampedMap, SinglePrecision};
use symplint_models::systems::{HenonHeiles, Pendulum, RotationalForce};
use symplint_models::{DriftKick, Separable};

const VARIANTS: [Variant; 2] = [Variant::PositionFirst, Variant::MomentumFirst];

fn start() -> State {
    (vec![0.2, -0.3], vec![0.1, 0.4])
}

fn strang<S: DriftKick>(variant: Variant, system: S) -> Splitting<S> {
    Splitting::new(splitting_methods::strang(variant), system)
}

fn verdict(map: &dyn TimeAdvance) -> (VerdictKind, Option<f64>) {
    let dof = map.dof();
    let circle = Circle::new(vec![0.1; dof], vec![0.25; dof], 0.2).unwrap();
    let diagnosis = Diagnostic::halving(0, -6).run(map, &circle).unwrap();
    (diagnosis.verdict.kind, diagnosis.verdict.order)
}

#[test]
fn a_force_without_potential_is_not_symplectic_under_any_splitting() {
    for variant in VARIANTS {
        let map = strang(variant, RotationalForce::new(0.1).unwrap());
        // One kick adds 2κh dq_1 ∧ dq_2; volumes stay.
        let defect = two_form_defect(&map, 0.5, &start());
        assert!((0.05..0.2).contains(&defect), "{defect}");
        let volume = jacobian(&map, 0.5, &start()).determinant();
        assert!((volume - 1.0).abs() < 1e-10, "{volume}");
        assert_eq!(verdict(&map), (VerdictKind::NotSymplectic, Some(1.0)));
    }
    // The two-form on (∂/∂q_1, ∂/∂q_2) after a kick alone, by hand.
    let kick = [Substep {
        flow: Flow::Kick,
        fraction: 1.0,
    }];
    let kick = SplittingMethod::new("kick", 1, &kick, "").unwrap();
    let map = Splitting::new(kick, RotationalForce::new(0.1).unwrap());
    let defect = two_form_defect(&map, 0.5, &start());
    assert!((defect - 2.0 * 0.1 * 0.5).abs() < 1e-10, "{defect}");
}

#[test]
fn without_its_turning_part_the_force_is_that_of_henon_heiles() {
    for variant in VARIANTS {
        let straight = strang(variant, RotationalForce::new(0.0).unwrap());
        let known = strang(variant, HenonHeiles);
        assert_eq!(
            stepped(&straight, 0.3, &start()),
            stepped(&known, 0.3, &start())
        );
    }
}

#[test]
fn damping_multiplies_the_two_form() {
    let map = DampedMap::new(strang(Variant::PositionFirst, HenonHeiles), 0.2).unwrap();
    let expected = 1.0 - (-0.2_f64 * 0.5).exp();
    let defect = two_form_defect(&map, 0.5, &start());
    assert!((defect - expected).abs() < 1e-10, "{defect} for {expected}");
    assert_eq!(verdict(&map), (VerdictKind::NotSymplectic, Some(1.0)));
    assert!(DampedMap::new(strang(Variant::PositionFirst, HenonHeiles), f64::NAN).is_err());
}

#[test]
fn single_precision_keeps_24_bits_and_the_verdict_its_digits() {
    let map = SinglePrecision(strang(Variant::PositionFirst, HenonHeiles));
    let (q, p) = stepped(&map, 0.5, &start());
    for value in q.iter().chain(&p) {
        assert_eq!(f64::from(*value as f32), *value);
    }
    let exact = stepped(&strang(Variant::PositionFirst, HenonHeiles), 0.5, &start());
    let difference = distance(&(q, p), &exact);
    assert!((1e-10..1e-7).contains(&difference), "{difference:e}");
    // Rounding is too fine a staircase to be seen: a symplectic map remains so to 7 digits or 8.
    let circle = Circle::new(vec![0.1; 2], vec![0.25; 2], 0.2).unwrap();
    let verdict = Diagnostic::default().run(&map, &circle).unwrap().verdict;
    assert_eq!(verdict.kind, VerdictKind::Symplectic);
    let digits = verdict.digits.unwrap();
    assert!((6.5..9.0).contains(&digits), "{digits}");
}

/// The step size is differentiated, too: Mᵀ J M − J with M = DΦ_s + ∂Φ_s/∂s ⊗ ∇s.
#[test]
fn a_step_size_chosen_by_the_state_is_not_symplectic() {
    for variant in VARIANTS {
        let map = AdaptiveStrang::new(variant, HenonHeiles);
        let fixed = strang(variant, HenonHeiles);
        // It advances one state as Strang splitting does with the step of this state.
        let (x, y) = (0.2_f64, -0.3_f64);
        let force = [x + 2.0 * x * y, y + x * x - y * y];
        let step = 0.5 / (1.0 + force[0] * force[0] + force[1] * force[1]).sqrt();
        let by_hand = stepped(&fixed, step, &start());
        assert!(distance(&stepped(&map, 0.5, &start()), &by_hand) < 1e-15);
        assert!(two_form_defect(&fixed, step, &start()) < 1e-10);
        assert!(two_form_defect(&map, 0.5, &start()) > 1e-3);
        assert_eq!(verdict(&map), (VerdictKind::NotSymplectic, Some(1.0)));
    }
}

/// The adaptive step follows the orbit, though in its own time: the energy error at a fixed
/// number times h is of second order.
#[test]
fn an_adaptive_step_is_accurate_all_the_same() {
    let energy = |(q, p): &State| {
        let mut out = [0.0; 2];
        let rows = |values: &'static [f64]| symplint::state::Rows::new(values, 2, 1, 1);
        let leak = |values: &Vec<f64>| rows(Vec::leak(values.clone()));
        HenonHeiles.kinetic_energy(leak(p), &mut out[..1]);
        HenonHeiles.potential_energy(leak(q), &mut out[1..]);
        out[0] + out[1]
    };
    let error = |steps: u32| {
        let map = AdaptiveStrang::new(Variant::PositionFirst, HenonHeiles);
        let h = 4.0 / f64::from(steps);
        let end = (0..steps).fold(start(), |state, _| stepped(&map, h, &state));
        (energy(&end) - energy(&start())).abs()
    };
    let order = (error(100) / error(200)).log2();
    assert!((order - 2.0).abs() < 0.1, "{order}");
}

/// A sign that is wrong in one place is not symplectic, det = 1 + 2h²V''; one that is wrong
/// throughout is the force of −V, symplectic and utterly wrong.
#[test]
fn wrong_signs() {
    let map = RungeKutta::separable(tableaus::wrong_sign_euler(), Pendulum::default()).unwrap();
    let h = 0.3;
    let at = (vec![0.7], vec![0.9]);
    // V = cos q.
    let expected = 1.0 - 2.0 * h * h * 0.7_f64.cos();
    let got = jacobian(&map, h, &at).determinant();
    assert!((got - expected).abs() < 1e-10, "{got} for {expected}");
    assert_eq!(verdict(&map), (VerdictKind::NotSymplectic, Some(2.0)));

    let substeps = [(Flow::Drift, 1.0), (Flow::Kick, -1.0)];
    let substeps = substeps.map(|(flow, fraction)| Substep { flow, fraction });
    let reversed = SplittingMethod::new("reversed kick", 0, &substeps, "").unwrap();
    let map = Splitting::new(reversed, Pendulum::default());
    assert_eq!(verdict(&map).0, VerdictKind::Symplectic);
}

/// Staggered leapfrog takes (q_n, p_{n−1/2}) to (q_{n+1}, p_{n+1/2}): symplectic Euler, kick first.
/// Half a kick turns p_{n−1/2} into p_n, and makes velocity Verlet of it; so does the mean of both
/// half-step momenta.
#[test]
fn staggered_leapfrog_is_conjugate_to_its_unstaggered_form() {
    let staggered = Splitting::new(
        splitting_methods::lie_trotter(Variant::MomentumFirst),
        HenonHeiles,
    );
    let half = [Substep {
        flow: Flow::Kick,
        fraction: 0.5,
    }];
    let half = SplittingMethod::new("half a kick", 1, &half, "").unwrap();
    let half = Splitting::new(half, HenonHeiles);
    let verlet = strang(Variant::MomentumFirst, HenonHeiles);
    let h = 0.3;
    let unstaggered = |state: &State| stepped(&half, h, state);
    // Back from p_n to p_{n−1/2}.
    let stagger = |state: &State| stepped(&Adjoint(&half), -h, state);
    let behind = stagger(&start());
    let ahead = stepped(&staggered, h, &behind);
    let expected = stepped(&verlet, h, &start());
    assert!(distance(&unstaggered(&ahead), &expected) < 1e-15);
    // p_1 as the mean of p_{1/2} and p_{3/2}.
    let next = stepped(&staggered, h, &ahead);
    let means = ahead.1.iter().zip(&next.1).map(|(a, b)| 0.5 * (a + b));
    assert!(distance(&(ahead.0.clone(), means.collect()), &expected) < 1e-15);
    assert!(two_form_defect(&staggered, h, &behind) < 1e-10);
    // Two halves make a kick of the whole, so that the composition is Verlet.
    let composed = Compose::new(vec![(1.0, &half), (1.0, &verlet)]).unwrap();
    assert!(distance(&stepped(&composed, h, &behind), &expected) < 1e-15);
}

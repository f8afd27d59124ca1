//! Systems with known motions, conserved quantities and maps of known shape.

use std::f64::consts::{PI, TAU};

use crate::common::{State, distance, stepped};
use crate::two_form::{jacobian, two_form_defect};
use symplint::state::RowsMut;
use symplint::{Block, Circle, Diagnostic, PerSample, TimeAdvance, VerdictKind};
use symplint_models::discrete::{HenonMap, PendulumRattle, StandardMap};
use symplint_models::integrators::{
    Boris, ImplicitRungeKutta, RungeKutta, Splitting, StageSolver, Variant, splitting_methods,
    tableaus,
};
use symplint_models::systems::{
    Chain, ChargedParticle, DoublePendulum, Ends, FputBond, Kepler, Pendulum, TodaBond,
};
use symplint_models::{Hamiltonian, ModelError};

fn run(map: &dyn TimeAdvance, h: f64, steps: usize, start: &State) -> State {
    (0..steps).fold(start.clone(), |state, _| stepped(map, h, &state))
}

fn momentum_first<S: symplint_models::DriftKick>(system: S) -> Splitting<S> {
    Splitting::new(splitting_methods::strang(Variant::MomentumFirst), system)
}

/// An ellipse of eccentricity e from its perihelion comes back after 2π, and is at its aphelion,
/// 1 + e away with the speed √((1 − e)/(1 + e)), after π (HLW, section I.2).
#[test]
fn planets_move_on_ellipses() {
    let e = 0.3_f64;
    let start = (
        vec![1.0 - e, 0.0],
        vec![0.0, ((1.0 + e) / (1.0 - e)).sqrt()],
    );
    let method = splitting_methods::yoshida8(Variant::PositionFirst);
    let map = Splitting::new(method, Kepler::new(1.0, 0.0).unwrap());
    let half = run(&map, PI / 200.0, 200, &start);
    let aphelion = (
        vec![-1.0 - e, 0.0],
        vec![0.0, -((1.0 - e) / (1.0 + e)).sqrt()],
    );
    assert!(distance(&half, &aphelion) < 1e-10, "{half:?}");
    assert!(distance(&run(&map, PI / 200.0, 200, &half), &start) < 1e-10);
}

#[test]
fn angular_momentum_is_conserved_by_every_splitting_step() {
    let kepler = Kepler::new(1.0, 0.1).unwrap();
    let spin = |(q, p): &State| q[0] * p[1] - q[1] * p[0];
    let start = (vec![0.8, 0.1], vec![-0.2, 1.1]);
    let end = run(&momentum_first(kepler), 0.1, 100, &start);
    assert!((spin(&end) - spin(&start)).abs() < 1e-13);
    let rk4 = RungeKutta::separable(tableaus::rk4(), kepler).unwrap();
    assert!((spin(&run(&rk4, 0.1, 100, &start)) - spin(&start)).abs() > 1e-7);
}

/// Small swings of equal pendula: θ_2 = ±√2 θ_1 at ω² = (2 ∓ √2) g/l, and p = M θ̇ with M = (2 1; 1 1).
#[test]
fn the_double_pendulum_has_its_two_small_swings() {
    let map = RungeKutta::new(tableaus::rk4(), DoublePendulum::default()).unwrap();
    for sign in [1.0, -1.0] {
        let root = sign * 2.0_f64.sqrt();
        let omega = (2.0 - root).sqrt();
        let (amplitude, time) = (1e-5, 1.3);
        let state = |time: f64| -> State {
            let (sin, cos) = (omega * time).sin_cos();
            let (angle, speed) = (amplitude * cos, -amplitude * omega * sin);
            (
                vec![angle, root * angle],
                vec![(2.0 + root) * speed, (1.0 + root) * speed],
            )
        };
        let end = run(&map, time / 100.0, 100, &state(0.0));
        assert!(distance(&end, &state(time)) < 1e-4 * amplitude);
    }
}

/// Hénon's third integral of the periodic lattice of three,
/// p_1 p_2 p_3 − p_1 e^{q_2 − q_3} − p_2 e^{q_3 − q_1} − p_3 e^{q_1 − q_2}. Here springs push with
/// e^{−(q_{i+1} − q_i)}, as in a Toda chain.
#[test]
fn toda_of_three_has_a_third_integral() {
    let third = |(q, p): &State| {
        p[0] * p[1] * p[2]
            - p[0] * (q[1] - q[2]).exp()
            - p[1] * (q[2] - q[0]).exp()
            - p[2] * (q[0] - q[1]).exp()
    };
    let start = (vec![0.4, -0.1, 0.2], vec![0.5, -0.7, 0.3]);
    let method = splitting_methods::yoshida8(Variant::PositionFirst);
    let toda = Splitting::new(
        method.clone(),
        Chain::new(TodaBond, 3, Ends::Periodic).unwrap(),
    );
    let end = run(&toda, 0.02, 200, &start);
    assert!(distance(&end, &start) > 0.1);
    assert!((third(&end) - third(&start)).abs() < 1e-12);
    // The expansion of Toda's spring to fourth order has no such integral.
    let fput = Chain::new(FputBond::new(-0.5, 1.0 / 6.0).unwrap(), 3, Ends::Periodic).unwrap();
    let end = run(&Splitting::new(method, fput), 0.02, 200, &start);
    assert!((third(&end) - third(&start)).abs() > 1e-4);
}

/// Mode k of a linear chain of N masses between walls turns at 2 sin(πk/2(N + 1)).
#[test]
fn linear_chains_have_their_normal_modes() {
    let masses = 7;
    let chain = Chain::new(FputBond::new(0.0, 0.0).unwrap(), masses, Ends::Fixed).unwrap();
    let method = splitting_methods::yoshida8(Variant::PositionFirst);
    let map = Splitting::new(method, chain);
    for mode in 1..=masses {
        let phase = PI * mode as f64 / (masses + 1) as f64;
        let shape = map.system().mode_shape(mode, 1.0);
        let omega = 2.0 * (0.5 * phase).sin();
        let state = |time: f64| -> State {
            let (sin, cos) = (omega * time).sin_cos();
            (
                shape.iter().map(|a| a * cos).collect(),
                shape.iter().map(|a| -omega * a * sin).collect(),
            )
        };
        let end = run(&map, 0.03, 100, &state(0.0));
        assert!(distance(&end, &state(3.0)) < 1e-11, "mode {mode}");
    }
}

fn charge(field: f64, gradient: f64, omega: f64) -> ChargedParticle {
    ChargedParticle::new(field, gradient, omega).unwrap()
}

/// A circle of radius v/B at the angular frequency −B.
#[test]
fn charges_gyrate_in_a_uniform_field() {
    let particle = charge(2.0, 0.0, 0.0);
    let rk4 = RungeKutta::new(tableaus::rk4(), particle).unwrap();
    let state = |time: f64| -> State {
        let (sin, cos) = (2.0 * time).sin_cos();
        let (x, y) = (0.3 + 0.5 * sin, 0.1 + 0.5 * cos);
        // v = (cos, −sin), p = v + (0, B x).
        (vec![x, y], vec![cos, -sin + 2.0 * x])
    };
    let end = run(&rk4, 1e-3, 1000, &state(0.0));
    assert!(distance(&end, &state(1.0)) < 1e-11);
    let boris = Boris::new(particle);
    let error = |steps| {
        distance(
            &run(&boris, 1.0 / steps as f64, steps, &state(0.0)),
            &state(1.0),
        )
    };
    let order = (error(50) / error(100)).log2();
    assert!((order - 2.0).abs() < 0.05, "{order}");
}

#[test]
fn the_boris_method_conserves_volumes_and_is_symplectic_in_a_uniform_field_alone() {
    let start = (vec![0.4, -0.2], vec![0.7, 0.5]);
    for (gradient, omega, symplectic) in [
        (0.0, 0.0, true),
        (0.0, 0.8, false),
        (0.6, 0.0, false),
        (0.6, 0.8, false),
    ] {
        let map = Boris::new(charge(1.3, gradient, omega));
        let volume = jacobian(&map, 0.5, &start).determinant();
        assert!((volume - 1.0).abs() < 1e-10, "{volume}");
        let defect = two_form_defect(&map, 0.5, &start);
        assert_eq!(symplectic, defect < 1e-9, "{gradient}, {omega}: {defect:e}");
        assert!(
            symplectic || defect > 1e-5,
            "{gradient}, {omega}: {defect:e}"
        );
    }
}

/// In a uniform field the two-step form of the method comes from a discrete Lagrangian, whatever the
/// electric field: with x_n half a drift back and π_n = v − (h/2) (v × B + E(x_n)), the step is
/// symplectic in (x_n, π_n + A(x_n)). So there it is conjugate to a symplectic map.
#[test]
fn the_boris_method_is_conjugate_to_a_symplectic_map_in_a_uniform_field() {
    let h = 0.5;
    let start = (vec![0.4, -0.2], vec![0.7, 0.5]);
    let defect = |gradient: f64| {
        let particle = charge(1.3, gradient, 0.8);
        let boris = Boris::new(particle);
        let map = PerSample::new(2, move |h: f64, q: &mut [f64], p: &mut [f64]| {
            let half = 0.5 * h;
            let turn = |x: f64| half * particle.magnetic_field(x);
            let kick = |x: f64, y: f64| particle.electric_field(x, y).map(|e| half * e);
            let (t, e) = (turn(q[0]), kick(q[0], q[1]));
            let w = [p[0] + e[0], p[1] - particle.vector_potential(q[0]) + e[1]];
            let v = [w[0] + t * w[1], w[1] - t * w[0]].map(|w| w / (1.0 + t * t));
            let x = [q[0] + half * v[0], q[1] + half * v[1]];
            let canonical = vec![v[0], v[1] + particle.vector_potential(x[0])];
            let (x, canonical) = stepped(&boris, h, &(x.to_vec(), canonical));
            let v = [canonical[0], canonical[1] - particle.vector_potential(x[0])];
            q[0] = x[0] - half * v[0];
            q[1] = x[1] - half * v[1];
            let (t, e) = (turn(q[0]), kick(q[0], q[1]));
            p[0] = v[0] - t * v[1] - e[0];
            p[1] = v[1] + t * v[0] - e[1] + particle.vector_potential(q[0]);
        });
        two_form_defect(&map, h, &start)
    };
    assert!(defect(0.0) < 1e-9, "{:e}", defect(0.0));
    assert!(defect(0.6) > 1e-4, "{:e}", defect(0.6));
}

#[test]
fn the_boris_method_in_a_uniform_field_is_the_midpoint_rule() {
    let particle = charge(1.3, 0.0, 0.0);
    let start = (vec![0.4, -0.2], vec![0.7, 0.5]);
    let solver = StageSolver::default();
    let midpoint =
        ImplicitRungeKutta::new(tableaus::implicit_midpoint(), particle, solver).unwrap();
    let [boris, midpoint] =
        [&Boris::new(particle) as &dyn TimeAdvance, &midpoint].map(|map| stepped(map, 0.5, &start));
    assert!(distance(&boris, &midpoint) < 1e-15);
}

#[test]
fn the_boris_method_conserves_the_speed_without_an_electric_field() {
    let particle = charge(1.3, 0.6, 0.0);
    let energy = |(q, p): &State| {
        let mut out = [0.0];
        let rows = |values| symplint::state::Rows::new(values, 2, 1, 1);
        particle.energy(rows(q), rows(p), &mut out);
        out[0]
    };
    let start = (vec![0.4, -0.2], vec![0.7, 0.5]);
    let end = run(&Boris::new(particle), 0.3, 500, &start);
    assert!((energy(&end) - energy(&start)).abs() < 1e-13);
    // p_y is an integral of the motion, but not of the method.
    assert!((end.1[1] - start.1[1]).abs() > 1e-4);
    let solver = StageSolver::default();
    let gauss = ImplicitRungeKutta::new(tableaus::gauss4(), particle, solver).unwrap();
    assert!((run(&gauss, 0.3, 500, &start).1[1] - start.1[1]).abs() < 1e-12);
}

#[test]
fn the_boris_method_has_order_two_in_any_field() {
    let particle = charge(1.3, 0.6, 0.8);
    let start = (vec![0.4, -0.2], vec![0.7, 0.5]);
    let rk4 = RungeKutta::new(tableaus::rk4(), particle).unwrap();
    let exact = run(&rk4, 1e-3, 2000, &start);
    let boris = Boris::new(particle);
    let error = |steps| distance(&run(&boris, 2.0 / steps as f64, steps, &start), &exact);
    let order = (error(100) / error(200)).log2();
    assert!((order - 2.0).abs() < 0.05, "{order}");
}

#[test]
fn the_henon_map_at_unit_step_is_henons() {
    let (x, y, angle) = (0.3, 0.2, 1.1_f64);
    let map = HenonMap::new(angle, 1.0).unwrap();
    let kicked = y - x * x;
    let expected = (
        vec![x * angle.cos() - kicked * angle.sin()],
        vec![x * angle.sin() + kicked * angle.cos()],
    );
    assert!(distance(&stepped(&map, 1.0, &(vec![x], vec![y])), &expected) < 1e-16);
}

#[test]
fn the_determinant_of_the_henon_map_is_its_contraction() {
    let at = (vec![0.3], vec![0.2]);
    for contraction in [1.0, 0.3, 1.2] {
        let map = HenonMap::new(1.1, contraction).unwrap();
        for h in [1.0, 0.5] {
            let determinant = jacobian(&map, h, &at).determinant();
            assert!((determinant - contraction.powf(h)).abs() < 1e-10);
        }
    }
    assert!(matches!(
        HenonMap::new(1.1, 0.0),
        Err(ModelError::OutOfRange { .. })
    ));
    assert!(HenonMap::new(f64::NAN, 1.0).is_err());
}

/// The kick-first Euler step on p²/2 + K cos q, wrapped; with K = 1 that is the pendulum.
#[test]
fn the_standard_map_is_symplectic_euler_on_a_cylinder() {
    let map = StandardMap::new(1.0).unwrap();
    let method = splitting_methods::lie_trotter(Variant::MomentumFirst);
    let euler = Splitting::new(method, Pendulum::default());
    assert_eq!(map.capabilities().coordinates.period(0), TAU);
    for k in 0..40 {
        let state = (
            vec![0.5 * f64::from(k) - 10.0],
            vec![3.0 - 0.4 * f64::from(k)],
        );
        let (q, p) = stepped(&map, 1.0, &state);
        let (flat, same) = stepped(&euler, 1.0, &state);
        assert_eq!(p, same);
        assert!((0.0..TAU).contains(&q[0]));
        let turns = (q[0] - flat[0]) / TAU;
        assert!((turns - turns.round()).abs() < 1e-15 * (1.0 + flat[0].abs()));
    }
    // The least negative angle wraps to 0, not to 2π.
    let (mut q, mut p) = ([-1e-300], [0.0]);
    let mut block = Block::new(RowsMut::new(&mut q, 1, 1, 1), RowsMut::new(&mut p, 1, 1, 1));
    map.advance(1.0, &mut block).unwrap();
    assert_eq!(q, [0.0]);
}

/// Loops that cross the seam of the cylinder, and verdicts on both kinds of the Hénon map.
#[test]
fn verdicts_on_given_maps() {
    let verdict = |map: &dyn TimeAdvance, q0: f64, radius: f64| {
        let circle = Circle::new(vec![q0], vec![0.1], radius).unwrap();
        let diagnosis = Diagnostic::halving(0, -5).run(map, &circle).unwrap();
        (diagnosis.verdict.kind, diagnosis.verdict.order)
    };
    let standard = StandardMap::new(0.97).unwrap();
    for q0 in [0.0, PI, TAU] {
        assert_eq!(
            verdict(&standard, q0, 1.0).0,
            VerdictKind::Symplectic,
            "{q0}"
        );
    }
    let area_preserving = HenonMap::new(1.33, 1.0).unwrap();
    assert_eq!(
        verdict(&area_preserving, 0.0, 0.3).0,
        VerdictKind::Symplectic
    );
    let dissipative = HenonMap::new(1.33, 0.3).unwrap();
    assert_eq!(
        verdict(&dissipative, 0.0, 0.3),
        (VerdictKind::NotSymplectic, Some(1.0))
    );
}

#[test]
fn parameters_without_meaning_are_refused() {
    assert!(Kepler::new(f64::NAN, 0.0).is_err());
    assert!(Kepler::new(1.0, -0.1).is_err());
    assert!(DoublePendulum::new([1.0, 0.0], [1.0; 2], 1.0).is_err());
    assert!(DoublePendulum::new([1.0; 2], [1.0, -1.0], 1.0).is_err());
    assert!(DoublePendulum::new([1.0; 2], [1.0; 2], f64::INFINITY).is_err());
    assert!(ChargedParticle::new(1.0, f64::NAN, 0.0).is_err());
    assert!(ChargedParticle::new(1.0, 0.0, 1e200).is_err());
    assert!(Chain::new(TodaBond, 0, Ends::Fixed).is_err());
    assert!(Chain::new(TodaBond, 1, Ends::Periodic).is_err());
    assert!(FputBond::new(f64::NAN, 0.0).is_err());
    assert!(StandardMap::new(f64::INFINITY).is_err());
}

/// The rod against the pendulum in its angle, θ' = p/L, p' = −g sin θ: the same motion to order 2, on the circle to
/// round-off.
#[test]
fn a_rod_in_cartesian_coordinates_is_the_pendulum() {
    let (length, gravity) = (1.7, 0.9);
    let rod = PendulumRattle::new(length, gravity).unwrap();
    let angle = PerSample::new(1, move |h, q, p| {
        let force = |q: f64| -gravity * q.sin();
        p[0] += 0.5 * h * force(q[0]);
        q[0] += h * p[0] / length;
        p[0] += 0.5 * h * force(q[0]);
    });
    let fine = run(&angle, 1e-4, 20_000, &(vec![0.8], vec![0.4]));
    let error = |h: f64| {
        let (q, p) = rod.state(0.8, 0.4);
        let steps = (2.0 / h) as usize;
        let (q, p) = run(&rod, h, steps, &(q.to_vec(), p.to_vec()));
        assert!((q[0].hypot(q[1]) - length).abs() < 1e-14);
        assert!((q[0] * p[0] + q[1] * p[1]).abs() < 1e-14);
        let (expected_q, expected_p) = rod.state(fine.0[0], fine.1[0]);
        distance(&(q, p), &(expected_q.to_vec(), expected_p.to_vec()))
    };
    let ratio = error(0.1) / error(0.05);
    assert!((3.7..4.3).contains(&ratio), "{ratio}");
    assert!(PendulumRattle::new(0.0, 1.0).is_err() && PendulumRattle::new(1.0, f64::NAN).is_err());
    let far = Circle::new(vec![0.0, -1.7], vec![0.0, 0.0], 0.1).unwrap();
    let error = Diagnostic::halving(6, 5).run(&rod, &far).unwrap_err();
    assert!(error.to_string().contains("rod does not reach"), "{error}");
}

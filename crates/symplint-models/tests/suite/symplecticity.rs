//! Which steps are symplectic: areas, loop integrals, and methods that are the same map.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use crate::common::{State, distance, stepped};
use crate::rotor::Rotor;
use proptest::prelude::*;
use symplint::state::RowsMut;
use symplint::verdict::JacobianVerdict;
use symplint::{Block, Circle, JacobianTest, TimeAdvance};
use symplint_fft::Complex64;
use symplint_models::integrators::catalogue::{self, CATALOGUE};
use symplint_models::integrators::{RungeKutta, Splitting, Variant, splitting_methods, tableaus};
use symplint_models::systems::{
    AbsoluteValue, HenonHeiles, InterpolatedPendulum, Pendulum, PendulumArray,
};
use symplint_models::{Model, Separable};

const VARIANTS: [Variant; 2] = [Variant::PositionFirst, Variant::MomentumFirst];

/// The determinant of the Jacobian of one step of one degree of freedom, by differences of fourth
/// order.
fn determinant(map: &dyn TimeAdvance, h: f64, q: f64, p: f64) -> f64 {
    const STEP: f64 = 2e-3;
    let column = |dq: f64, dp: f64| {
        let at = |k: f64| {
            let (q, p) = stepped(map, h, &(vec![q + k * STEP * dq], vec![p + k * STEP * dp]));
            [q[0], p[0]]
        };
        let (a, b, c, d) = (at(-2.0), at(-1.0), at(1.0), at(2.0));
        [0, 1].map(|i| (a[i] - 8.0 * b[i] + 8.0 * c[i] - d[i]) / (12.0 * STEP))
    };
    let (by_q, by_p) = (column(1.0, 0.0), column(0.0, 1.0));
    by_q[0] * by_p[1] - by_q[1] * by_p[0]
}

#[test]
fn one_dimensional_steps_keep_areas_if_and_only_if_they_say_so() {
    let model = Model::Separable(Arc::new(Pendulum::default()));
    for info in CATALOGUE.iter().filter(|info| info.is_for(&model)) {
        let defaults = info
            .variants
            .iter()
            .map(|variant| Some(*variant))
            .chain([None]);
        for variant in defaults {
            let map = catalogue::build(info.name, variant, Arc::new(Pendulum::default())).unwrap();
            let (q, p) = (0.7, 0.9);
            // An accurate method shows what it is where it is not accurate.
            let h = if info.name == "dop853" { 2.0 } else { 0.5 };
            let defect = (determinant(&*map, h, q, p) - 1.0).abs();
            assert_eq!(
                info.symplectic,
                defect < 1e-8,
                "{} {variant:?}: {defect:e}",
                info.name
            );
            assert!(
                info.symplectic || defect > 1e-6,
                "{} {variant:?}: {defect:e}",
                info.name
            );
        }
    }
}

proptest! {
    #[test]
    fn strang_pairs_are_strang_splitting(
        h in -1.0_f64..1.0,
        q in prop::collection::vec(-3.0_f64..3.0, 5),
        p in prop::collection::vec(-3.0_f64..3.0, 5),
    ) {
        let system = PendulumArray::new(5, 0.9, 1.2).unwrap();
        let pairs = [tableaus::strang_position_first(), tableaus::strang_momentum_first()];
        for (variant, pair) in VARIANTS.into_iter().zip(pairs) {
            let splitting = Splitting::new(splitting_methods::strang(variant), system);
            let state = (q.clone(), p.clone());
            let split = stepped(&splitting, h, &state);
            for pair in [pair.clone(), pair.adjoint()] {
                let name = pair.name().to_owned();
                let partitioned = RungeKutta::separable(pair, system).unwrap();
                let difference = distance(&split, &stepped(&partitioned, h, &state));
                prop_assert!(difference < 1e-14, "{name}: {difference:e}");
            }
        }
        let lobatto = RungeKutta::separable(tableaus::lobatto3a_3b(), system).unwrap();
        let strang = Splitting::new(splitting_methods::strang(Variant::MomentumFirst), system);
        let state = (q, p);
        prop_assert!(distance(&stepped(&strang, h, &state), &stepped(&lobatto, h, &state)) < 1e-14);
    }
}

/// ∮ p dq of one degree of freedom by the trapezoidal rule with the spectral derivative,
/// −(π/N²) Σ k |Z_k|² with Z the transform of q + i p.
fn loop_integral(q: &[f64], p: &[f64]) -> f64 {
    let n = q.len();
    let mut modes: Vec<Complex64> = q
        .iter()
        .zip(p)
        .map(|(&q, &p)| Complex64::new(q, p))
        .collect();
    symplint_fft::forward(n).process(&mut modes);
    let terms = (1..n / 2).map(|k| k as f64 * (modes[k].norm_sqr() - modes[n - k].norm_sqr()));
    -PI / (n * n) as f64 * terms.sum::<f64>()
}

/// A unit circle about (`q0`, `p0`), from its top in the direction of growing q, before and after
/// one step.
fn advected_circle(map: &dyn TimeAdvance, h: f64, samples: usize, q0: f64, p0: f64) -> [State; 2] {
    let s = |k: usize| TAU * k as f64 / samples as f64;
    let before: State = (
        (0..samples).map(|k| q0 + s(k).sin()).collect(),
        (0..samples).map(|k| p0 + s(k).cos()).collect(),
    );
    let mut after = before.clone();
    let mut block = Block::new(
        RowsMut::new(&mut after.0, 1, samples, samples),
        RowsMut::new(&mut after.1, 1, samples, samples),
    );
    map.advance(h, &mut block).expect("these maps do not fail");
    [before, after]
}

/// The relative change of the loop integral over one step.
fn loop_defect(map: &dyn TimeAdvance, h: f64, samples: usize, q0: f64, p0: f64) -> f64 {
    let [before, after] = advected_circle(map, h, samples, q0, p0);
    loop_integral(&after.0, &after.1) / loop_integral(&before.0, &before.1) - 1.0
}

/// Defects at h = 0.1 about (π, 0) with 64 samples, by an independent numpy code: degree, Strang
/// position-first, explicit midpoint. So few samples let the quadrature error of the advected loop
/// show every coefficient of the potential.
#[test]
fn interpolated_pendulum_agrees_with_an_independent_code() {
    for (degree, strang, midpoint) in [
        (0, 0.0, 8.202130865782031e-4),
        (1, -1.1404067271292284e-5, 1.9810922301211065e-3),
        (2, 1.6159630333856256e-6, 8.620623336492717e-4),
        (3, -1.8897020370722828e-7, 8.191587714447834e-4),
    ] {
        let system = || Arc::new(InterpolatedPendulum::new(degree, 25).unwrap());
        for (name, expected) in [("strang", strang), ("rk2", midpoint)] {
            let map = catalogue::build(name, None, system()).unwrap();
            let defect = loop_defect(&*map, 0.1, 64, PI, 0.0);
            assert!(
                (defect - expected).abs() < 2e-13,
                "degree {degree}, {name}: {defect:e} for {expected:e}"
            );
        }
    }
}

/// The absolutely continuous part of ∮ p dq after one step: trapezoids, without the cells across
/// which the loop is torn.
fn torn_loop_integral(map: &dyn TimeAdvance, h: f64) -> f64 {
    const SAMPLES: usize = 1 << 20;
    let [_, (q, p)] = advected_circle(map, h, SAMPLES, 0.0, 0.0);
    (0..SAMPLES)
        .map(|k| (k, if k + 1 == SAMPLES { 0 } else { k + 1 }))
        .filter(|&(k, next)| (p[next] - p[k]).abs() < 1e-3 && (q[next] - q[k]).abs() < 1e-3)
        .map(|(k, next)| 0.5 * (p[k] + p[next]) * (q[next] - q[k]))
        .sum()
}

/// Closed forms of Barham & Burby, section 4.2; that of momentum-first Strang holds up to h = 2.
#[test]
fn a_wedge_tears_loops_as_the_closed_forms_say() {
    type ClosedForm = fn(f64) -> f64;
    let table: [(&str, &str, ClosedForm); 4] = [
        ("lie-trotter", "position-first", |_| PI),
        ("lie-trotter", "momentum-first", |h| PI + 4.0 * h * h),
        ("strang", "position-first", |h| {
            PI + 4.0 * h * h / (h * h + 4.0).sqrt()
        }),
        ("strang", "momentum-first", |h| {
            if h <= 2.0 {
                PI + 2.0 * h * h - h.powi(3)
            } else {
                PI
            }
        }),
    ];
    for (name, variant, closed_form) in table {
        let system = Arc::new(AbsoluteValue::new(0.0).unwrap());
        let map = catalogue::build(name, Some(variant), system).unwrap();
        for h in [0.5, 1.0, 2.5] {
            let (got, expected) = (torn_loop_integral(&*map, h), closed_form(h));
            assert!(
                (got - expected).abs() < 2e-4,
                "{name} {variant}, h = {h}: {got} for {expected}"
            );
        }
    }
}

/// The two-form dq ∧ dp on the columns of a Jacobian: d Φᵀ J dΦ = J in two degrees of freedom.
#[test]
fn henon_heiles_steps_keep_the_two_form() {
    const STEP: f64 = 1e-3;
    let (q, p) = ([0.2, -0.3], [0.1, 0.4]);
    let column = |map: &dyn TimeAdvance, axis: usize| {
        let at = |k: f64| {
            let (mut q, mut p) = (q.to_vec(), p.to_vec());
            if axis < 2 {
                q[axis] += k * STEP
            } else {
                p[axis - 2] += k * STEP
            }
            let (q, p) = stepped(map, 0.5, &(q, p));
            [q[0], q[1], p[0], p[1]]
        };
        let (a, b, c, d) = (at(-2.0), at(-1.0), at(1.0), at(2.0));
        [0, 1, 2, 3].map(|i| (a[i] - 8.0 * b[i] + 8.0 * c[i] - d[i]) / (12.0 * STEP))
    };
    let model = Model::Separable(Arc::new(HenonHeiles));
    for info in CATALOGUE.iter().filter(|info| info.is_for(&model)) {
        let map = catalogue::build(info.name, None, Arc::new(HenonHeiles)).unwrap();
        let columns = [0, 1, 2, 3].map(|axis| column(&*map, axis));
        let mut defect = 0.0_f64;
        for i in 0..4 {
            for j in 0..4 {
                let (u, v) = (columns[i], columns[j]);
                let form = u[0] * v[2] + u[1] * v[3] - u[2] * v[0] - u[3] * v[1];
                let expected = f64::from(u8::from(j == i + 2)) - f64::from(u8::from(i == j + 2));
                defect = defect.max((form - expected).abs());
            }
        }
        assert_eq!(info.symplectic, defect < 1e-9, "{}: {defect:e}", info.name);
    }
}

/// The public test, in full and on random pairs, says of every integrator what the catalogue says.
#[test]
fn the_jacobian_test_agrees_with_the_catalogue() {
    let model = Model::Separable(Arc::new(Pendulum::default()));
    for info in CATALOGUE.iter().filter(|info| info.is_for(&model)) {
        for pendula in [3, 20] {
            let system = Arc::new(PendulumArray::new(pendula, 0.9, 1.2).unwrap());
            let map = catalogue::build(info.name, None, system).unwrap();
            let circle = Circle::new(vec![0.4; pendula], vec![0.3; pendula], 1.0).unwrap();
            let phase_loop = circle.with_phases(symplint::Phases::Random { seed: 7 });
            let verdict = (JacobianTest::default()
                .run(&*map, &phase_loop, 0.5)
                .unwrap())
            .verdict();
            let symplectic = matches!(verdict, JacobianVerdict::SymplecticAlmostEverywhere { .. });
            let not = matches!(verdict, JacobianVerdict::NotSymplectic { .. });
            assert_eq!(
                (info.symplectic, !info.symplectic),
                (symplectic, not),
                "{}, {pendula} pendula: {verdict}",
                info.name
            );
        }
    }
}

#[test]
fn a_shared_system_works_in_every_family() {
    let system: Arc<dyn Separable> = Arc::new(Rotor(Pendulum::default()));
    let strang = splitting_methods::strang(Variant::PositionFirst);
    let boxed: Box<dyn Separable> = Box::new(Rotor(Pendulum::default()));
    let maps: [Box<dyn TimeAdvance>; 3] = [
        Box::new(Splitting::new(strang.clone(), system.clone())),
        Box::new(RungeKutta::separable(tableaus::strang_position_first(), system).unwrap()),
        Box::new(Splitting::new(strang, boxed)),
    ];
    let state = (vec![1.0], vec![0.5]);
    for map in &maps {
        assert_eq!(map.capabilities().coordinates.period(0), TAU);
        assert!(distance(&stepped(map, 0.2, &state), &stepped(&maps[0], 0.2, &state)) < 1e-15);
    }
}

//! The order of every integrator, measured.

use std::sync::Arc;

use crate::common::{State, distance, stepped};
use symplint::TimeAdvance;
use symplint::state::{Rows, RowsMut};
use symplint_models::integrators::catalogue::{self, CATALOGUE, IntegratorInfo};
use symplint_models::integrators::{
    ImplicitRungeKutta, RungeKutta, Splitting, StageSolver, Variant, splitting_methods, tableaus,
};
use symplint_models::systems::{HarmonicOscillator, HenonHeiles};
use symplint_models::{Hamiltonian, Model};

/// Advances one state by `steps` steps to `time`.
fn at_time(map: &dyn TimeAdvance, time: f64, steps: u32, start: &State) -> State {
    let h = time / f64::from(steps);
    (0..steps).fold(start.clone(), |state, _| stepped(map, h, &state))
}

const TIME: f64 = 4.0;

fn start() -> State {
    (vec![0.2, -0.1], vec![0.3, 0.25])
}

/// The slope of log error between two step sizes a factor of two apart.
fn measured_order(map: &dyn TimeAdvance, steps: u32, exact: &State) -> f64 {
    let error = |steps| distance(&at_time(map, TIME, steps, &start()), exact);
    (error(steps) / error(2 * steps)).log2()
}

#[test]
fn every_integrator_has_its_order_and_no_more() {
    let exact = {
        let method = splitting_methods::yoshida8(Variant::PositionFirst);
        at_time(&Splitting::new(method, HenonHeiles), TIME, 500, &start())
    };
    let by_rk4 = {
        let rk4 = catalogue::build("rk4", None, Arc::new(HenonHeiles)).unwrap();
        at_time(&*rk4, TIME, 8000, &start())
    };
    assert!(
        distance(&exact, &by_rk4) < 1e-13,
        "{:e}",
        distance(&exact, &by_rk4)
    );

    let model = Model::Separable(Arc::new(HenonHeiles));
    let with_order = |info: &&IntegratorInfo| info.order > 0 && info.is_for(&model);
    for info in CATALOGUE.iter().filter(with_order) {
        let variants = info.variants.iter().map(|variant| Some(*variant));
        let variants: Vec<_> = if info.variants.is_empty() {
            vec![None]
        } else {
            variants.collect()
        };
        for variant in variants {
            let map = catalogue::build(info.name, variant, Arc::new(HenonHeiles)).unwrap();
            // Steps small enough for the leading term, large enough to stand out of round-off.
            let steps = match info.order {
                _ if info.name == "dop853" => 10,
                1 => 2000,
                2 => 400,
                4..=6 => 64,
                _ => 40,
            };
            let order = measured_order(&*map, steps, &exact);
            assert!(
                (order - f64::from(info.order)).abs() < 0.15,
                "{} {variant:?}: order {order}, stated {}",
                info.name,
                info.order
            );
        }
    }
}

#[test]
fn the_oscillator_turns_at_its_frequency() {
    let omega = 1.7;
    let system = HarmonicOscillator::new(vec![omega]).unwrap();
    let step = Splitting::new(splitting_methods::yoshida8(Variant::MomentumFirst), system);
    let (q, p) = (0.4, -0.9);
    let (sin, cos) = (omega * TIME).sin_cos();
    let exact = (
        vec![q * cos + p / omega * sin],
        vec![p * cos - omega * q * sin],
    );
    let got = at_time(&step, TIME, 100, &(vec![q], vec![p]));
    assert!(
        distance(&got, &exact) < 1e-12,
        "{:e}",
        distance(&got, &exact)
    );
}

/// H = ½ (1 + q²)(1 + p²): not separable, so velocities need positions and forces momenta.
struct Coupled;

impl Hamiltonian for Coupled {
    fn dof(&self) -> usize {
        1
    }

    fn energy(&self, q: Rows<'_>, p: Rows<'_>, out: &mut [f64]) {
        for ((out, q), p) in out.iter_mut().zip(q.row(0)).zip(p.row(0)) {
            *out = 0.5 * (1.0 + q * q) * (1.0 + p * p);
        }
    }

    fn add_velocity(&self, tau: f64, q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>) {
        for ((out, q), p) in out.row_mut(0).iter_mut().zip(q.row(0)).zip(p.row(0)) {
            *out += tau * (1.0 + q * q) * p;
        }
    }

    fn add_force(&self, tau: f64, q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>) {
        for ((out, q), p) in out.row_mut(0).iter_mut().zip(q.row(0)).zip(p.row(0)) {
            *out -= tau * q * (1.0 + p * p);
        }
    }
}

#[test]
fn runge_kutta_keeps_its_order_where_nothing_separates() {
    let start = (vec![0.4], vec![-0.3]);
    let exact = at_time(
        &RungeKutta::new(tableaus::rk4(), Coupled).unwrap(),
        1.0,
        4000,
        &start,
    );
    for (tableau, steps) in [
        (tableaus::euler(), 1000),
        (tableaus::midpoint(), 200),
        (tableaus::heun(), 200),
        (tableaus::rk4(), 40),
    ] {
        let (stated, name) = (tableau.order(), tableau.name().to_owned());
        let map = RungeKutta::new(tableau, Coupled).unwrap();
        let error = |steps| distance(&at_time(&map, 1.0, steps, &start), &exact);
        let order = (error(steps) / error(2 * steps)).log2();
        assert!((order - f64::from(stated)).abs() < 0.1, "{name}: {order}");
    }
}

#[test]
fn implicit_methods_keep_their_orders_where_nothing_separates() {
    let start = (vec![0.4], vec![-0.3]);
    let rk4 = RungeKutta::new(tableaus::rk4(), Coupled).unwrap();
    let exact = at_time(&rk4, 1.0, 4000, &start);
    let pairs = [
        (tableaus::implicit_midpoint().into(), 2, 50),
        (tableaus::trapezoidal().into(), 2, 50),
        (tableaus::averaged_vector_field().into(), 2, 50),
        (tableaus::lobatto3a_3b(), 2, 50),
        (tableaus::gauss4().into(), 4, 20),
        (tableaus::gauss6().into(), 6, 6),
    ];
    for (method, stated, steps) in pairs {
        let map = ImplicitRungeKutta::new(method, Coupled, StageSolver::default()).unwrap();
        let error = |steps| distance(&at_time(&map, 1.0, steps, &start), &exact);
        let order = (error(steps) / error(2 * steps)).log2();
        let name = map.method().name();
        assert!((order - f64::from(stated)).abs() < 0.15, "{name}: {order}");
    }
}

#[test]
fn one_step_of_the_midpoint_rule_by_hand() {
    let (q, p, h) = (0.4, -0.3, 0.1);
    let velocity = |q: f64, p: f64| (1.0 + q * q) * p;
    let force = |q: f64, p: f64| -q * (1.0 + p * p);
    let (mid_q, mid_p) = (q + h / 2.0 * velocity(q, p), p + h / 2.0 * force(q, p));
    let exact = (
        vec![q + h * velocity(mid_q, mid_p)],
        vec![p + h * force(mid_q, mid_p)],
    );
    let map = RungeKutta::new(tableaus::midpoint(), Coupled).unwrap();
    let got = crate::common::stepped(&map, h, &(vec![q], vec![p]));
    assert!(distance(&got, &exact) < 1e-16);
}

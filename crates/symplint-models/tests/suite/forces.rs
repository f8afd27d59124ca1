//! Forces and velocities of every system against differences of its energy.

use symplint::state::{Rows, RowsMut};
use symplint_models::Hamiltonian;
use symplint_models::systems::{
    AbsoluteValue, Bond, Chain, ChargedParticle, DoublePendulum, Ends, FputBond,
    HarmonicOscillator, HenonHeiles, InterpolatedPendulum, Kepler, Pendulum, PendulumArray,
    PendulumPotential, TodaBond,
};

/// H of one state.
fn energy(system: &dyn Hamiltonian, q: &[f64], p: &[f64]) -> f64 {
    let (dof, mut out) = (q.len(), [0.0]);
    system.energy(Rows::new(q, dof, 1, 1), Rows::new(p, dof, 1, 1), &mut out);
    out[0]
}

/// A central difference of fourth order.
fn difference(f: impl Fn(f64) -> f64) -> f64 {
    const STEP: f64 = 1e-3;
    (f(-2.0 * STEP) - 8.0 * f(-STEP) + 8.0 * f(STEP) - f(2.0 * STEP)) / (12.0 * STEP)
}

fn shifted(values: &[f64], i: usize, shift: f64) -> Vec<f64> {
    let mut values = values.to_vec();
    values[i] += shift;
    values
}

/// Checks all derivatives at one state; they must come multiplied by τ and added to what was there.
fn check(system: &dyn Hamiltonian, q: &[f64], p: &[f64]) {
    const TAU: f64 = 0.5;
    let dof = system.dof();
    let (q_rows, p_rows) = (Rows::new(q, dof, 1, 1), Rows::new(p, dof, 1, 1));
    let (mut velocity, mut force) = (vec![1.0; dof], vec![1.0; dof]);
    system.add_velocity(
        TAU,
        q_rows,
        p_rows,
        &mut RowsMut::new(&mut velocity, dof, 1, 1),
    );
    system.add_force(
        TAU,
        q_rows,
        p_rows,
        &mut RowsMut::new(&mut force, dof, 1, 1),
    );
    for i in 0..dof {
        let by_p = difference(|shift| energy(system, q, &shifted(p, i, shift)));
        let by_q = difference(|shift| energy(system, &shifted(q, i, shift), p));
        for (got, expected) in [
            (velocity[i], 1.0 + TAU * by_p),
            (force[i], 1.0 - TAU * by_q),
        ] {
            assert!(
                (got - expected).abs() < 1e-9,
                "degree of freedom {i} at q = {q:?}: {got} for {expected}"
            );
        }
    }
}

#[test]
fn smooth_systems() {
    for k in 0..20 {
        let x = f64::from(k) - 9.5;
        for potential in [PendulumPotential::Cos, PendulumPotential::Sin] {
            check(&Pendulum::new(potential), &[x], &[0.3 * x]);
        }
        check(&AbsoluteValue::new(0.5).unwrap(), &[0.2 * x], &[x]);
        check(&AbsoluteValue::new(0.0).unwrap(), &[0.2 * x], &[x]);
        check(&HenonHeiles, &[0.1 * x, 0.4 - 0.05 * x], &[x, -x]);
        let oscillators = HarmonicOscillator::new(vec![1.0, 0.0, 2.5]).unwrap();
        check(&oscillators, &[x, 1.0, -0.2 * x], &[0.5, x, 1.0]);
    }
}

#[test]
fn planets_and_double_pendula() {
    for k in 0..20 {
        let x = 0.3 * f64::from(k) - 2.9;
        check(&Kepler::new(1.3, 0.0).unwrap(), &[x, 1.1], &[0.3, x]);
        check(&Kepler::new(-0.7, 0.5).unwrap(), &[0.2, x], &[x, 0.1]);
        check(&DoublePendulum::default(), &[x, 0.4 - x * x], &[0.7, x]);
        let uneven = DoublePendulum::new([0.7, 1.9], [1.3, 0.6], 2.1).unwrap();
        check(&uneven, &[x, 1.7 * x], &[0.3 * x, -0.8]);
    }
}

#[test]
fn charges_in_magnetic_fields() {
    for k in 0..20 {
        let x = 0.2 * f64::from(k) - 1.9;
        for (gradient, omega) in [(0.0, 0.0), (0.7, 0.0), (-0.4, 1.3)] {
            let particle = ChargedParticle::new(1.1, gradient, omega).unwrap();
            check(&particle, &[x, 0.3 - x], &[0.4 * x, 0.9]);
        }
    }
}

#[test]
fn chains_with_every_end() {
    fn chain(bond: impl Bond + 'static + Copy) {
        for (masses, ends) in [
            (1, Ends::Fixed),
            (2, Ends::Fixed),
            (5, Ends::Fixed),
            (2, Ends::Periodic),
            (5, Ends::Periodic),
        ] {
            let chain = Chain::new(bond, masses, ends).unwrap();
            let q: Vec<f64> = (0..masses).map(|i| (1.7 * i as f64).sin()).collect();
            check(&chain, &q, &vec![0.4; masses]);
        }
    }
    chain(TodaBond);
    chain(FputBond::new(0.25, 0.0).unwrap());
    chain(FputBond::new(-0.3, 1.2).unwrap());
}

#[test]
fn pendulum_arrays_of_every_size() {
    for pendula in [1, 2, 3, 10] {
        let array = PendulumArray::new(pendula, 0.8, 1.7).unwrap();
        let (q, p) = array.uniform_state(7);
        check(&array, &q, &p);
    }
}

/// Inside the cells: at the nodes the difference would straddle two polynomials.
#[test]
fn interpolated_pendula_of_every_degree() {
    for degree in 0..=5 {
        let system = InterpolatedPendulum::new(degree, 25).unwrap();
        for k in -30..60 {
            let q = (f64::from(k) + 0.37) * std::f64::consts::TAU / 25.0;
            check(&system, &[q], &[0.1]);
        }
    }
}

#[test]
fn samples_of_a_block_do_not_mix() {
    let array = PendulumArray::new(3, 1.0, 2.0).unwrap();
    // Two samples in columns 0 and 1 of rows that lie three values apart.
    let q = [0.1, 1.1, 9.0, 0.2, 1.4, 9.0, 0.5, 1.9, 9.0];
    let mut both = [0.0; 9];
    array.add_force(
        1.0,
        Rows::new(&q, 3, 3, 2),
        Rows::new(&q, 3, 3, 2),
        &mut RowsMut::new(&mut both, 3, 3, 2),
    );
    for sample in 0..2 {
        let own: Vec<f64> = (0..3).map(|i| q[3 * i + sample]).collect();
        let mut alone = [0.0; 3];
        let rows = Rows::new(&own, 3, 1, 1);
        array.add_force(1.0, rows, rows, &mut RowsMut::new(&mut alone, 3, 1, 1));
        for i in 0..3 {
            assert_eq!(both[3 * i + sample], alone[i]);
        }
    }
    assert_eq!(
        [both[2], both[5], both[8]],
        [0.0; 3],
        "beyond the block nothing is written"
    );
}

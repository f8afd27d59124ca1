//! The derivatives of forces and velocities against second derivatives of the energy by hyper-dual numbers.
//!
//! Energies are written here once more, from the formulas of the documentation: nothing is shared with
//! the library but the parameters.

use num_dual::{DualNum, HyperDual64};
use symplint::state::{Rows, RowsMut};
use symplint_models::systems::{
    AbsoluteValue, Chain, ChargedParticle, DoublePendulum, Ends, FputBond, HarmonicOscillator,
    HenonHeiles, InterpolatedPendulum, Kepler, Pendulum, PendulumArray, PendulumPotential,
    TodaBond,
};
use symplint_models::{Hamiltonian, PhasePoints, SlopeTangent};

use crate::tangents::direction;

type Number = HyperDual64;
type Energy = fn(&[Number], &[Number]) -> Number;

fn kinetic(p: &[Number]) -> Number {
    p.iter().fold(Number::from(0.0), |sum, p| sum + p * p * 0.5)
}

fn chain(q: &[Number], ends: Ends, bond: impl Fn(Number) -> Number) -> Number {
    let pairs = q.windows(2).map(|pair| pair[1] - pair[0]);
    let (first, last) = (q[0], q[q.len() - 1]);
    let others = match ends {
        Ends::Fixed => vec![first, -last],
        Ends::Periodic => vec![first - last],
    };
    let springs = pairs.chain(others);
    springs.fold(Number::from(0.0), |sum, elongation| sum + bond(elongation))
}

fn double_pendulum(q: &[Number], p: &[Number]) -> Number {
    let (m1, m2, l1, l2, g) = (1.0, 0.7, 0.8, 1.1, 0.9);
    let delta = q[0] - q[1];
    let numerator = p[0].powi(2) * (m2 * l2 * l2) + p[1].powi(2) * ((m1 + m2) * l1 * l1)
        - p[0] * p[1] * delta.cos() * (2.0 * m2 * l1 * l2);
    let denominator = (delta.sin().powi(2) * m2 + m1) * (2.0 * m2 * l1 * l1 * l2 * l2);
    numerator / denominator - q[0].cos() * ((m1 + m2) * g * l1) - q[1].cos() * (m2 * g * l2)
}

fn charge(q: &[Number], p: &[Number]) -> Number {
    let (b, g, omega) = (0.8, 0.5, 0.6);
    let potential = q[0] * b + q[0].powi(2) * (0.5 * g);
    let electric = (q[0].powi(2) + q[1].powi(2)) * (0.5 * omega * omega);
    (p[0].powi(2) + (p[1] - potential).powi(2)) * 0.5 + electric
}

fn cases() -> Vec<(&'static str, Box<dyn Hamiltonian>, Energy)> {
    let pendulum = |potential| Box::new(Pendulum::new(potential));
    vec![
        (
            "oscillators",
            Box::new(HarmonicOscillator::new(vec![1.0, 1.7]).unwrap()),
            |q, p| kinetic(p) + q[0].powi(2) * 0.5 + q[1].powi(2) * (0.5 * 1.7 * 1.7),
        ),
        ("cosine", pendulum(PendulumPotential::Cos), |q, p| {
            kinetic(p) + q[0].cos()
        }),
        ("sine", pendulum(PendulumPotential::Sin), |q, p| {
            kinetic(p) + q[0].sin()
        }),
        (
            "rounded wedge",
            Box::new(AbsoluteValue::new(0.4).unwrap()),
            |q, p| kinetic(p) + (q[0].powi(2) + 0.16).sqrt(),
        ),
        (
            "potential of the splines",
            Box::new(InterpolatedPendulum::new(0, 0).unwrap()),
            |q, p| kinetic(p) + q[0].sin() + (q[0] * 2.0 + 1.0).cos().powi(2),
        ),
        (
            "pendulum array",
            Box::new(PendulumArray::new(4, 0.9, 0.6).unwrap()),
            |q, p| {
                let springs = chain(q, Ends::Periodic, |r| r.powi(2) * 0.3);
                q.iter()
                    .fold(kinetic(p) + springs, |sum, q| sum + q.cos() * 0.9)
            },
        ),
        ("Hénon–Heiles", Box::new(HenonHeiles), |q, p| {
            let (x, y) = (q[0], q[1]);
            kinetic(p) + (x * x + y * y) * 0.5 + x * x * y - y.powi(3) / 3.0
        }),
        (
            "Kepler",
            Box::new(Kepler::new(1.2, 0.3).unwrap()),
            |q, p| kinetic(p) - (q[0].powi(2) + q[1].powi(2) + 0.09).sqrt().recip() * 1.2,
        ),
        (
            "FPUT",
            Box::new(Chain::new(FputBond::new(0.3, 0.5).unwrap(), 4, Ends::Fixed).unwrap()),
            |q, p| {
                let bond = |r: Number| r.powi(2) * 0.5 + r.powi(3) * 0.1 + r.powi(4) * 0.125;
                kinetic(p) + chain(q, Ends::Fixed, bond)
            },
        ),
        (
            "Toda",
            Box::new(Chain::new(TodaBond, 4, Ends::Periodic).unwrap()),
            |q, p| kinetic(p) + chain(q, Ends::Periodic, |r| (-r).exp() + r - 1.0),
        ),
        (
            "double pendulum",
            Box::new(DoublePendulum::new([1.0, 0.7], [0.8, 1.1], 0.9).unwrap()),
            double_pendulum,
        ),
        (
            "charge",
            Box::new(ChargedParticle::new(0.8, 0.5, 0.6).unwrap()),
            charge,
        ),
    ]
}

/// ∇∇H u, positions first.
fn hessian_times(energy: Energy, (q, p): (&[f64], &[f64]), u: &[f64]) -> Vec<f64> {
    let dof = q.len();
    let component = |c: usize| {
        let lift = |first: usize, values: &[f64]| -> Vec<Number> {
            let lifted = values.iter().enumerate().map(|(i, &value)| {
                let unit = f64::from(u8::from(first + i == c));
                Number::new(value, u[first + i], unit, 0.0)
            });
            lifted.collect()
        };
        energy(&lift(0, q), &lift(dof, p)).eps1eps2
    };
    (0..2 * dof).map(component).collect()
}

#[test]
fn slopes_change_by_the_second_derivatives_of_the_energy() {
    const TAU: f64 = 0.7;
    for (name, system, energy) in cases() {
        let dof = system.dof();
        for seed in 0..10 {
            let (q, p) = direction(dof, 3 * seed + 1);
            let (dq, dp) = direction(dof, 3 * seed + 2);
            let expected = hessian_times(energy, (&q, &p), &[dq.clone(), dp.clone()].concat());
            let rows = |values| Rows::new(values, dof, 1, 1);
            let at = PhasePoints {
                q: rows(&q),
                p: rows(&p),
            };
            let along = PhasePoints {
                q: rows(&dq),
                p: rows(&dp),
            };
            // Added to what is there.
            let (mut velocity, mut force) = (vec![1.0; dof], vec![1.0; dof]);
            let tangent: SlopeTangent<'_> = system.tangent().unwrap();
            tangent.add_velocity(TAU, at, along, &mut RowsMut::new(&mut velocity, dof, 1, 1));
            tangent.add_force(TAU, at, along, &mut RowsMut::new(&mut force, dof, 1, 1));
            let size = expected.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
            for i in 0..dof {
                let off_force = force[i] - (1.0 - TAU * expected[i]);
                let off_velocity = velocity[i] - (1.0 + TAU * expected[dof + i]);
                let off = off_force.abs().max(off_velocity.abs());
                assert!(off < 4e-15 * size, "{name}, {i}: {off:e} of {size}");
            }
        }
    }
}

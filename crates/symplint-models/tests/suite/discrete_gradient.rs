//! The discrete gradient of Gonzalez: the equation it solves, the energy it conserves, and what it does near equilibria.

use std::sync::Arc;

use crate::common::{State, distance, stepped};
use symplint::state::{Rows, RowsMut};
use symplint::{Block, Circle, Coordinates, Diagnostic, Ensemble, TimeAdvance, VerdictKind};
use symplint_models::integrators::catalogue::{self, CATALOGUE};
use symplint_models::integrators::{
    DiscreteGradient, ImplicitRungeKutta, Solver, StageSolver, Stop, tableaus,
};
use symplint_models::systems::{
    Chain, ChargedParticle, DoublePendulum, Ends, HarmonicOscillator, HenonHeiles, Kepler,
    Pendulum, PendulumArray, TodaBond,
};
use symplint_models::{Hamiltonian, Model, ModelError};

const WEIGHTS: [f64; 2] = [0.3, 2.0];

/// H = Σ w (p²/2 + p⁴/10) + cos(q_0 − q_1) + q_0⁴/4 + q_1²/2, of momenta p with weights w.
struct Weighted;

impl Hamiltonian for Weighted {
    fn dof(&self) -> usize {
        2
    }

    fn energy(&self, q: Rows<'_>, p: Rows<'_>, out: &mut [f64]) {
        for (k, out) in out.iter_mut().enumerate() {
            let (q, p) = ([0, 1].map(|i| q.row(i)[k]), [0, 1].map(|i| p.row(i)[k]));
            *out = plain_energy(&[q[0], q[1], WEIGHTS[0] * p[0], WEIGHTS[1] * p[1]]);
        }
    }

    fn add_velocity(&self, tau: f64, _q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>) {
        for i in 0..2 {
            for (out, p) in out.row_mut(i).iter_mut().zip(p.row(i)) {
                *out += tau * (p + 0.4 * p.powi(3));
            }
        }
    }

    /// dp/dt, so that the weight times p has −∂H/∂q.
    fn add_force(&self, tau: f64, q: Rows<'_>, _p: Rows<'_>, out: &mut RowsMut<'_>) {
        for k in 0..q.len() {
            let (a, b) = (q.row(0)[k], q.row(1)[k]);
            out.row_mut(0)[k] += tau * ((a - b).sin() - a.powi(3)) / WEIGHTS[0];
            out.row_mut(1)[k] += tau * (-(a - b).sin() - b) / WEIGHTS[1];
        }
    }

    fn coordinates(&self) -> Coordinates {
        Coordinates::plain(2)
            .with_weights(WEIGHTS.to_vec())
            .unwrap()
    }
}

/// The same in canonical momenta P = w p: z is (q_0, q_1, P_0, P_1).
fn plain_energy(z: &[f64; 4]) -> f64 {
    let kinetic = |i: usize| {
        let p = z[2 + i] / WEIGHTS[i];
        WEIGHTS[i] * (p * p / 2.0 + p.powi(4) / 10.0)
    };
    kinetic(0) + kinetic(1) + (z[0] - z[1]).cos() + z[0].powi(4) / 4.0 + z[1] * z[1] / 2.0
}

/// Its gradient, by differences of order 6 of the energy alone.
fn plain_gradient(z: &[f64; 4]) -> [f64; 4] {
    const STEP: f64 = 8e-3;
    std::array::from_fn(|i| {
        let at = |k: f64| {
            let mut z = *z;
            z[i] += k * STEP;
            plain_energy(&z)
        };
        let pair = |k: f64| at(k) - at(-k);
        (45.0 * pair(1.0) - 9.0 * pair(2.0) + pair(3.0)) / (60.0 * STEP)
    })
}

/// z' = z + h J ∇̄H as it is written down, solved by 300 iterations.
fn plain_step(h: f64, z: [f64; 4]) -> [f64; 4] {
    let mut end = z;
    // Away from z, where the formula is 0/0.
    end[0] += 1e-3;
    for _ in 0..300 {
        let middle = std::array::from_fn(|i| 0.5 * (z[i] + end[i]));
        let change: [f64; 4] = std::array::from_fn(|i| end[i] - z[i]);
        let dot = |a: &[f64; 4], b: &[f64; 4]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let gradient = plain_gradient(&middle);
        let missing = plain_energy(&end) - plain_energy(&z) - dot(&gradient, &change);
        let factor = missing / dot(&change, &change);
        let discrete: [f64; 4] = std::array::from_fn(|i| gradient[i] + factor * change[i]);
        end = [
            z[0] + h * discrete[2],
            z[1] + h * discrete[3],
            z[2] - h * discrete[0],
            z[3] - h * discrete[1],
        ];
    }
    end
}

#[test]
fn a_step_is_its_definition_in_canonical_momenta() {
    let map = DiscreteGradient::new(Weighted, StageSolver::default()).unwrap();
    for h in [0.2, 0.1, -0.15] {
        let state = (vec![0.7, -0.4], vec![0.9, 0.5]);
        let (q, p) = stepped(&map, h, &state);
        let found = [q[0], q[1], WEIGHTS[0] * p[0], WEIGHTS[1] * p[1]];
        let z = [0.7, -0.4, WEIGHTS[0] * 0.9, WEIGHTS[1] * 0.5];
        let expected = plain_step(h, z);
        // The gradient by differences is good to 1e-12.
        for (found, expected) in found.iter().zip(&expected) {
            let off = (found - expected).abs();
            assert!(off < 1e-11, "h = {h}: {found} for {expected}");
        }
        // The correction is not that small.
        let midpoint = tableaus::implicit_midpoint();
        let midpoint = ImplicitRungeKutta::new(midpoint, Weighted, StageSolver::default());
        let apart = distance(&stepped(&midpoint.unwrap(), h, &state), &(q, p));
        assert!(apart > 1e-7, "{apart:e}");
    }
}

fn energy(system: &dyn Hamiltonian, (q, p): &State) -> f64 {
    let (dof, mut out) = (q.len(), [0.0]);
    system.energy(Rows::new(q, dof, 1, 1), Rows::new(p, dof, 1, 1), &mut out);
    out[0]
}

/// Systems of every kind but plasmas, with a state and a step size.
fn cases() -> Vec<(&'static str, Model, State, f64)> {
    let toda = Chain::new(TodaBond, 3, Ends::Periodic).unwrap();
    let charge = ChargedParticle::new(1.0, 0.5, 0.2).unwrap();
    vec![
        (
            "Hénon–Heiles",
            Model::Separable(Arc::new(HenonHeiles)),
            (vec![0.1, -0.2], vec![0.3, 0.2]),
            0.5,
        ),
        (
            "Kepler",
            Model::Separable(Arc::new(Kepler::new(1.0, 0.0).unwrap())),
            (vec![0.7, 0.1], vec![0.2, 1.1]),
            0.1,
        ),
        (
            "Toda",
            Model::Separable(Arc::new(toda)),
            (vec![0.4, -0.1, 0.2], vec![0.5, -0.7, 0.3]),
            0.4,
        ),
        (
            "double pendulum",
            Model::General(Arc::new(DoublePendulum::default())),
            (vec![0.5, -0.2], vec![0.2, 0.1]),
            0.2,
        ),
        (
            "weighted",
            Model::General(Arc::new(Weighted)),
            (vec![0.7, -0.4], vec![0.9, 0.5]),
            0.2,
        ),
        (
            "charge",
            Model::Charged(charge),
            (vec![0.3, -0.2], vec![0.5, 0.4]),
            0.3,
        ),
    ]
}

#[test]
fn every_energy_is_conserved_over_many_steps() {
    for (name, model, start, h) in cases() {
        let drift = |integrator: &str| {
            let map = catalogue::build(integrator, None, model.clone()).unwrap();
            let of = |state: &State| energy(model.hamiltonian().unwrap(), state);
            let mut state = start.clone();
            let mut worst = 0f64;
            for _ in 0..200 {
                let before = of(&state);
                state = stepped(&*map, h, &state);
                worst = worst.max((of(&state) - before).abs() / before.abs().max(1.0));
            }
            let overall = (of(&state) - of(&start)).abs() / of(&start).abs().max(1.0);
            (worst, overall)
        };
        let (worst, overall) = drift("discrete-gradient");
        println!("{name}: {worst:.1e} a step, {overall:.1e} after 200");
        assert!(
            worst < 1e-14 && overall < 2e-13,
            "{name}: {worst:e}, {overall:e}"
        );
        let (midpoint, _) = drift("implicit-midpoint");
        assert!(midpoint > 1e-8, "{name}: {midpoint:e}");
    }
}

#[test]
fn a_step_back_undoes_a_step() {
    for (name, model, start, h) in cases() {
        let map = catalogue::build("discrete-gradient", None, model).unwrap();
        let back = stepped(&*map, -h, &stepped(&*map, h, &start));
        let off = distance(&back, &start);
        assert!(off < 2e-14, "{name}: {off:e}");
    }
}

#[test]
fn for_a_quadratic_hamiltonian_it_is_the_midpoint_rule() {
    let oscillator = || HarmonicOscillator::new(vec![1.0, 2.3]).unwrap();
    let solver = StageSolver::default();
    let map = DiscreteGradient::new(oscillator(), solver).unwrap();
    let midpoint =
        ImplicitRungeKutta::new(tableaus::implicit_midpoint(), oscillator(), solver).unwrap();
    let state = (vec![0.4, -0.7], vec![0.1, 0.9]);
    let off = distance(
        &stepped(&map, 0.3, &state),
        &stepped(&midpoint, 0.3, &state),
    );
    assert!(off < 2e-15, "{off:e}");
}

/// The largest difference from the midpoint rule on a loop of radius `radius` round a state of rest, and the largest change
/// of the energy relative to that of rest.
fn near_rest(model: &Model, radius: f64, h: f64) -> Result<(f64, f64), symplint::Error> {
    let advanced = |name: &str| {
        let map = catalogue::build(name, None, model.clone()).unwrap();
        let rest = vec![0.0; map.dof()];
        let circle = Circle::new(rest.clone(), rest, radius).unwrap();
        let mut ensemble = Ensemble::sample(
            &circle.with_phases(symplint::Phases::Random { seed: 3 }),
            64,
        )
        .unwrap();
        let energies = |ensemble: &mut Ensemble| {
            let (block, mut out) = (ensemble.block(), vec![0.0; 64]);
            let (q, p) = (block.q.as_rows(), block.p.as_rows());
            model.hamiltonian().unwrap().energy(q, p, &mut out);
            out
        };
        let before = energies(&mut ensemble);
        ensemble.advance(&*map, h)?;
        let after = energies(&mut ensemble);
        let change = |(a, b): (&f64, &f64)| (a - b).abs() / b.abs();
        let change = after.iter().zip(&before).map(change).fold(0.0, f64::max);
        Ok((ensemble, change))
    };
    let (mut found, change) = advanced("discrete-gradient")?;
    let (mut midpoint, _) = advanced("implicit-midpoint")?;
    let (found, midpoint) = (found.block(), midpoint.block());
    let mut off = 0f64;
    for i in 0..found.dof() {
        for k in 0..64 {
            off = off.max((found.q.row(i)[k] - midpoint.q.row(i)[k]).abs());
            off = off.max((found.p.row(i)[k] - midpoint.p.row(i)[k]).abs());
        }
    }
    Ok((off, change))
}

/// At rest these energies are not 0: H(z') = H(z) is known to ε, and z' at a distance r from there to ε/r.
#[test]
fn near_equilibria_steps_converge_and_conserve_the_energy_to_its_rounding() {
    let systems = [
        ("pendulum", Model::Separable(Arc::new(Pendulum::default()))),
        (
            "array",
            Model::Separable(Arc::new(PendulumArray::new(50, 0.9, 1.2).unwrap())),
        ),
        (
            "double pendulum",
            Model::General(Arc::new(DoublePendulum::default())),
        ),
    ];
    for (name, model) in &systems {
        for exponent in 1..=9 {
            let radius = 0.1f64.powi(exponent);
            for h in [0.3, 0.05] {
                let (off, change) = near_rest(model, radius, h).unwrap();
                let what = format!("{name}, r = {radius:e}, h = {h}");
                assert!(change < 1e-14, "{what}: {change:e}");
                // Differences of the order (h r)², and the rounding of H.
                let expected = (h * radius).powi(2) + 20.0 * f64::EPSILON / radius;
                assert!(off < expected, "{what}: {off:e}");
                // The correction is there where it is resolved, and not where it would be noise.
                let (is_large, is_small) = (radius > 0.05, radius < 1e-6);
                assert!(!is_large || off > 1e-11, "{what}: {off:e}");
                assert!(!is_small || off < 1e-15 * radius, "{what}: {off:e}");
            }
        }
    }
    for (name, model) in &systems {
        let map = catalogue::build("discrete-gradient", None, model.clone()).unwrap();
        let rest = (vec![0.0; map.dof()], vec![0.0; map.dof()]);
        assert_eq!(stepped(&*map, 0.3, &rest), rest, "{name}");
    }
}

/// e^−r + r − 1 is r²/2, rounded by ε r: more than is taken for its rounding. The step reports it, and a looser tolerance helps.
#[test]
fn energies_whose_terms_cancel_fail_near_equilibria() {
    let toda = Chain::new(TodaBond, 8, Ends::Periodic).unwrap();
    let model = Model::Separable(Arc::new(toda));
    assert!(near_rest(&model, 1e-4, 0.3).is_ok());
    let failure = near_rest(&model, 1e-7, 0.3).unwrap_err().to_string();
    assert!(failure.contains("a looser tolerance"), "{failure}");
    let loose = StageSolver {
        stop: Stop::Converged {
            tolerance: 1e-6,
            max_iterations: 200,
        },
        ..StageSolver::default()
    };
    let map = CATALOGUE
        .build(loose, "discrete-gradient", None, model)
        .unwrap();
    let start = (vec![1e-7; 8], vec![-1e-7; 8]);
    assert!(stepped(&*map, 0.3, &start).0.iter().all(|q| q.is_finite()));
}

/// H is the square root of what may be negative: the slopes are finite everywhere.
struct HalfDefined;

impl Hamiltonian for HalfDefined {
    fn dof(&self) -> usize {
        1
    }

    fn energy(&self, q: Rows<'_>, p: Rows<'_>, out: &mut [f64]) {
        for (k, out) in out.iter_mut().enumerate() {
            *out = p.row(0)[k] + (1.0 - q.row(0)[k]).sqrt();
        }
    }

    fn add_velocity(&self, tau: f64, _q: Rows<'_>, p: Rows<'_>, out: &mut RowsMut<'_>) {
        for (out, _) in out.row_mut(0).iter_mut().zip(p.row(0)) {
            *out += tau;
        }
    }

    fn add_force(&self, tau: f64, q: Rows<'_>, _p: Rows<'_>, out: &mut RowsMut<'_>) {
        for (out, q) in out.row_mut(0).iter_mut().zip(q.row(0)) {
            *out += tau * 0.5 / (1.0 - q).abs().sqrt();
        }
    }
}

#[test]
fn an_energy_that_is_not_a_number_fails_the_step() {
    let map = DiscreteGradient::new(HalfDefined, StageSolver::default()).unwrap();
    let (mut q, mut p) = (vec![0.9], vec![0.3]);
    let mut block = Block::new(RowsMut::new(&mut q, 1, 1, 1), RowsMut::new(&mut p, 1, 1, 1));
    let failure = map.advance(0.5, &mut block).unwrap_err();
    assert!(
        failure.reason.contains("left the finite"),
        "{}",
        failure.reason
    );
}

#[test]
fn a_sample_does_not_depend_on_its_block() {
    let map = DiscreteGradient::new(HenonHeiles, StageSolver::default()).unwrap();
    let circle = Circle::new(vec![0.1, 0.0], vec![0.2, -0.1], 0.3).unwrap();
    let mut ensemble = Ensemble::sample(&circle, 97).unwrap();
    let alone: Vec<State> = {
        let block = ensemble.block();
        let column = |k: usize| {
            let q = (0..2).map(|i| block.q.row(i)[k]).collect();
            (q, (0..2).map(|i| block.p.row(i)[k]).collect())
        };
        (0..97).map(|k| stepped(&map, 0.4, &column(k))).collect()
    };
    map.advance(0.4, &mut ensemble.block()).unwrap();
    let block = ensemble.block();
    for (k, (q, p)) in alone.iter().enumerate() {
        for i in 0..2 {
            assert_eq!((block.q.row(i)[k], block.p.row(i)[k]), (q[i], p[i]), "{k}");
        }
    }
}

fn solved(stop: Stop) -> DiscreteGradient<HenonHeiles> {
    let solver = StageSolver {
        stop,
        ..StageSolver::default()
    };
    DiscreteGradient::new(HenonHeiles, solver).unwrap()
}

#[test]
fn verdicts_on_steps_that_are_solved_and_not() {
    let circle = Circle::new(vec![0.0, 0.1], vec![0.3, 0.0], 0.2).unwrap();
    let verdict = |map: &dyn TimeAdvance| {
        let diagnosis = Diagnostic::halving(0, -6).run(map, &circle).unwrap();
        println!("{}", diagnosis.verdict);
        diagnosis.verdict
    };
    let exact = verdict(&solved(StageSolver::default().stop));
    assert_eq!(
        (exact.kind, exact.order),
        (VerdictKind::NotSymplectic, Some(3.0))
    );
    let twice = verdict(&solved(Stop::Iterations(2)));
    assert_eq!(twice.kind, VerdictKind::NotSymplectic);
    let loose = verdict(&solved(Stop::Converged {
        tolerance: 1e-6,
        max_iterations: 50,
    }));
    // The method itself changes loop integrals by far more than the jumps of the solver could.
    assert_eq!(loose.kind, VerdictKind::NotSymplectic);
    let cause = loose.cause.expect("the jumps show the solver");
    assert!(
        cause.text.contains("stops at a tolerance"),
        "{}",
        cause.text
    );
}

/// The energy is conserved as far as the equations are solved.
#[test]
fn energy_errors_follow_the_tolerance() {
    let start = (vec![0.1, -0.2], vec![0.3, 0.2]);
    for tolerance in [1e-4, 1e-7, 1e-10] {
        let map = solved(Stop::Converged {
            tolerance,
            max_iterations: 50,
        });
        let error =
            energy(&HenonHeiles, &stepped(&map, 0.5, &start)) - energy(&HenonHeiles, &start);
        assert!(
            (1e-5 * tolerance..tolerance).contains(&error.abs()),
            "{tolerance:e}: {error:e}"
        );
    }
}

#[test]
fn what_cannot_be_solved_is_refused_or_fails() {
    let refused = |solver: StageSolver| {
        let map = CATALOGUE.build(solver, "discrete-gradient", None, Arc::new(HenonHeiles));
        map.map(|_| ()).unwrap_err()
    };
    let newton = StageSolver {
        solver: Solver::Newton,
        ..StageSolver::default()
    };
    assert!(matches!(refused(newton), ModelError::NoNewton { .. }));
    let none = StageSolver {
        stop: Stop::Iterations(0),
        ..StageSolver::default()
    };
    assert!(matches!(refused(none), ModelError::NoIterations));

    let failure = |map: &dyn TimeAdvance, h: f64, q: [f64; 4]| {
        let (mut q, mut p) = (q.to_vec(), vec![0.1; 4]);
        let mut block = Block::new(RowsMut::new(&mut q, 2, 2, 2), RowsMut::new(&mut p, 2, 2, 2));
        map.advance(h, &mut block).unwrap_err()
    };
    let hasty = solved(Stop::Converged {
        tolerance: 1e-15,
        max_iterations: 2,
    });
    // The first sample rests, and is solved.
    let found = failure(&hasty, 0.5, [0.3; 4]);
    assert!(
        found.reason.contains("did not converge in 2"),
        "{}",
        found.reason
    );
    let exact = solved(StageSolver::default().stop);
    let found = failure(&exact, 0.5, [0.1, f64::NAN, 0.1, 0.1]);
    assert_eq!(found.sample, 1);
    assert!(
        found.reason.contains("left the finite numbers"),
        "{}",
        found.reason
    );
}

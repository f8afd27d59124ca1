//! The Jacobian test by differences against exact Jacobians, on maps with breaks and noise, and within budgets.

mod breaks_and_noise;
mod budget;
mod closed_forms;
mod dual_numbers;
mod errors;
mod many_dofs;

use symplint::jacobian::{JacobianEvidence, TangentDefect};
use symplint::verdict::JacobianVerdict;
use symplint::{Block, Circle, JacobianTest, Loop, PerSample, StepFailure, TimeAdvance};

fn circle(dof: usize) -> Circle {
    Circle::new(vec![0.3; dof], vec![-0.2; dof], 1.0).unwrap()
}

fn run(map: &dyn TimeAdvance, phase_loop: &dyn Loop, h: f64) -> JacobianEvidence {
    JacobianTest::default().run(map, phase_loop, h).unwrap()
}

fn worst_of(report: &JacobianEvidence) -> TangentDefect {
    match report.verdict() {
        JacobianVerdict::NotSymplectic { worst } => worst,
        other => panic!("{other}"),
    }
}

#[track_caller]
fn assert_symplectic(report: &JacobianEvidence, least_digits: f64) {
    match report.verdict() {
        JacobianVerdict::SymplecticAlmostEverywhere { digits } => {
            assert!(digits >= least_digits, "{digits} digits");
        }
        other => panic!("{other}"),
    }
}

/// That every point of one degree of freedom has det DΦ − 1 = `exact` within its error bar.
#[track_caller]
fn assert_determinant(report: &JacobianEvidence, exact: f64, tolerance: f64) {
    for point in &report.points {
        let found = point
            .worst
            .unwrap_or_else(|| panic!("no derivative at s = {}", point.s));
        let off = (found.signed - exact).abs();
        assert!(
            off <= found.uncertainty && found.uncertainty < tolerance,
            "s = {}: {:e} for {exact:e}, off by {off:e}, error bar {:e}",
            point.s,
            found.signed,
            found.uncertainty
        );
    }
}

/// A map without its tangent map.
struct Bare<M>(M);

impl<M: TimeAdvance> TimeAdvance for Bare<M> {
    fn dof(&self) -> usize {
        self.0.dof()
    }
    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.0.advance(h, block)
    }
}

/// Pendula side by side, each with its own frequency, by symplectic Euler, after what `spoil` does.
fn pendula(
    dof: usize,
    spoil: impl Fn(f64, &mut [f64], &mut [f64]) + Send + Sync,
) -> impl TimeAdvance {
    PerSample::new(dof, move |h, q: &mut [f64], p: &mut [f64]| {
        spoil(h, q, p);
        for i in 0..q.len() {
            let next = (i + 1) % q.len();
            let before = (i + q.len() - 1) % q.len();
            let springs = (q[next] - q[i]).sin() - (q[i] - q[before]).sin();
            p[i] += h * (springs - (1.0 + 0.01 * i as f64) * q[i].sin());
        }
        for i in 0..q.len() {
            q[i] += h * p[i];
        }
    })
}

/// A kick by `force`, then a drift.
fn kick_drift(force: impl Fn(f64) -> f64 + Send + Sync) -> impl TimeAdvance {
    PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        p[0] += h * force(q[0]);
        q[0] += h * p[0];
    })
}

/// A kick and a drift in single precision, with momenta damped by a factor.
fn single_precision(damping: f64) -> impl TimeAdvance {
    PerSample::new(1, move |h, q: &mut [f64], p: &mut [f64]| {
        let (h, x) = (h as f32, q[0] as f32);
        let y = (p[0] as f32 - h * x.sin()) * damping as f32;
        q[0] = f64::from(x + h * y);
        p[0] = f64::from(y);
    })
}

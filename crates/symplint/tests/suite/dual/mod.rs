//! Exact derivatives of a few steps by dual numbers.
//!
//! Steps are written once for any scalar: with `f64` they are the map under test, with [`Dual64`] they
//! carry one tangent vector along, as the tangent map of that map.

use num_dual::{Dual64, DualNum};
use symplint::map::{Capabilities, TangentMap};
use symplint::state::RowsMut;
use symplint::{Block, StepFailure, TimeAdvance};

/// A double or a dual number.
pub trait Scalar: DualNum<Primitive = f64> + Copy {}

impl<S: DualNum<Primitive = f64> + Copy> Scalar for S {}

#[derive(Clone, Copy, Debug)]
pub enum System {
    Pendulum,
    /// H = p²/2 + √(q² + ε²).
    Rounded(f64),
    HenonHeiles,
}

pub const SYSTEMS: [System; 4] = [
    System::Pendulum,
    System::Rounded(0.5),
    System::Rounded(0.02),
    System::HenonHeiles,
];

impl System {
    pub fn dof(self) -> usize {
        match self {
            System::HenonHeiles => 2,
            _ => 1,
        }
    }

    fn force<S: Scalar>(self, q: &[S]) -> Vec<S> {
        match self {
            System::Pendulum => vec![-q[0].sin()],
            // By the reciprocal, so that doubles and dual numbers round alike.
            System::Rounded(epsilon) => {
                vec![-q[0] * (q[0] * q[0] + epsilon * epsilon).sqrt().recip()]
            }
            System::HenonHeiles => {
                let (x, y) = (q[0], q[1]);
                vec![-(x + x * y * 2.0), y * y - x * x - y]
            }
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    Euler,
    SymplecticEuler,
    Strang,
    Midpoint,
    Heun,
}

pub const METHODS: [Method; 5] = [
    Method::Euler,
    Method::SymplecticEuler,
    Method::Strang,
    Method::Midpoint,
    Method::Heun,
];

impl Method {
    pub fn is_symplectic(self) -> bool {
        matches!(self, Method::SymplecticEuler | Method::Strang)
    }
}

fn add<S: Scalar>(x: &mut [S], tau: f64, y: &[S]) {
    for (x, y) in x.iter_mut().zip(y) {
        *x += *y * tau;
    }
}

/// One step, in place.
pub fn step<S: Scalar>(system: System, method: Method, h: f64, q: &mut [S], p: &mut [S]) {
    match method {
        Method::Euler => {
            let force = system.force(q);
            add(q, h, p);
            add(p, h, &force);
        }
        Method::SymplecticEuler => {
            add(p, h, &system.force(q));
            add(q, h, p);
        }
        Method::Strang => {
            add(q, 0.5 * h, p);
            add(p, h, &system.force(q));
            add(q, 0.5 * h, p);
        }
        Method::Midpoint => {
            let (mut q_half, mut p_half) = (q.to_vec(), p.to_vec());
            add(&mut q_half, 0.5 * h, p);
            add(&mut p_half, 0.5 * h, &system.force(q));
            add(q, h, &p_half);
            add(p, h, &system.force(&q_half));
        }
        Method::Heun => {
            let force = system.force(q);
            let (mut q_end, mut p_end) = (q.to_vec(), p.to_vec());
            add(&mut q_end, h, p);
            add(&mut p_end, h, &force);
            add(q, 0.5 * h, p);
            add(q, 0.5 * h, &p_end);
            add(p, 0.5 * h, &force);
            add(p, 0.5 * h, &system.force(&q_end));
        }
    }
}

/// One step of a method, with its tangent map.
#[derive(Clone, Copy, Debug)]
pub struct Step(pub System, pub Method);

impl TimeAdvance for Step {
    fn dof(&self) -> usize {
        self.0.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        for k in 0..block.len() {
            let column = |rows: &RowsMut<'_>| -> Vec<f64> {
                (0..rows.count()).map(|i| rows.row(i)[k]).collect()
            };
            let (mut q, mut p) = (column(&block.q), column(&block.p));
            step(self.0, self.1, h, &mut q, &mut p);
            for i in 0..q.len() {
                block.q.row_mut(i)[k] = q[i];
                block.p.row_mut(i)[k] = p[i];
            }
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            tangent: Some(self),
            ..Capabilities::plain(self.dof())
        }
    }
}

impl TangentMap for Step {
    fn advance_tangents(
        &self,
        h: f64,
        states: &mut Block<'_>,
        tangents: &mut Block<'_>,
    ) -> Result<(), StepFailure> {
        for k in 0..states.len() {
            let lift = |values: &RowsMut<'_>, slopes: &RowsMut<'_>| {
                let dual = |i: usize| Dual64::new(values.row(i)[k], slopes.row(i)[k]);
                (0..values.count()).map(dual).collect::<Vec<Dual64>>()
            };
            let (mut q, mut p) = (lift(&states.q, &tangents.q), lift(&states.p, &tangents.p));
            step(self.0, self.1, h, &mut q, &mut p);
            for i in 0..q.len() {
                states.q.row_mut(i)[k] = q[i].re;
                states.p.row_mut(i)[k] = p[i].re;
                tangents.q.row_mut(i)[k] = q[i].eps;
                tangents.p.row_mut(i)[k] = p[i].eps;
            }
        }
        Ok(())
    }
}

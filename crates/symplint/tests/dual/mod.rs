//! Exact derivatives of a few steps by dual numbers, a + b ε with ε² = 0.
//!
//! Steps are written once for any scalar: with `f64` they are the map under test, with [`Dual`] they
//! carry one tangent vector along.

use std::ops::{Add, Mul, Sub};

use symplint::{Block, Loop, RowsMut};

pub trait Scalar:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Mul<f64, Output = Self>
{
    fn sin(self) -> Self;
    /// x / √(x² + ε²).
    fn over_hypot(self, epsilon: f64) -> Self;
}

impl Scalar for f64 {
    fn sin(self) -> Self {
        f64::sin(self)
    }
    fn over_hypot(self, epsilon: f64) -> Self {
        self / self.hypot(epsilon)
    }
}

#[derive(Clone, Copy)]
pub struct Dual {
    value: f64,
    slope: f64,
}

impl Add for Dual {
    type Output = Dual;
    fn add(self, other: Dual) -> Dual {
        Dual {
            value: self.value + other.value,
            slope: self.slope + other.slope,
        }
    }
}

impl Sub for Dual {
    type Output = Dual;
    fn sub(self, other: Dual) -> Dual {
        self + other * -1.0
    }
}

impl Mul for Dual {
    type Output = Dual;
    fn mul(self, other: Dual) -> Dual {
        Dual {
            value: self.value * other.value,
            slope: self.value * other.slope + self.slope * other.value,
        }
    }
}

impl Mul<f64> for Dual {
    type Output = Dual;
    fn mul(self, factor: f64) -> Dual {
        Dual {
            value: self.value * factor,
            slope: self.slope * factor,
        }
    }
}

impl Scalar for Dual {
    fn sin(self) -> Dual {
        Dual {
            value: self.value.sin(),
            slope: self.slope * self.value.cos(),
        }
    }
    fn over_hypot(self, epsilon: f64) -> Dual {
        let root = self.value.hypot(epsilon);
        Dual {
            value: self.value / root,
            slope: self.slope * epsilon * epsilon / root.powi(3),
        }
    }
}

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
            System::Pendulum => vec![q[0].sin() * -1.0],
            System::Rounded(epsilon) => vec![q[0].over_hypot(epsilon) * -1.0],
            System::HenonHeiles => {
                let (x, y) = (q[0], q[1]);
                vec![(x + x * y * 2.0) * -1.0, y * y - x * x - y]
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
        *x = *x + *y * tau;
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

/// The columns of DΦ at γ(s), positions first.
pub fn exact_jacobian(
    system: System,
    method: Method,
    h: f64,
    phase_loop: &dyn Loop,
    s: f64,
) -> Vec<Vec<f64>> {
    let dof = system.dof();
    let (mut q, mut p) = (vec![0.0; dof], vec![0.0; dof]);
    let mut block = Block::new(
        RowsMut::new(&mut q, dof, 1, 1),
        RowsMut::new(&mut p, dof, 1, 1),
    );
    phase_loop.sample(&[s], &mut block);
    let column = |c: usize| {
        let lift = |first: usize, values: &[f64]| -> Vec<Dual> {
            let lifted = values.iter().enumerate().map(|(i, &value)| Dual {
                value,
                slope: if first + i == c { 1.0 } else { 0.0 },
            });
            lifted.collect()
        };
        let (mut q, mut p) = (lift(0, &q), lift(dof, &p));
        step(system, method, h, &mut q, &mut p);
        q.iter().chain(&p).map(|dual| dual.slope).collect()
    };
    (0..2 * dof).map(column).collect()
}

//! The implicit midpoint rule, solved by fixed-point iteration to a tolerance.

use std::sync::Arc;

use num_dual::DualNum;
use symplint::{PerSample, TimeAdvance};

/// dz/dt of a Hamiltonian system; states are positions, then momenta.
pub trait Field: Send + Sync + 'static {
    const DOF: usize;

    fn rate<D: DualNum<Primitive = f64> + Copy>(z: &[D], rate: &mut [D]);
}

/// H = p²/2 − cos q.
pub struct Pendulum;

impl Field for Pendulum {
    const DOF: usize = 1;

    fn rate<D: DualNum<Primitive = f64> + Copy>(z: &[D], rate: &mut [D]) {
        rate[0] = z[1];
        rate[1] = -z[0].sin();
    }
}

/// H = (|p|² + |q|²)/2 + q_0² q_1 − q_1³/3.
pub struct HenonHeiles;

impl Field for HenonHeiles {
    const DOF: usize = 2;

    fn rate<D: DualNum<Primitive = f64> + Copy>(z: &[D], rate: &mut [D]) {
        rate[0] = z[2];
        rate[1] = z[3];
        rate[2] = -(z[0] + z[0] * z[1] * 2.0);
        rate[3] = -(z[1] + z[0] * z[0] - z[1] * z[1]);
    }
}

/// H = p_0²/2 + (p_1 − A(q_0))²/2, A = x + 0.15 x²: a charged particle in a magnetic field 1 + 0.3 x.
pub struct Charged;

impl Field for Charged {
    const DOF: usize = 2;

    fn rate<D: DualNum<Primitive = f64> + Copy>(z: &[D], rate: &mut [D]) {
        let potential = z[0] + z[0] * z[0] * 0.15;
        let velocity = z[3] - potential;
        rate[0] = z[2];
        rate[1] = velocity;
        rate[2] = velocity * (z[0] * 0.3 + 1.0);
        rate[3] = D::from(0.0);
    }
}

/// One iteration: z ← z_0 + h f((z_0 + z)/2).
pub fn iterate<F: Field, D: DualNum<Primitive = f64> + Copy>(h: f64, start: &[D], z: &mut [D]) {
    let mut middle = [D::from(0.0); 4];
    let mut rate = [D::from(0.0); 4];
    let width = 2 * F::DOF;
    for c in 0..width {
        middle[c] = (start[c] + z[c]) * 0.5;
    }
    F::rate(&middle[..width], &mut rate[..width]);
    for c in 0..width {
        z[c] = start[c] + rate[c] * h;
    }
}

/// Iterates until no coordinate changes by the tolerance; returns the number of iterations.
pub fn solve<F: Field>(h: f64, tolerance: f64, z: &mut [f64]) -> usize {
    let mut start = [0.0; 4];
    let mut last = [0.0; 4];
    let width = 2 * F::DOF;
    start[..width].copy_from_slice(z);
    for count in 1..200 {
        last[..width].copy_from_slice(z);
        iterate::<F, f64>(h, &start[..width], z);
        let changes = z.iter().zip(&last).map(|(z, last)| (z - last).abs());
        if changes.fold(0.0, f64::max) < tolerance {
            return count;
        }
    }
    panic!("no convergence");
}

/// The map that is diagnosed.
pub fn map<F: Field>(tolerance: f64) -> Arc<dyn TimeAdvance> {
    let dof = F::DOF;
    Arc::new(PerSample::new(
        dof,
        move |h, q: &mut [f64], p: &mut [f64]| {
            let mut z = [0.0; 4];
            z[..dof].copy_from_slice(q);
            z[dof..2 * dof].copy_from_slice(p);
            solve::<F>(h, tolerance, &mut z[..2 * dof]);
            q.copy_from_slice(&z[..dof]);
            p.copy_from_slice(&z[dof..2 * dof]);
        },
    ))
}

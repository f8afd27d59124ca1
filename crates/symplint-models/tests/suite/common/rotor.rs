//! A system with a period and a weight, for tests.

use std::f64::consts::TAU;

use symplint::Coordinates;
use symplint::state::{Rows, RowsMut};
use symplint_models::Separable;
use symplint_models::systems::Pendulum;

/// A pendulum whose positions are stored in a period and whose momenta are velocities.
pub struct Rotor(pub Pendulum);

impl Separable for Rotor {
    fn dof(&self) -> usize {
        1
    }
    fn kick(&self, tau: f64, q: Rows<'_>, p: &mut RowsMut<'_>) {
        self.0.kick(tau, q, p);
    }
    fn potential_energy(&self, q: Rows<'_>, out: &mut [f64]) {
        self.0.potential_energy(q, out);
    }
    fn coordinates(&self) -> Coordinates {
        let plain = Coordinates::plain(1).with_periods(vec![TAU]).unwrap();
        plain.with_weights(vec![3.0]).unwrap()
    }
}

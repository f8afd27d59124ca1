//! One state at a time, for tests.

use std::f64::consts::TAU;

use symplint::{Block, Coordinates, Rows, RowsMut, TimeAdvance};
use symplint_models::Separable;
use symplint_models::systems::Pendulum;

/// A pendulum whose positions are stored in a period and whose momenta are velocities.
#[allow(dead_code)]
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

/// A state (q, p).
pub type State = (Vec<f64>, Vec<f64>);

/// Advances one state by one step.
pub fn stepped(map: &dyn TimeAdvance, h: f64, (q, p): &State) -> State {
    let (mut q, mut p) = (q.clone(), p.clone());
    let dof = q.len();
    let mut block = Block::new(
        RowsMut::new(&mut q, dof, 1, 1),
        RowsMut::new(&mut p, dof, 1, 1),
    );
    map.advance(h, &mut block).expect("these maps do not fail");
    (q, p)
}

/// Advances one state by `steps` steps to `time`.
#[allow(dead_code)]
pub fn at_time(map: &dyn TimeAdvance, time: f64, steps: u32, start: &State) -> State {
    let h = time / f64::from(steps);
    (0..steps).fold(start.clone(), |state, _| stepped(map, h, &state))
}

/// The largest difference of a coordinate.
#[allow(dead_code)]
pub fn distance(a: &State, b: &State) -> f64 {
    let pairs = a.0.iter().chain(&a.1).zip(b.0.iter().chain(&b.1));
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

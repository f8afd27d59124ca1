//! One state at a time, for tests.

use symplint::{Block, RowsMut, TimeAdvance};

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

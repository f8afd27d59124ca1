//! One state at a time, for tests.

use symplint::state::RowsMut;
use symplint::{Block, TimeAdvance};

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

/// The largest difference of a coordinate.
pub fn distance(a: &State, b: &State) -> f64 {
    let pairs = a.0.iter().chain(&a.1).zip(b.0.iter().chain(&b.1));
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

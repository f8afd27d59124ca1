//! Steps of all rows of a batch at once, as programs in other languages take them.

use std::sync::{Arc, Mutex};

use symplint::map::Capabilities;
use symplint::{Block, StepFailure, TimeAdvance};

use crate::truth_set::random::Random;
use crate::truth_set::systems::{self, System};

/// The states of a batch, (q, p) of each row.
pub type RowsOfBatch = Vec<(Vec<f64>, Vec<f64>)>;

/// A step of a batch, in the order of the calls.
struct Batches<F> {
    dof: usize,
    step: Mutex<F>,
}

impl<F: FnMut(f64, &mut RowsOfBatch) + Send> TimeAdvance for Batches<F> {
    fn dof(&self) -> usize {
        self.dof
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        let mut step = self.step.lock().unwrap();
        let column = |rows: &symplint::state::RowsMut<'_>, k: usize| -> Vec<f64> {
            (0..self.dof).map(|i| rows.row(i)[k]).collect()
        };
        let mut rows: RowsOfBatch = (0..block.len())
            .map(|k| (column(&block.q, k), column(&block.p, k)))
            .collect();
        step(h, &mut rows);
        for (k, (q, p)) in rows.iter().enumerate() {
            for i in 0..self.dof {
                (block.q.row_mut(i)[k], block.p.row_mut(i)[k]) = (q[i], p[i]);
            }
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            block_width: 1 << 20,
            ..Capabilities::plain(self.dof())
        }
    }
}

/// The map that a step of batches makes.
pub fn map_of_batches(
    dof: usize,
    step: impl FnMut(f64, &mut RowsOfBatch) + Send + 'static,
) -> Arc<dyn TimeAdvance> {
    Arc::new(Batches {
        dof,
        step: Mutex::new(step),
    })
}

/// A pendulum, Hénon–Heiles, or coupled oscillators.
pub fn small_system(random: &mut Random) -> System {
    match random.whole(0, 3) {
        0 => systems::pendulum(random),
        1 => systems::henon_heiles(random),
        _ => {
            let dof = random.whole(1, 4);
            systems::chain(random, dof)
        }
    }
}

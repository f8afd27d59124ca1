//! States taken out of the batches of a diagnosis, so that they can be advanced again later.

use std::sync::{Mutex, PoisonError};

use super::Grain;
use crate::state::{Block, Ensemble};

/// Loops whose states are kept: the given one and three others.
const MAX_LOOPS: usize = 4;

/// Batches of no more coordinates than this are kept as a whole, so that they can be repeated: 4 MiB.
const MAX_COORDINATES: usize = 1 << 19;

/// States of one batch, before and after the step.
#[derive(Clone, Debug)]
pub(crate) struct Witnesses {
    /// The loop, in the order in which loops were advanced; `None` for the first call of all.
    phase_loop: Option<usize>,
    pub h: f64,
    /// Rows of the batch.
    pub batch: usize,
    /// Which rows of it these states were.
    pub rows: Vec<usize>,
    pub before: Ensemble,
    pub after: Ensemble,
    /// The whole batch before the step, if it is small enough.
    pub whole: Option<Ensemble>,
}

/// Keeps states of the first call of a map, and of the largest batch of each loop.
#[derive(Debug, Default)]
pub(super) struct Recorder(Mutex<WitnessStore>);

#[derive(Debug, Default)]
struct WitnessStore {
    /// States of each batch; 0 if none are wanted.
    states: usize,
    phase_loop: usize,
    witnesses: Vec<Witnesses>,
}

/// States that are about to be advanced.
pub(super) struct PendingStates {
    rows: Vec<usize>,
    before: Ensemble,
    whole: Option<Ensemble>,
}

impl Recorder {
    /// Begins to keep this number of states of a batch.
    pub fn begin(&self, states: usize) {
        self.kept(|kept| kept.states = states);
    }

    /// Another loop is advanced from now on.
    pub fn begin_loop(&self) {
        self.kept(|kept| kept.phase_loop += 1);
    }

    /// The states that were kept, in the order of the calls.
    pub fn witnesses(&self) -> Vec<Witnesses> {
        self.kept(|kept| kept.witnesses.clone())
    }

    /// Copies states of a batch that is about to be advanced, if they are to be kept.
    pub fn take(&self, block: &Block<'_>) -> Option<PendingStates> {
        let states = self.kept(|kept| kept.wanted(block))?;
        let last = block.len() - 1;
        let rows: Vec<usize> = match states.min(block.len()) {
            1 => vec![last],
            count => (0..count).map(|k| k * last / (count - 1)).collect(),
        };
        let before = rows_of(block, &rows);
        let is_small = 2 * block.dof() * block.len() <= MAX_COORDINATES;
        let whole = is_small.then(|| block.copy_of(0..block.len()));
        Some(PendingStates {
            rows,
            before,
            whole,
        })
    }

    /// Keeps the states that were taken, and the same rows of the advanced block.
    pub fn keep(&self, taken: PendingStates, h: f64, block: &Block<'_>) {
        let after = rows_of(block, &taken.rows);
        self.kept(|kept| {
            let phase_loop = (!kept.witnesses.is_empty()).then_some(kept.phase_loop);
            kept.witnesses
                .retain(|other| phase_loop.is_none() || other.phase_loop != phase_loop);
            kept.witnesses.push(Witnesses {
                phase_loop,
                h,
                batch: block.len(),
                rows: taken.rows,
                before: taken.before,
                after,
                whole: taken.whole,
            });
        });
    }

    fn kept<R>(&self, work: impl FnOnce(&mut WitnessStore) -> R) -> R {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl WitnessStore {
    /// How many states of a block are to be kept, if any.
    fn wanted(&self, block: &Block<'_>) -> Option<usize> {
        let affordable = Grain::is_affordable(block.dof());
        if self.states == 0 || !affordable || block.len() < 2 || self.phase_loop >= MAX_LOOPS {
            return None;
        }
        let mut of_loop = (self.witnesses.iter())
            .filter(|witnesses| witnesses.phase_loop == Some(self.phase_loop));
        let is_larger = of_loop.all(|witnesses| block.len() >= 2 * witnesses.batch);
        // The first call, and loops after the first random one, have half as many.
        let full = !self.witnesses.is_empty() && self.phase_loop <= 1;
        is_larger.then_some(match full {
            true => self.states,
            false => self.states.div_ceil(2),
        })
    }
}

impl Witnesses {
    /// How many states are kept in a diagnosis at most, if this number is asked for.
    pub fn most(states: usize) -> usize {
        2 * states + (MAX_LOOPS - 1) * states.div_ceil(2)
    }

    /// Whether these are states of the loop that is advanced first.
    pub fn is_of_given_loop(&self) -> bool {
        self.phase_loop == Some(0)
    }
}

/// Some rows of a batch.
fn rows_of(block: &Block<'_>, rows: &[usize]) -> Ensemble {
    let mut states = Ensemble::zeros(block.dof(), rows.len());
    let copy = states.block();
    for (from, mut to) in [(&block.q, copy.q), (&block.p, copy.p)] {
        for i in 0..from.count() {
            for (to, &row) in to.row_mut(i).iter_mut().zip(rows) {
                *to = from.row(i)[row];
            }
        }
    }
    states
}

//! Calls that are not made here, but asked for: rounds of them go to the jobs of a scheduler.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::journal::{Call, Journal, Key, Request, key};
use symplint::{Block, Ensemble, StepFailure};

/// The calls of a run that its journal does not have yet.
pub struct PlannedCalls {
    journal: Arc<Journal>,
    /// Calls that failed, and are not asked for again.
    failed: HashMap<Call, StepFailure>,
    asked: Mutex<PendingCalls>,
}

#[derive(Default)]
struct PendingCalls {
    /// Calls that were announced, and are not asked for yet.
    begun: HashMap<Key, VecDeque<Call>>,
    missing: Vec<Request>,
}

impl PlannedCalls {
    /// Calls are taken from the journal, or have failed.
    pub fn new(journal: Arc<Journal>, failed: HashMap<Call, StepFailure>) -> Self {
        PlannedCalls {
            journal,
            failed,
            asked: Mutex::default(),
        }
    }

    /// Takes note of a call that will be asked for.
    pub fn begin(&self, h: f64, mut states: Ensemble) {
        let call = self.journal.call(h, &states.block());
        let mut asked = self.asked();
        asked.begun.entry(call.0).or_default().push_back(call);
        if !self.journal.has(call) && !self.failed.contains_key(&call) {
            asked.missing.push(Request::new(call, h, states));
        }
    }

    /// What came of a call.
    ///
    /// # Errors
    /// If it failed, or is not made yet: then it is asked for.
    pub fn advance(&self, h: f64, mut states: Ensemble) -> Result<Ensemble, StepFailure> {
        let call = {
            let block = states.block();
            let mut asked = self.asked();
            let begun = asked.begun.get_mut(&key(h, &block));
            let begun = begun.and_then(VecDeque::pop_front);
            begun.unwrap_or_else(|| self.journal.call(h, &block))
        };
        if let Some(failure) = self.failed.get(&call) {
            return Err(failure.clone());
        }
        if self.replay(call, &mut states.block())? {
            return Ok(states);
        }
        let mut asked = self.asked();
        if !asked.missing.iter().any(|request| request.call == call) {
            asked.missing.push(Request::new(call, h, states));
        }
        Err(StepFailure {
            sample: 0,
            reason: "the call is not made yet".to_owned(),
        })
    }

    fn replay(&self, call: Call, block: &mut Block<'_>) -> Result<bool, StepFailure> {
        Ok(self.journal.replay(call, block)?)
    }

    /// Whether calls are missing: then the diagnosis cannot continue.
    pub fn lacks_calls(&self) -> bool {
        !self.asked().missing.is_empty()
    }

    /// The calls that are missing, in an order that depends on nothing but them.
    pub fn missing(&self) -> Vec<Request> {
        let mut missing = std::mem::take(&mut self.asked().missing);
        missing.sort_by(|a, b| b.h.total_cmp(&a.h).then(a.call.cmp(&b.call)));
        missing
    }

    fn asked(&self) -> MutexGuard<'_, PendingCalls> {
        self.asked.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

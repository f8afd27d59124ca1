//! Evaluations of a map, counted.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::error::Error;

/// Evaluations made so far, and how many may be made.
///
/// Whoever plans asks for [`left`](Self::left) first; a call that does not fit is refused.
#[derive(Debug)]
pub(crate) struct EvaluationCount {
    made: AtomicUsize,
    budget: usize,
    /// Kept for later.
    reserved: AtomicUsize,
    /// Evaluations finished, for others to read.
    finished: Arc<AtomicUsize>,
}

impl EvaluationCount {
    /// No evaluations made, at most `budget` allowed.
    pub fn new(budget: usize) -> Self {
        EvaluationCount {
            made: AtomicUsize::new(0),
            budget,
            reserved: AtomicUsize::new(0),
            finished: Arc::default(),
        }
    }

    /// No limit.
    pub fn unlimited() -> Self {
        Self::new(usize::MAX)
    }

    /// Evaluations that may be made in all.
    pub fn budget(&self) -> usize {
        self.budget
    }

    /// Evaluations made.
    pub fn made(&self) -> usize {
        self.made.load(Ordering::Relaxed)
    }

    /// Evaluations that may still be made, without those that are reserved.
    pub fn left(&self) -> usize {
        let reserved = self.reserved.load(Ordering::Relaxed);
        self.budget
            .saturating_sub(self.made())
            .saturating_sub(reserved)
    }

    /// Keeps this number of evaluations for later, instead of those that were reserved before.
    pub fn reserve(&self, evaluations: usize) {
        self.reserved.store(evaluations, Ordering::Relaxed);
    }

    /// Counts evaluations that are about to be made.
    ///
    /// # Errors
    /// If they are more than are left.
    pub fn take(&self, evaluations: usize) -> Result<(), Error> {
        let left = self.left();
        if evaluations > left {
            return Err(Error::BudgetSpent {
                budget: self.budget,
                left,
                wanted: evaluations,
            });
        }
        self.made.fetch_add(evaluations, Ordering::Relaxed);
        Ok(())
    }

    /// Notes that evaluations were finished.
    pub fn finish(&self, evaluations: usize) {
        self.finished.fetch_add(evaluations, Ordering::Relaxed);
    }

    /// The number of evaluations finished, which other threads may read.
    pub fn finished(&self) -> &Arc<AtomicUsize> {
        &self.finished
    }
}

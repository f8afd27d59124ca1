//! How far a diagnosis has come.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use crate::evidence::Check;

/// How far a diagnosis has come. Any thread may read it while the diagnosis runs.
///
/// ```
/// use std::sync::{Arc, OnceLock};
///
/// use symplint::diagnosis::{Event, Progress};
/// use symplint::{Circle, Diagnostic, PerSample};
///
/// let spring = PerSample::new(1, |h, q, p| {
///     q[0] += h * p[0];
///     p[0] -= h * q[0];
/// });
/// let circle = Circle::new(vec![1.0], vec![0.0], 0.5)?;
/// let progress: OnceLock<Arc<Progress>> = OnceLock::new();
/// let diagnosis = Diagnostic::default().run_watched(&spring, &circle, &|event| {
///     if let Event::Started(started) = event {
///         let _ = progress.set(Arc::clone(started));
///     }
/// })?;
/// let progress = progress.get().expect("the diagnosis started");
/// assert_eq!(progress.finished(), diagnosis.evidence.evaluations.made);
/// # Ok::<(), symplint::Error>(())
/// ```
#[derive(Debug)]
pub struct Progress {
    finished: Arc<AtomicUsize>,
    limit: usize,
    /// Evaluations for each one that is counted: a map may be composed with itself.
    repeat: usize,
    expected: Mutex<Forecast>,
}

/// The check under way, and the evaluations that are expected.
#[derive(Clone, Copy, Debug, Default)]
struct Forecast {
    check: Option<Check>,
    /// Evaluations finished when the check ends, and those of all later checks. Unknown before the first step of the given loop.
    of_check: Option<(usize, usize)>,
}

impl Progress {
    /// No evaluation is finished.
    pub(super) fn new(finished: &Arc<AtomicUsize>, limit: usize, repeat: usize) -> Self {
        Progress {
            finished: Arc::clone(finished),
            limit,
            repeat,
            expected: Mutex::default(),
        }
    }

    /// Evaluations finished.
    pub fn finished(&self) -> usize {
        self.counted().saturating_mul(self.repeat)
    }

    /// The most evaluations that the diagnosis may make.
    pub fn limit(&self) -> usize {
        self.limit.saturating_mul(self.repeat)
    }

    /// The check under way.
    pub fn check(&self) -> Option<Check> {
        self.expected().check
    }

    /// Evaluations that the diagnosis is expected to make until it ends. `None` as long as the number of samples that the
    /// given loop needs is unknown.
    ///
    /// The number is an estimate: some checks are made only if an earlier one shows a defect.
    pub fn left(&self) -> Option<usize> {
        let (end, later) = self.expected().of_check?;
        let left = end.saturating_sub(self.counted()).saturating_add(later);
        Some(left.saturating_mul(self.repeat))
    }

    fn counted(&self) -> usize {
        self.finished.load(Ordering::Relaxed)
    }

    fn expected(&self) -> Forecast {
        *self.expected.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Another check begins.
    pub(super) fn begin(&self, check: Check) {
        let mut expected = self.expected.lock().unwrap_or_else(PoisonError::into_inner);
        expected.check = Some(check);
    }

    /// The check under way is expected to make `of_check` more evaluations, and all later ones `later`. They cannot exceed the
    /// limit.
    pub(super) fn expect(&self, of_check: usize, later: usize) {
        let made = self.counted();
        let left = self.limit.saturating_sub(made);
        let of_check = of_check.min(left);
        let later = later.min(left - of_check);
        let mut expected = self.expected.lock().unwrap_or_else(PoisonError::into_inner);
        expected.of_check = Some((made + of_check, later));
    }
}

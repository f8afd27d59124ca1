//! The progress of a diagnosis as one line of text.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use symplint::diagnosis::Progress;
use symplint::evidence::Check;

use crate::number::in_thousands;

/// Cells of the bar.
const WIDTH: usize = 12;

/// A rate is shown after this time: the first evaluations are often slower than the others.
const MIN_TIME: Duration = Duration::from_secs(3);

/// The rate is measured over the last part of the run, because results of an earlier run arrive first and take no time.
const PART: u32 = 2;

/// Notes of the rate in memory, about.
const NOTES: u32 = 200;

/// A line that shows how far a diagnosis has come: a bar, the check under way, the time left, and the evaluations.
#[derive(Debug)]
pub struct ProgressLine {
    progress: Arc<Progress>,
    started: Instant,
    /// Evaluations finished at times before.
    noted: VecDeque<(Instant, usize)>,
}

impl ProgressLine {
    /// Begins to measure the rate.
    pub fn new(progress: &Arc<Progress>) -> Self {
        let started = Instant::now();
        ProgressLine {
            progress: Arc::clone(progress),
            started,
            noted: VecDeque::from([(started, progress.finished())]),
        }
    }

    /// The line at this moment. A rate needs several calls; about four in a second are enough.
    pub fn text(&mut self) -> String {
        self.text_at(Instant::now())
    }

    fn text_at(&mut self, now: Instant) -> String {
        let (finished, limit) = (self.progress.finished(), self.progress.limit());
        let mut text = match self.progress.left() {
            Some(left) => {
                let filled = WIDTH * finished / (finished + left).max(1);
                format!("{}{} ", "█".repeat(filled), "░".repeat(WIDTH - filled))
            }
            None => String::new(),
        };
        text.push_str(self.progress.check().map_or("starts", Check::label));
        if let Some(left) = self.time_left(now) {
            text.push_str(", ");
            text.push_str(&in_words(left));
        }
        format!(
            "{text}, {} of at most {} evaluations",
            in_thousands(finished),
            in_thousands(limit)
        )
    }

    /// The time that is expected to pass until the end. `None` if it is unknown: at the beginning, and if more evaluations are
    /// made than were expected.
    pub fn time_left(&mut self, now: Instant) -> Option<Duration> {
        let elapsed = now.saturating_duration_since(self.started);
        let finished = self.progress.finished();
        let is_due =
            |&(last, _): &(Instant, usize)| now.saturating_duration_since(last) >= elapsed / NOTES;
        if self.noted.back().is_none_or(is_due) {
            self.noted.push_back((now, finished));
        }
        let is_old =
            |&(time, _): &(Instant, usize)| now.saturating_duration_since(time) > elapsed / PART;
        while self.noted.len() > 1 && self.noted.get(1).is_some_and(is_old) {
            self.noted.pop_front();
        }
        let &(since, before) = self.noted.front()?;
        let made = finished - before;
        let left = self.progress.left().filter(|&left| left > 0)?;
        if elapsed < MIN_TIME || made == 0 {
            return None;
        }
        let seconds = now.saturating_duration_since(since).as_secs_f64();
        Duration::try_from_secs_f64(seconds * left as f64 / made as f64).ok()
    }
}

/// A duration in as many digits as an estimate deserves.
fn in_words(left: Duration) -> String {
    let seconds = left.as_secs_f64();
    let rounded = |value: f64| value.round() as u64;
    match seconds {
        ..10.0 => "a few seconds left".into(),
        ..95.0 => format!("about {} s left", 10 * rounded(seconds / 10.0)),
        ..5_700.0 => format!("about {} min left", rounded(seconds / 60.0)),
        ..170_000.0 => format!("about {} h left", rounded(seconds / 3_600.0)),
        _ => format!("about {} days left", rounded(seconds / 86_400.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};
    use std::sync::{Mutex, OnceLock};

    use symplint::diagnosis::Event;
    use symplint::{Circle, Diagnostic, PerSample};

    #[test]
    fn estimates_have_few_digits() {
        let words = |seconds: f64| in_words(Duration::from_secs_f64(seconds));
        assert_eq!(words(0.0), "a few seconds left");
        assert_eq!(words(36.0), "about 40 s left");
        assert_eq!(words(94.0), "about 90 s left");
        assert_eq!(words(95.0), "about 2 min left");
        assert_eq!(words(7_300.0), "about 2 h left");
        assert_eq!(words(200_000.0), "about 2 days left");
    }

    /// Each evaluation takes 60 ms of a clock that the map itself sets forward. The time left is compared with the time that is
    /// left until the end.
    #[test]
    fn the_time_left_is_within_a_factor_of_two_in_the_second_half() {
        const EVALUATION: Duration = Duration::from_millis(60);
        let line: OnceLock<Mutex<ProgressLine>> = OnceLock::new();
        let evaluations = AtomicU32::new(0);
        let estimates = Mutex::new(Vec::new());
        let map = PerSample::new(1, |h: f64, q: &mut [f64], p: &mut [f64]| {
            let elapsed = EVALUATION * (evaluations.fetch_add(1, Ordering::Relaxed) + 1);
            if let Some(line) = line.get() {
                let mut line = line.lock().unwrap();
                let now = line.started + elapsed;
                let text = line.text_at(now);
                assert!(text.contains("of at most 1,000 evaluations"), "{text}");
                assert!(!text.contains(" 0 s"), "{text}");
                estimates
                    .lock()
                    .unwrap()
                    .push((elapsed, line.time_left(now)));
            }
            p[0] -= h * q[0].sin();
            q[0] += h * p[0];
        });
        let circle = Circle::new(vec![0.3], vec![0.5], 1.0).unwrap();
        let diagnostic = Diagnostic {
            budget: Some(1_000),
            ..Diagnostic::default()
        };
        (diagnostic.run_watched(&map, &circle, &|event| {
            if let Event::Started(progress) = event {
                let _ = line.set(Mutex::new(ProgressLine::new(progress)));
            }
        }))
        .unwrap();
        let length = EVALUATION * evaluations.load(Ordering::Relaxed);
        let mut compared = 0;
        // In the last tenth, "a few seconds" is enough.
        for &(at, left) in estimates.lock().unwrap().iter() {
            let Some(left) = left.filter(|_| at > length / 2 && at < length * 9 / 10) else {
                continue;
            };
            let factor = left.as_secs_f64() / (length - at).as_secs_f64();
            assert!(
                (0.5..2.0).contains(&factor),
                "{at:?} of {length:?}: {left:?} left"
            );
            compared += 1;
        }
        assert!(compared > 100, "{compared} estimates in {length:?}");
    }
}

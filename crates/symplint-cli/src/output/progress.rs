//! Progress on standard error, if that is a terminal.

use std::fmt::Write;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use symplint::diagnosis::Event;
use symplint_report::progress::ProgressLine;

/// A progress bar that may be hidden.
pub struct Progress {
    bar: ProgressBar,
}

/// Between two drawings of the bar.
const TICK: Duration = Duration::from_millis(250);

impl Progress {
    /// A bar that counts `unit`s of about equal cost, with the time left; hidden if `silent` or if standard error is not a terminal.
    pub fn steady(unit: &str, silent: bool) -> Self {
        Self::with_template(unit, ", {eta} left", silent)
    }

    /// The same for `unit`s whose cost, or number, is not known in advance: the time left is unknown.
    pub fn new(unit: &str, silent: bool) -> Self {
        Self::with_template(unit, "", silent)
    }

    fn with_template(unit: &str, left: &str, silent: bool) -> Self {
        let target = if silent {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        };
        let bar = ProgressBar::with_draw_target(Some(0), target);
        let template =
            format!("{{bar:40.cyan/dim}} {{pos}}/{{len}} {unit}, {{elapsed}}{left}  {{msg}}");
        if let Ok(style) = ProgressStyle::with_template(&template) {
            bar.set_style(style);
        }
        // The clock runs during long calls, too.
        bar.enable_steady_tick(TICK);
        Progress { bar }
    }

    /// Adds steps to the total.
    pub fn plan(&self, more: usize) {
        self.bar.inc_length(more as u64);
    }

    /// Counts a finished step.
    pub fn step(&self) {
        self.bar.inc(1);
    }

    /// Shows a message.
    fn say(&self, message: &str) {
        self.bar.set_message(message.to_owned());
        self.bar.tick();
    }

    /// Follows a diagnosis.
    pub fn diagnosis(&self, event: Event<'_>) {
        if let Event::Started(progress) = event {
            let line = Arc::new(Mutex::new(ProgressLine::new(progress)));
            let draw = move |_: &ProgressState, to: &mut dyn Write| {
                let mut line = line.lock().unwrap_or_else(PoisonError::into_inner);
                // A terminal that is gone needs no progress.
                let _ = to.write_str(&line.text());
            };
            if let Ok(style) = ProgressStyle::with_template("{diagnosis}") {
                self.bar.set_style(style.with_key("diagnosis", draw));
            }
        }
    }

    /// Follows the items of the paper.
    pub fn item(&self, event: symplint_paper::Progress) {
        match event {
            symplint_paper::Progress::Started(id) => self.say(id),
            symplint_paper::Progress::Finished(_) => self.step(),
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

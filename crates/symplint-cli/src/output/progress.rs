//! Progress on standard error, if that is a terminal.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use symplint::diagnosis::Event;
use symplint::verdict::step_size_text;
use symplint_report::number::in_thousands;

/// A progress bar that may be hidden.
pub struct Progress {
    bar: ProgressBar,
    /// Evaluations of the points that were measured.
    evaluations: AtomicUsize,
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
        Progress {
            bar,
            evaluations: AtomicUsize::new(0),
        }
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
        match event {
            Event::Planned(more) => self.plan(more),
            Event::Measured(point) => {
                self.step();
                let made = point.evaluations;
                let all = made + self.evaluations.fetch_add(made, Ordering::Relaxed);
                let is_last = self
                    .bar
                    .length()
                    .is_none_or(|all| self.bar.position() >= all);
                let now = match is_last {
                    // The Jacobian, for example. They report no points.
                    true => "further tests".to_owned(),
                    false if point.step_size.is_finite() => {
                        format!("after h = {}", step_size_text(point.step_size))
                    }
                    false => String::new(),
                };
                (self.bar).set_message(format!("{} evaluations  {now}", in_thousands(all)));
            }
            // The report names it.
            Event::Failed(_) => self.step(),
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

//! Progress on standard error, if that is a terminal.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use symplint::diagnosis::Event;
use symplint::verdict::step_size_text;

/// A progress bar that may be hidden.
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar that counts `unit`s; hidden if `silent` or if standard error is not a terminal.
    pub fn new(unit: &str, silent: bool) -> Self {
        let target = if silent {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        };
        let bar = ProgressBar::with_draw_target(Some(0), target);
        let template = format!(
            "{{bar:40.cyan/dim}} {{pos}}/{{len}} {unit}, {{elapsed}}, {{eta}} left  {{msg}}"
        );
        if let Ok(style) = ProgressStyle::with_template(&template) {
            bar.set_style(style);
        }
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
        match event {
            Event::Planned(more) => self.plan(more),
            Event::Measured(point) => {
                if point.step_size.is_finite() {
                    let message = format!("h = {}", step_size_text(point.step_size));
                    self.bar.set_message(message);
                }
                self.step();
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

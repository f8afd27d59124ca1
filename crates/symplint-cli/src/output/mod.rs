//! Texts that the program prints.

mod failure_message;
mod go_on;
mod progress;
mod say;
mod terminal;

pub use failure_message::failure_message;
pub use go_on::go_on;
pub use progress::Progress;
pub use say::{say, tell};
pub use terminal::{diagnosis_text, width};

//! What the program prints.

mod failure_message;
mod progress;
mod say;
mod terminal;

pub use failure_message::failure_message;
pub use progress::Progress;
pub use say::{say, tell};
pub use terminal::{verdict_text, width};

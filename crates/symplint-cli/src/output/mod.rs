//! What the program prints.

mod progress;
mod say;
mod terminal;

pub use progress::Progress;
pub use say::say;
pub use terminal::{verdict_text, width};

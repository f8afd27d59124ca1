//! One file for each command.

mod check;
mod failure;
mod init;
mod list;
mod measure;
mod no_options;
mod reproduce;
mod trace;
mod write_loop;

pub use check::check;
pub use failure::Failure;
pub use init::init;
pub use list::list;
pub use measure::{Stated, measure};
pub use reproduce::reproduce;
pub use trace::trace;
pub use write_loop::write_loop;

//! One file for each command.

mod check;
mod failure;
mod init;
mod list;
mod reproduce;
mod trace;

pub use check::check;
pub use failure::Failure;
pub use init::init;
pub use list::list;
pub use reproduce::reproduce;
pub use trace::trace;

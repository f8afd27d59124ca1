//! One file for each command.

mod advance;
mod check;
mod earlier_run;
mod init;
mod item_settings;
mod judge;
mod list;
mod loop_shape;
mod measure;
mod per_dof;
mod plan;
mod reproduce;
mod resume;
mod round;
mod run_output;
mod trace;
mod write_loop;

pub use advance::advance;
pub use check::check;
pub use init::init;
pub use judge::judge;
pub use list::list;
pub use measure::measure;
pub use plan::{collect, plan};
pub use reproduce::reproduce;
pub use resume::resume;
pub use trace::trace;
pub use write_loop::write_loop;

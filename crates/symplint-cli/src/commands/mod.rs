//! One file for each command.

mod advance;
mod check;
mod init;
mod installed;
mod item_settings;
mod judge;
mod list;
mod loop_shape;
mod measure;
mod per_dof;
mod plan;
mod reproduce;
mod resume;
mod trace;
mod write_loop;

use symplint_config::parse_number;
use symplint_run::RunOutput;

use crate::cli::Run;
use crate::failure::Failure;

pub use advance::advance;
pub use check::check;
pub use init::init;
pub use installed::{completions, man};
pub use judge::judge;
pub use list::list;
pub use measure::measure;
pub use plan::{collect, plan};
pub use reproduce::reproduce;
pub use resume::resume;
pub use trace::trace;
pub use write_loop::write_loop;

/// The folder of `--out` for a run of `command`, if it is given.
///
/// # Errors
/// If it must not or cannot be written to.
fn run_output(
    command: &str,
    config: &toml::Table,
    run: &Run,
) -> Result<Option<RunOutput>, Failure> {
    (run.out.as_deref())
        .map(|path| {
            RunOutput::open(path, command, config, run.force, parse_number).map_err(Failure::from)
        })
        .transpose()
}

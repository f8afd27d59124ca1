//! The `symplint` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(symplint_cli::run(std::env::args_os()))
}

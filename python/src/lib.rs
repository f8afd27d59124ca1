//! The native module of the Python package symplint.
//!
//! Python code in `symplint/` checks arguments and documents; what is computed is computed by the crates. This one
//! passes states between both:
//!
//! | module | holds |
//! | --- | --- |
//! | `memory` | memory that Rust and numpy arrays share, blocks on loan to another thread; all `unsafe` |
//! | `calls` | calls of Python functions from the threads of a diagnosis, served by the thread of the user |
//! | `pool` | threads for the work of the library |
//! | `functions` | the functions of the user |
//! | `block_call` | one of them called for the states of a block |
//! | `step` | maps, manifolds and loops made of functions, as the diagnostic sees them |
//! | `workers` | steps that other processes take |
//! | `arrays` | numbers from Python objects, and blocks from arrays of any order |
//! | `loops`, `models` | loops, systems and integrators of the library |
//! | `coordinates` | periods and weights |
//! | `check`, `measure`, `field` | a diagnosis; a comparison of loops; a test of a force or a vector field |
//! | `report` | what was found |
//! | `error` | errors as exceptions |

mod arrays;
mod block_call;
mod calls;
mod check;
mod coordinates;
mod error;
mod field;
mod functions;
mod loops;
mod measure;
mod memory;
mod models;
mod pool;
mod progress;
mod report;
mod step;
mod workers;

/// The native part of symplint.
#[pyo3::pymodule]
mod _native {
    use pyo3::prelude::*;

    /// Adds the version of the package.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }

    /// Runs the program with a command line, and returns its exit status.
    #[pyfunction]
    fn program(py: Python<'_>, arguments: Vec<std::ffi::OsString>) -> u8 {
        py.detach(|| symplint_cli::run(arguments))
    }

    #[pymodule_export]
    use crate::check::{advance_seconds, check, image, settings};
    #[pymodule_export]
    use crate::field::check_field;
    #[pymodule_export]
    use crate::loops::NativeLoop;
    #[pymodule_export]
    use crate::measure::{loop_integral, measure};
    #[pymodule_export]
    use crate::memory::Memory;
    #[pymodule_export]
    use crate::models::{Integrator, System, catalogue};
    #[pymodule_export]
    use crate::report::Report;
    #[pymodule_export]
    use crate::workers::{SharedJournal, advance};
}

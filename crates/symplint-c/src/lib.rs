//! The C interface of symplint.
//!
//! Functions return a [`SymplintStatus`], and `symplint_last_error` says in words what went wrong. No function aborts: a
//! panic, which would be an error of this library, is caught and becomes a status.
//!
//! | module | holds |
//! | --- | --- |
//! | `status` | what functions return, and the text of the last error |
//! | `pointers` | reading from and writing to memory of the caller |
//! | `integral` | loop integrals, of all degrees of freedom or of some, and their defect |
//! | `options` | the options of a check, which may grow |
//! | `callback` | the caller's step as a map |
//! | `check` | the diagnosis |
//! | `report` | what a diagnosis found |
//! | `field`, `field_options`, `field_report` | tests of a force or a vector field: the functions, their options, what was found |
//!
//! `unsafe` is in `pointers`, and in the exported functions of `status`, `integral`, `options`, `check`, `report` and the modules of
//! fields, which hand pointers of the caller on to it. `callback` and `field` call the caller's functions.

mod callback;
mod check;
mod field;
mod field_options;
mod field_report;
mod integral;
mod options;
mod pointers;
mod report;
mod status;

pub use callback::SymplintStep;
pub use check::symplint_check;
pub use field::{SymplintField, SymplintForce, symplint_check_field, symplint_check_force};
pub use field_options::{SymplintFieldOptions, symplint_field_options_init};
pub use field_report::{
    SymplintFieldReport, SymplintFieldVerdict, symplint_field_report_curl,
    symplint_field_report_digits, symplint_field_report_free, symplint_field_report_json,
    symplint_field_report_summary, symplint_field_report_text, symplint_field_report_verdict,
};
pub use integral::{
    SymplintDefect, SymplintIntegral, symplint_defect, symplint_loop_integral,
    symplint_merge_integrals, symplint_partial_integrals,
};
pub use options::{SymplintOptions, symplint_options_init};
pub use report::{
    SymplintReport, SymplintVerdict, symplint_report_digits, symplint_report_free,
    symplint_report_json, symplint_report_order, symplint_report_summary, symplint_report_verdict,
};
pub use status::{SymplintStatus, symplint_last_error, symplint_version};

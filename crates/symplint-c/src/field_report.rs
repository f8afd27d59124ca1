//! The result of a test of a force or a vector field.

use std::ffi::{CString, c_char};

use symplint::field::{FieldReport, FieldVerdict};

use crate::status::{Failure, SymplintStatus, text_of};

/// The result of a test of a force or a vector field. `symplint_check_force` and `symplint_check_field` make it, and
/// `symplint_field_report_free` frees it.
pub struct SymplintFieldReport {
    verdict: SymplintFieldVerdict,
    digits: f64,
    curl: Option<(f64, f64)>,
    summary: CString,
    text: CString,
    json: CString,
}

/// The kinds of verdicts on forces and vector fields.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SymplintFieldVerdict {
    /// The report is missing.
    None = -1,
    /// The force is a gradient, or the field Hamiltonian, down to the stated number of digits.
    Holds = 0,
    /// The force is not a gradient, or the field not Hamiltonian.
    Fails = 1,
    /// There is not enough evidence.
    Undecided = 3,
}

impl SymplintFieldReport {
    /// The report on what was found.
    pub fn new(found: &FieldReport) -> Result<Self, Failure> {
        let json = serde_json::to_string(found)
            .map_err(|error| Failure::new(SymplintStatus::Internal, error.to_string()))?;
        Ok(SymplintFieldReport {
            verdict: match found.verdict {
                FieldVerdict::Gradient | FieldVerdict::Hamiltonian => SymplintFieldVerdict::Holds,
                FieldVerdict::NotAGradient | FieldVerdict::NotHamiltonian => {
                    SymplintFieldVerdict::Fails
                }
                FieldVerdict::Undecided => SymplintFieldVerdict::Undecided,
            },
            digits: found.digits.unwrap_or(f64::NAN),
            curl: found.evidence.curl.map(|curl| (curl.value, curl.error)),
            summary: text_of(&format!("{}: {}", found.headline(), found.summary())),
            text: text_of(&found.to_string()),
            json: text_of(&json),
        })
    }

    /// For the caller, who frees it.
    pub fn into_pointer(self) -> *mut Self {
        Box::into_raw(Box::new(self))
    }
}

/// A property of a report, or a value for none.
///
/// # Safety
/// The report is null or one that this library made and that was not freed.
unsafe fn of<T>(
    report: *const SymplintFieldReport,
    none: T,
    property: impl FnOnce(&SymplintFieldReport) -> T,
) -> T {
    // SAFETY: what the caller promises.
    unsafe { report.as_ref() }.map_or(none, property)
}

/// The verdict; SYMPLINT_FIELD_VERDICT_NONE if `report` is NULL.
///
/// # Safety
/// `report` is NULL or was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_field_report_verdict(
    report: *const SymplintFieldReport,
) -> SymplintFieldVerdict {
    // SAFETY: what the caller of this function promises.
    unsafe { of(report, SymplintFieldVerdict::None, |report| report.verdict) }
}

/// The digits to which a force is a gradient or a field Hamiltonian; NaN for other verdicts, and for a constant force.
///
/// # Safety
/// `report` is NULL or was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_field_report_digits(report: *const SymplintFieldReport) -> f64 {
    // SAFETY: what the caller of this function promises.
    unsafe { of(report, f64::NAN, |report| report.digits) }
}

/// λ, the antisymmetric part of the Jacobian relative to the Jacobian, and its error in `*error`, unless that is NULL. Both are NaN if
/// λ was not measured.
///
/// # Safety
/// `report` is NULL or was not freed; `error` is NULL or points to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_field_report_curl(
    report: *const SymplintFieldReport,
    error: *mut f64,
) -> f64 {
    let none = (f64::NAN, f64::NAN);
    // SAFETY: what the caller of this function promises.
    let (value, of_value) = unsafe { of(report, none, |report| report.curl.unwrap_or(none)) };
    // SAFETY: as above.
    if let Some(error) = unsafe { error.as_mut() } {
        *error = of_value;
    }
    value
}

/// The verdict and its reason in one line, in UTF-8; NULL if `report` is NULL. Valid until the report is freed.
///
/// # Safety
/// `report` is NULL or was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_field_report_summary(
    report: *const SymplintFieldReport,
) -> *const c_char {
    // SAFETY: what the caller of this function promises.
    unsafe { of(report, std::ptr::null(), |report| report.summary.as_ptr()) }
}

/// The table of all loops and the verdict with its reasons, in UTF-8; NULL if `report` is NULL. Valid until the report is freed.
///
/// # Safety
/// `report` is NULL or was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_field_report_text(
    report: *const SymplintFieldReport,
) -> *const c_char {
    // SAFETY: what the caller of this function promises.
    unsafe { of(report, std::ptr::null(), |report| report.text.as_ptr()) }
}

/// The whole report as JSON, schema symplint/field/1; NULL if `report` is NULL. Valid until the report is freed.
///
/// # Safety
/// `report` is NULL or was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_field_report_json(
    report: *const SymplintFieldReport,
) -> *const c_char {
    // SAFETY: what the caller of this function promises.
    unsafe { of(report, std::ptr::null(), |report| report.json.as_ptr()) }
}

/// Frees a report and its texts; NULL is allowed.
///
/// # Safety
/// `report` is NULL or was not freed before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_field_report_free(report: *mut SymplintFieldReport) {
    if !report.is_null() {
        // SAFETY: `into_pointer` made it by `Box::into_raw`, and the caller promises that it was not freed.
        drop(unsafe { Box::from_raw(report) });
    }
}

//! The result of a diagnosis.

use std::ffi::{CString, c_char};

use symplint::{Diagnosis, VerdictKind};
use symplint_report::provenance::Provenance;
use symplint_report::report::Report;
use symplint_report::text::{DisplayOptions, diagnosis_text};

use crate::options::Settings;
use crate::status::text_of;

/// The report of a diagnosis. `symplint_check` makes it, and `symplint_report_free` frees it.
pub struct SymplintReport {
    verdict: SymplintVerdict,
    digits: f64,
    order: f64,
    summary: CString,
    text: CString,
    json: CString,
}

/// The kinds of verdicts.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SymplintVerdict {
    /// The report is missing.
    None = -1,
    /// No defect was found, down to the stated number of digits.
    Symplectic = 0,
    /// The loop integral changes significantly.
    NotSymplectic = 1,
    /// The map is discontinuous: it breaks loops.
    BrokenLoops = 2,
    /// There is not enough evidence.
    Undecided = 3,
}

/// One screen.
const SHOWN: DisplayOptions = DisplayOptions {
    width: Some(100),
    all: false,
};

impl SymplintReport {
    /// The report on some settings.
    pub fn new(settings: &Settings, diagnosis: &Diagnosis, provenance: Provenance) -> Self {
        let verdict = &diagnosis.verdict;
        let title = match settings.dof() {
            1 => "1 degree of freedom".to_owned(),
            dof => format!("{dof} degrees of freedom"),
        };
        SymplintReport {
            verdict: match verdict.kind {
                VerdictKind::Symplectic => SymplintVerdict::Symplectic,
                VerdictKind::NotSymplectic => SymplintVerdict::NotSymplectic,
                VerdictKind::BrokenLoops => SymplintVerdict::BrokenLoops,
                VerdictKind::Undecided => SymplintVerdict::Undecided,
            },
            digits: verdict.digits.unwrap_or(f64::NAN),
            order: verdict.order.unwrap_or(f64::NAN),
            summary: text_of(&verdict.to_string()),
            text: text_of(&format!(
                "{}\n{}",
                verdict.headline(),
                diagnosis_text(&title, diagnosis, SHOWN)
            )),
            json: text_of(&Report::new(settings, diagnosis, provenance).to_json()),
        }
    }
}

/// A property of a report, or a value for none.
///
/// # Safety
/// The report is null or one that `symplint_check` made and that was not freed.
unsafe fn of<T>(
    report: *const SymplintReport,
    none: T,
    property: impl FnOnce(&SymplintReport) -> T,
) -> T {
    // SAFETY: what the caller promises.
    unsafe { report.as_ref() }.map_or(none, property)
}

/// The verdict; SYMPLINT_VERDICT_NONE if `report` is NULL.
///
/// # Safety
/// `report` is NULL or was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_report_verdict(report: *const SymplintReport) -> SymplintVerdict {
    // SAFETY: what the caller of this function promises.
    unsafe { of(report, SymplintVerdict::None, |report| report.verdict) }
}

/// The digits to which a symplectic map conserves loop integrals; NaN for other verdicts.
///
/// # Safety
/// `report` is NULL or was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_report_digits(report: *const SymplintReport) -> f64 {
    // SAFETY: what the caller of this function promises.
    unsafe { of(report, f64::NAN, |report| report.digits) }
}

/// The order k of defect ~ h^k; NaN if no order is stated.
///
/// # Safety
/// `report` is NULL or was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_report_order(report: *const SymplintReport) -> f64 {
    // SAFETY: what the caller of this function promises.
    unsafe { of(report, f64::NAN, |report| report.order) }
}

/// The verdict and its reason in one line, in UTF-8; NULL if `report` is NULL. Valid until the report is freed.
///
/// # Safety
/// `report` is NULL or was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_report_summary(report: *const SymplintReport) -> *const c_char {
    // SAFETY: what the caller of this function promises.
    unsafe { of(report, std::ptr::null(), |report| report.summary.as_ptr()) }
}

/// The verdict with its table, its findings and what to do next, as the program prints them, in UTF-8; NULL if `report` is NULL. Valid until
/// the report is freed.
///
/// # Safety
/// `report` is NULL or was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_report_text(report: *const SymplintReport) -> *const c_char {
    // SAFETY: what the caller of this function promises.
    unsafe { of(report, std::ptr::null(), |report| report.text.as_ptr()) }
}

/// The whole report as JSON, schema symplint/report/3; NULL if `report` is NULL. Valid until the report is freed.
///
/// # Safety
/// `report` is NULL or was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_report_json(report: *const SymplintReport) -> *const c_char {
    // SAFETY: what the caller of this function promises.
    unsafe { of(report, std::ptr::null(), |report| report.json.as_ptr()) }
}

/// Frees a report and its texts; NULL is allowed.
///
/// # Safety
/// `report` is NULL or was not freed before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn symplint_report_free(report: *mut SymplintReport) {
    if !report.is_null() {
        // SAFETY: `symplint_check` made it by `Box::into_raw`, and the caller promises that it was not freed.
        drop(unsafe { Box::from_raw(report) });
    }
}

//! What functions return, and the text of the last error.

use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The result of a function.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SymplintStatus {
    /// No error.
    Ok = 0,
    /// A pointer that must not be null is null.
    NullPointer = 1,
    /// An argument or an option is not valid.
    BadArgument = 2,
    /// The step failed, or returned states that are not finite, at all step sizes; or a force or a field did.
    StepFailed = 3,
    /// The diagnosis is not possible: results depend on earlier calls, the loop has no area, and so on.
    Failed = 4,
    /// An error of this library. Please report it.
    Internal = 5,
}

/// A status with its text.
#[derive(Debug)]
pub struct Failure {
    pub status: SymplintStatus,
    pub text: String,
}

impl Failure {
    pub fn new(status: SymplintStatus, text: impl Into<String>) -> Self {
        Failure {
            status,
            text: text.into(),
        }
    }

    pub fn bad_argument(text: impl Into<String>) -> Self {
        Self::new(SymplintStatus::BadArgument, text)
    }

    pub fn null(what: &str) -> Self {
        Self::new(SymplintStatus::NullPointer, format!("{what} is null"))
    }

    /// The message of a panic.
    pub fn of_panic(panic: &(dyn Any + Send)) -> Self {
        let said = (panic.downcast_ref::<&str>().copied())
            .or_else(|| panic.downcast_ref::<String>().map(String::as_str));
        let text = format!("internal error: {}", said.unwrap_or("unknown"));
        Self::new(SymplintStatus::Internal, text)
    }
}

impl From<symplint::Error> for Failure {
    fn from(error: symplint::Error) -> Self {
        use symplint::Error;
        use symplint::error::{Dependence, LOOK_AT_MAP};
        let status = match &error {
            Error::StepFailed { .. } => SymplintStatus::StepFailed,
            Error::NotFinite {
                step_size, remedy, ..
            } => match step_size.is_some() || *remedy == LOOK_AT_MAP {
                true => SymplintStatus::StepFailed,
                false => SymplintStatus::BadArgument,
            },
            Error::Length { .. }
            | Error::BadCoordinate { .. }
            | Error::TooFewSamples { .. }
            | Error::StencilTooWide { .. }
            | Error::OutOfRange { .. }
            | Error::BadCentre { .. }
            | Error::TooLarge { .. }
            | Error::RepeatedStep { .. } => SymplintStatus::BadArgument,
            _ => SymplintStatus::Failed,
        };
        let layout = match &error {
            Error::Memory { dependence, .. } if *dependence == Dependence::Either => {
                "; position i of sample k is q[i * samples + k], q(k + 1, i + 1) in Fortran: arrays that are read in another order mix states"
            }
            _ => "",
        };
        Failure::new(status, format!("{error}{layout}"))
    }
}

thread_local! {
    static LAST_ERROR: RefCell<CString> = RefCell::default();
}

/// Does the work of an exported function: keeps the text of an error, and lets no panic out.
pub fn guarded(work: impl FnOnce() -> Result<(), Failure>) -> SymplintStatus {
    let result = catch_unwind(AssertUnwindSafe(work))
        .unwrap_or_else(|panic| Err(Failure::of_panic(&*panic)));
    let (status, text) = match result {
        Ok(()) => (SymplintStatus::Ok, String::new()),
        Err(failure) => (failure.status, failure.text),
    };
    LAST_ERROR.with_borrow_mut(|last| *last = text_of(&text));
    status
}

/// As a text of C, which ends at the first zero.
pub fn text_of(text: &str) -> CString {
    let bytes: Vec<u8> = text.bytes().filter(|&byte| byte != 0).collect();
    CString::new(bytes).unwrap_or_default()
}

/// The error message of the last call on this thread that returns a status; empty if there was no error.
///
/// In UTF-8. It is valid until the next call on this thread.
#[unsafe(no_mangle)]
pub extern "C" fn symplint_last_error() -> *const c_char {
    LAST_ERROR.with_borrow(|last| last.as_ptr())
}

/// The version of the library, such as "0.1.0". The text is always valid.
#[unsafe(no_mangle)]
pub extern "C" fn symplint_version() -> *const c_char {
    const VERSION: &CStr =
        match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
            Ok(version) => version,
            Err(_) => c"unknown",
        };
    VERSION.as_ptr()
}

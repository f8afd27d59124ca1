//! Complex working memory for Fourier transforms, kept for each thread so that a field solve does
//! not allocate.

use std::cell::RefCell;

use rustfft::num_complex::Complex64;

thread_local! {
    static IDLE: RefCell<Vec<Vec<Complex64>>> = const { RefCell::new(Vec::new()) };
}

/// Lends `work` a buffer of `len` values with unspecified contents. Calls may nest.
pub(super) fn with_complex_buffer<R>(len: usize, work: impl FnOnce(&mut [Complex64]) -> R) -> R {
    let mut buffer = IDLE.with_borrow_mut(Vec::pop).unwrap_or_default();
    if buffer.len() < len {
        buffer.resize(len, Complex64::ZERO);
    }
    let result = work(&mut buffer[..len]);
    IDLE.with_borrow_mut(|idle| idle.push(buffer));
    result
}

//! Complex working memory for Fourier transforms.

use bytemuck::cast_slice_mut;
use num_complex::Complex64;
use symplint::state::scratch::with_buffer;

/// Lends `work` a buffer of `len` complex values with unspecified contents. Calls may nest.
pub(super) fn with_complex_buffer<R>(len: usize, work: impl FnOnce(&mut [Complex64]) -> R) -> R {
    with_buffer(2 * len, |buffer| work(cast_slice_mut(buffer)))
}

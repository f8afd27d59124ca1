//! A hint to the processor.

/// Asks an x86-64 processor to load a value into its cache: the one that is this number of values after the first of `values`. If there is
/// none, the load is useless but does no harm.
#[inline(always)]
pub(crate) fn prefetch(values: &[f64], distance: usize) {
    let ahead = values.as_ptr().wrapping_add(distance);
    #[cfg(target_arch = "x86_64")]
    // SAFETY: every x86-64 processor has the instruction, which moves data between caches and may have any address.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        _mm_prefetch::<_MM_HINT_T0>(ahead.cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = ahead;
}

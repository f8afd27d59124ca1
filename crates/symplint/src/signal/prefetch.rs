//! A hint to the processor.

/// Asks an x86-64 processor to load the value at `index` of the next row into its cache. The next row is taken to begin where this one
/// ends; if it does not, the load is useless but does no harm.
#[inline(always)]
pub(crate) fn prefetch_next_row(row: &[f64], index: usize) {
    let behind = row.as_ptr().wrapping_add(row.len() + index);
    #[cfg(target_arch = "x86_64")]
    // SAFETY: every x86-64 processor has the instruction, which moves data between caches and may have any address.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        _mm_prefetch::<_MM_HINT_T0>(behind.cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = behind;
}

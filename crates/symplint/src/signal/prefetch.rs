//! A hint to the processor.

/// Fetches from memory, while other work goes on, what is one length of a row behind the value at `index`: in most tables a value of the
/// next row. Only x86-64 processors are asked.
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

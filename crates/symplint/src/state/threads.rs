//! Work that the threads of the current Rayon pool share.

use rayon::prelude::*;

/// A thread gets at least this many numbers, if each takes about a nanosecond. Calibrated: to wake a thread and to wait for it
/// takes 10 to 50 µs.
const MIN_NUMBERS_OF_THREAD: usize = 1 << 14;

/// Applies `each` to all items and returns the results in their order. One item costs about `numbers` operations. The calling thread
/// does all the work if it is too small for a second thread.
pub(crate) fn in_parallel<T: Send, R: Send>(
    items: impl IntoIterator<Item = T>,
    numbers: usize,
    each: impl Fn(T) -> R + Send + Sync,
) -> Vec<R> {
    let items: Vec<T> = items.into_iter().collect();
    let together = (MIN_NUMBERS_OF_THREAD / numbers.max(1)).max(1);
    if items.len() <= together {
        return items.into_iter().map(each).collect();
    }
    let shared = items.into_par_iter().with_min_len(together);
    shared.map(each).collect()
}

/// The same for items that are worth a thread each, such as blocks of states for a map.
pub(crate) fn each_in_parallel<T: Send, R: Send>(
    items: impl IntoIterator<Item = T>,
    each: impl Fn(T) -> R + Send + Sync,
) -> Vec<R> {
    in_parallel(items, MIN_NUMBERS_OF_THREAD, each)
}

//! Work that the threads of the current Rayon pool share.

use rayon::prelude::*;

/// A thread gets this many numbers at least, if each takes about a nanosecond. Calibrated: to wake a thread and to wait for it
/// takes 10 to 50 µs.
const NUMBERS: usize = 1 << 14;

/// What `each` makes of all items, in their order. An item stands for this many `numbers`. The thread that calls does the work if it is
/// enough for one thread only.
pub(crate) fn in_parallel<T: Send, R: Send>(
    items: impl IntoIterator<Item = T>,
    numbers: usize,
    each: impl Fn(T) -> R + Send + Sync,
) -> Vec<R> {
    let items: Vec<T> = items.into_iter().collect();
    let together = (NUMBERS / numbers.max(1)).max(1);
    if items.len() <= together {
        return items.into_iter().map(each).collect();
    }
    let shared = items.into_par_iter().with_min_len(together);
    shared.map(each).collect()
}

/// The same for items that are worth a thread each, as blocks of states that a map advances.
pub(crate) fn each_in_parallel<T: Send, R: Send>(
    items: impl IntoIterator<Item = T>,
    each: impl Fn(T) -> R + Send + Sync,
) -> Vec<R> {
    in_parallel(items, NUMBERS, each)
}

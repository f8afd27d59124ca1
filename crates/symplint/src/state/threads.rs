//! Work that the threads of the current Rayon pool share.

use std::sync::Mutex;

use rayon::prelude::*;

/// A thread gets at least this many operations, if each takes about a nanosecond. Calibrated: to wake a thread and to wait for it
/// takes 10 to 50 µs.
const MIN_OPERATIONS_OF_THREAD: usize = 1 << 14;

/// Applies `each` to all items and returns the results in their order. One item costs about `operations` operations. The calling thread
/// does all the work if it is too small for a second thread.
pub(crate) fn in_parallel<T: Send, R: Send>(
    items: impl IntoIterator<Item = T>,
    operations: usize,
    each: impl Fn(T) -> R + Sync,
) -> Vec<R> {
    let items: Vec<T> = items.into_iter().collect();
    let together = (MIN_OPERATIONS_OF_THREAD / operations.max(1)).max(1);
    if items.len() <= together {
        return items.into_iter().map(each).collect();
    }
    let slots: Vec<Mutex<(Option<T>, Option<R>)>> = (items.into_iter())
        .map(|item| Mutex::new((Some(item), None)))
        .collect();
    share(slots.len(), together, &|k| {
        let slot = || slots[k].lock().expect("nothing panics under the lock");
        let item = slot().0.take().expect("each item is taken once");
        let result = each(item);
        slot().1 = Some(result);
    });
    let result = |slot: Mutex<(_, Option<R>)>| slot.into_inner().ok()?.1;
    let results = slots.into_iter().map(result);
    results
        .collect::<Option<_>>()
        .expect("every item has a result")
}

/// The same for items that are worth a thread each, such as blocks of states for a map.
pub(crate) fn each_in_parallel<T: Send, R: Send>(
    items: impl IntoIterator<Item = T>,
    each: impl Fn(T) -> R + Sync,
) -> Vec<R> {
    in_parallel(items, MIN_OPERATIONS_OF_THREAD, each)
}

/// Calls `work` with every number below `count`, at least `together` of them on one thread. The function is not generic: each copy of
/// Rayon's scheduler takes as long to compile as a module.
fn share(count: usize, together: usize, work: &(dyn Fn(usize) + Sync)) {
    let shared = (0..count).into_par_iter().with_min_len(together);
    shared.for_each(work);
}

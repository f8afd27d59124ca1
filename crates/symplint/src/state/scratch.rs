//! Working memory for maps, kept for each thread so that advancing a block does
//! not allocate.

use std::cell::RefCell;

use super::buffer::Buffer;
use crate::state::RowsMut;

/// Values of the largest buffer that a thread keeps, 64 MiB: a larger one would stay with every thread that ever had one.
const MAX_KEPT_VALUES: usize = 1 << 23;

thread_local! {
    static IDLE: RefCell<Vec<Buffer>> = const { RefCell::new(Vec::new()) };
}

/// Lends `work` a buffer of `len` values with unspecified contents. Calls may nest.
///
/// The buffer belongs to the calling thread and is used again by later calls, unless it is larger than 64 MiB.
pub fn with_buffer<R>(len: usize, work: impl FnOnce(&mut [f64]) -> R) -> R {
    let mut buffer = lend(len);
    let result = work(&mut buffer[..len]);
    keep(buffer);
    result
}

// Compiled once, not for each `work`.
fn lend(len: usize) -> Buffer {
    let idle = IDLE.with_borrow_mut(Vec::pop);
    (idle.filter(|buffer| buffer.len() >= len)).unwrap_or_else(|| Buffer::zeros(len))
}

fn keep(buffer: Buffer) {
    if buffer.len() <= MAX_KEPT_VALUES {
        IDLE.with_borrow_mut(|idle| idle.push(buffer));
    }
}

/// Lends `work` `tables` tables of `count` rows and `len` columns each, with unspecified
/// contents: room for the stages of a Runge–Kutta step on one block. Calls may nest.
pub fn with_tables<R>(
    tables: usize,
    count: usize,
    len: usize,
    work: impl FnOnce(&mut [RowsMut<'_>]) -> R,
) -> R {
    let size = count * len;
    with_buffer(tables * size, |buffer| {
        work(&mut divide(buffer, tables, count, len))
    })
}

fn divide(buffer: &mut [f64], tables: usize, count: usize, len: usize) -> Vec<RowsMut<'_>> {
    let mut rest = buffer;
    let next = |_| {
        let (table, others) = std::mem::take(&mut rest).split_at_mut(count * len);
        rest = others;
        RowsMut::new(table, count, len, len)
    };
    (0..tables).map(next).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nested_calls_of_any_sizes_use_the_same_memory_again() {
        let lent = |outer: usize, inner: usize| {
            with_buffer(outer, |outer| {
                with_buffer(inner, |inner| [outer, inner].map(|of| of.as_ptr().addr()))
            })
        };
        let sizes = [(10, 1000), (1000, 10), (300, 300)];
        for (outer, inner) in sizes {
            lent(outer, inner);
        }
        let [first, again] = [(); 2].map(|()| sizes.map(|(outer, inner)| lent(outer, inner)));
        assert_eq!(first, again);
    }
}

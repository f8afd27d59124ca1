//! Rows that come next, asked of the memory while the processor is busy with others.

use std::slice::Iter;

use crate::state::prefetch;

/// Values in a cache line.
const LINE: usize = 64 / size_of::<f64>();

/// What has not been asked for yet of the rows of one degree of freedom, by cache lines.
pub(super) struct Ahead<'a>([Iter<'a, [f64; LINE]>; 2]);

impl<'a> Ahead<'a> {
    pub fn new(rows: [&'a [f64]; 2]) -> Self {
        Ahead(rows.map(|row| row.as_chunks().0.iter()))
    }

    /// Nothing comes next.
    pub fn nothing() -> Self {
        Ahead::new([&[]; 2])
    }

    /// Asks for so many more samples of each row, whole cache lines of them.
    #[inline(always)]
    pub fn ask(&mut self, samples: usize) {
        for lines in &mut self.0 {
            for _ in 0..samples / LINE {
                if let Some(line) = lines.next() {
                    prefetch(&line[0]);
                }
            }
        }
    }
}

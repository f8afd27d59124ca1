//! Rows that come next, asked of the memory while the processor is busy with others.

use crate::rows::prefetch;

/// What has not been asked for yet of the rows of one degree of freedom.
pub(super) struct Ahead<'a>([&'a [f64]; 2]);

impl<'a> Ahead<'a> {
    pub fn new(rows: [&'a [f64]; 2]) -> Self {
        Ahead(rows)
    }

    /// Nothing comes next.
    pub fn nothing() -> Self {
        Ahead([&[]; 2])
    }

    /// Asks for so many more samples of each row.
    #[inline(always)]
    pub fn ask(&mut self, samples: usize) {
        /// In a cache line.
        const VALUES: usize = 64 / size_of::<f64>();
        for row in &mut self.0 {
            let (asked, later) = row.split_at(samples.min(row.len()));
            for line in asked.chunks(VALUES) {
                prefetch(&line[0]);
            }
            *row = later;
        }
    }
}

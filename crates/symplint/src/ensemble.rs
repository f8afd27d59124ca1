//! All samples at one time.

use crate::block::Block;
use crate::rows::{Rows, RowsMut};

/// The states of all samples, one contiguous row of N_s values for each coordinate.
///
/// Positions and momenta are apart. Rows start a little further apart than they are
/// long where their length is a multiple of a large power of two: rows at such
/// distances compete for the same cache sets.
#[derive(Clone, Debug)]
pub struct Ensemble {
    dof: usize,
    samples: usize,
    stride: usize,
    q: Vec<f64>,
    p: Vec<f64>,
}

/// Distance between rows of `samples` values that does not alias in the caches.
fn row_stride(samples: usize) -> usize {
    /// Values in a cache line.
    const LINE: usize = 8;
    /// Values in a page.
    const PAGE: usize = 512;
    if samples.is_multiple_of(PAGE) {
        samples + LINE
    } else {
        samples
    }
}

impl Ensemble {
    /// An ensemble of `samples` states at the origin.
    pub fn zeros(dof: usize, samples: usize) -> Self {
        let stride = row_stride(samples);
        Ensemble {
            dof,
            samples,
            stride,
            q: vec![0.0; dof * stride],
            p: vec![0.0; dof * stride],
        }
    }

    /// Degrees of freedom d.
    pub fn dof(&self) -> usize {
        self.dof
    }

    /// Samples N_s.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Positions: d rows of N_s values.
    pub fn q(&self) -> Rows<'_> {
        Rows::new(&self.q, self.dof, self.stride, self.samples)
    }

    /// Momenta: d rows of N_s values.
    pub fn p(&self) -> Rows<'_> {
        Rows::new(&self.p, self.dof, self.stride, self.samples)
    }

    /// The whole ensemble as one block.
    pub fn block(&mut self) -> Block<'_> {
        Block::new(
            RowsMut::new(&mut self.q, self.dof, self.stride, self.samples),
            RowsMut::new(&mut self.p, self.dof, self.stride, self.samples),
        )
    }

    /// The ensemble cut into blocks of samples that fit into a core's cache.
    ///
    /// The cut depends on the shape alone, never on the number of threads.
    pub fn blocks(&mut self) -> Vec<Block<'_>> {
        let width = Self::block_width(self.dof);
        let whole = self.block();
        let (q, p) = (whole.q.column_blocks(width), whole.p.column_blocks(width));
        q.zip(p).map(|(q, p)| Block::new(q, p)).collect()
    }

    /// Samples in a block: states of one block take about a quarter of a mebibyte, and a row of
    /// it never less than two cache lines.
    pub fn block_width(dof: usize) -> usize {
        const BLOCK_VALUES: usize = 32 * 1024;
        (BLOCK_VALUES / (2 * dof.max(1)) / 8 * 8).clamp(16, 1024)
    }
}

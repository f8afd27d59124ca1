//! The samples in memory: a few that the stencils still need, and those just made.

use crate::breaks::GROUP;
use crate::error::Error;
use crate::loops::Loop;
use crate::loops::sample_block;
use crate::map::Evaluator;
use crate::signal::LANES;
use crate::state::Block;
use crate::state::RowsMut;
use crate::state::{Ensemble, each_in_parallel, first_error};

/// Memory of the new samples of a window, unless one group needs more.
const MAX_BYTES: usize = 16 << 20;

/// New samples of a window at most.
const MAX_NEW_SAMPLES: usize = 4096;

/// New samples are made in this many blocks, by as many threads, if the blocks are not too narrow.
const BLOCKS: usize = 16;

/// Where samples come from: the loop itself, or what a step makes of it.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub phase_loop: &'a dyn Loop,
    /// Samples of the loop.
    pub samples: usize,
    /// The map and the step size.
    pub step: Option<(&'a Evaluator<'a>, f64)>,
}

/// Consecutive samples: `history` of them, then the new ones.
pub(super) struct Window {
    dof: usize,
    history: usize,
    new: usize,
    q: Vec<f64>,
    p: Vec<f64>,
}

impl Window {
    /// A window that keeps `history` samples. It holds whole groups of new ones, so that no sum depends on it.
    ///
    /// # Errors
    /// If no memory holds it.
    pub fn new(dof: usize, history: usize) -> Result<Self, Error> {
        let of_bytes = MAX_BYTES / (16 * dof.max(1));
        let new = (of_bytes / GROUP * GROUP).clamp(GROUP, MAX_NEW_SAMPLES);
        Ensemble::check_size(dof, history + new)?;
        Ok(Window {
            dof,
            history,
            new,
            q: vec![0.0; dof * (history + new)],
            p: vec![0.0; dof * (history + new)],
        })
    }

    /// New samples that fit.
    pub fn capacity(&self) -> usize {
        self.new
    }

    /// Makes samples `first`, `first` + 1, … of the loop the first `count` of the history.
    pub fn begin(&mut self, source: &Source<'_>, first: usize, count: usize) -> Result<(), Error> {
        self.make(source, 0, first, count)
    }

    /// Makes samples `first`, `first` + 1, … of the loop the first `count` of the new ones.
    pub fn fill(&mut self, source: &Source<'_>, first: usize, count: usize) -> Result<(), Error> {
        self.make(source, self.history, first, count)
    }

    fn make(
        &mut self,
        source: &Source<'_>,
        column: usize,
        first: usize,
        count: usize,
    ) -> Result<(), Error> {
        let stride = self.history + self.new;
        let width = (self.new / BLOCKS).clamp(LANES, Ensemble::block_width(self.dof));
        // Without degrees of freedom the memory is empty.
        let column = column.min(self.q.len());
        let q = RowsMut::new(&mut self.q[column..], self.dof, stride, count);
        let p = RowsMut::new(&mut self.p[column..], self.dof, stride, count);
        let blocks: Vec<Block<'_>> = (q.column_blocks(width))
            .zip(p.column_blocks(width))
            .map(|(q, p)| Block::new(q, p))
            .collect();
        let fill = |first: usize, block: &mut Block<'_>| {
            let at = |k: usize| k as f64 / source.samples as f64;
            sample_block(source.phase_loop, at, first, block)
        };
        match source.step {
            Some((evaluator, h)) => evaluator.advance_blocks(blocks, width, first, h, fill),
            None => {
                let each = |(b, mut block): (usize, Block<'_>)| fill(first + b * width, &mut block);
                first_error(each_in_parallel(blocks.into_iter().enumerate(), each))
            }
        }
    }

    /// Shows each degree of freedom, with what is kept for it, its history and `count` new samples of q and p; they
    /// become the end of its history. Returns the largest of what `visit` does, or 0.
    pub fn consume<T: Send>(
        &mut self,
        count: usize,
        kept: &mut [T],
        visit: impl Fn(usize, &mut T, &mut [f64], &mut [f64]) -> f64 + Sync,
    ) -> f64 {
        /// Rows to a task.
        const ROWS_PER_TASK: usize = 64;
        let (history, stride) = (self.history, self.history + self.new);
        let q = self.q.chunks_mut(ROWS_PER_TASK * stride);
        let p = self.p.chunks_mut(ROWS_PER_TASK * stride);
        let tasks = q.zip(p).zip(kept.chunks_mut(ROWS_PER_TASK)).enumerate();
        let largest = each_in_parallel(tasks, |(task, ((q, p), kept))| {
            let mut largest = 0.0f64;
            let rows = (q.chunks_exact_mut(stride)).zip(p.chunks_exact_mut(stride));
            for (i, ((q, p), kept)) in rows.zip(kept).enumerate() {
                let (q, p) = (&mut q[..history + count], &mut p[..history + count]);
                largest = largest.max(visit(task * ROWS_PER_TASK + i, kept, q, p));
                q.copy_within(count.., 0);
                p.copy_within(count.., 0);
            }
            largest
        });
        largest.into_iter().fold(0.0, f64::max)
    }

    /// The history of q and p of a degree of freedom.
    pub fn history(&self, dof: usize) -> (&[f64], &[f64]) {
        let start = dof * (self.history + self.new);
        let columns = start..start + self.history;
        (&self.q[columns.clone()], &self.p[columns])
    }
}

//! A block of samples: what a time-advance map works on.

use std::ops::Range;

use crate::state::{Ensemble, RowsMut, scratch};

/// Positions and momenta of a run of samples, to be advanced in place.
///
/// `q` and `p` have one row for each degree of freedom and one column for each
/// sample of the block: `block.q.row(i)[k]` is q_i of sample k.
pub struct Block<'a> {
    /// Positions, d rows.
    pub q: RowsMut<'a>,
    /// Momenta, d rows.
    pub p: RowsMut<'a>,
}

impl<'a> Block<'a> {
    /// Joins positions and momenta.
    ///
    /// # Panics
    /// If their shapes differ.
    pub fn new(q: RowsMut<'a>, p: RowsMut<'a>) -> Self {
        assert_eq!(
            (q.count(), q.len()),
            (p.count(), p.len()),
            "q and p of one block have the same shape"
        );
        Block { q, p }
    }

    /// Degrees of freedom.
    pub fn dof(&self) -> usize {
        self.q.count()
    }

    /// Samples in the block.
    pub fn len(&self) -> usize {
        self.q.len()
    }

    /// Whether the block holds no sample.
    pub fn is_empty(&self) -> bool {
        self.q.is_empty()
    }

    /// Whether no position and no momentum is infinite or NaN.
    pub fn all_finite(&self) -> bool {
        self.q.as_rows().all_finite() && self.p.as_rows().all_finite()
    }

    /// A copy of some samples.
    ///
    /// # Panics
    /// If the block has fewer.
    pub fn copy_of(&self, samples: Range<usize>) -> Ensemble {
        let mut states = Ensemble::zeros(self.dof(), samples.len());
        let mut copy = states.block();
        for i in 0..self.dof() {
            (copy.q.row_mut(i)).copy_from_slice(&self.q.row(i)[samples.clone()]);
            (copy.p.row_mut(i)).copy_from_slice(&self.p.row(i)[samples.clone()]);
        }
        states
    }

    /// Does `work`, which writes all states, on a block of the same shape, and copies what it leaves there into this one unless it fails.
    ///
    /// If the rows of this block are many and pages apart, those of the other one lie next to each other: a processor keeps the
    /// addresses of some thousand pages, and finds each of the others in a table of the system.
    pub(crate) fn gathered<E>(
        &mut self,
        work: impl FnOnce(&mut Block<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        /// Rows of q, and of p, that may be pages apart.
        const MAX_SCATTERED_ROWS: usize = 512;
        /// Values of a copy at most, 8 MiB: memory that each thread keeps.
        const MAX_VALUES: usize = 1 << 20;
        let (dof, samples) = (self.dof(), self.len());
        let is_scattered = self.q.is_scattered() && dof > MAX_SCATTERED_ROWS;
        if !is_scattered || 2 * dof * samples > MAX_VALUES {
            return work(self);
        }
        scratch::with_tables(2, dof, samples, |tables| {
            let [q, p] = tables else {
                unreachable!("two tables are two");
            };
            work(&mut Block::new(q.reborrow(), p.reborrow()))?;
            self.q.copy_from(q.as_rows());
            self.p.copy_from(p.as_rows());
            Ok(())
        })
    }

    /// The same block for a shorter time, so that it can be passed on and used again.
    pub fn reborrow(&mut self) -> Block<'_> {
        Block {
            q: self.q.reborrow(),
            p: self.p.reborrow(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scattered_rows_are_gathered_and_written_back() {
        const SAMPLES: usize = 1024;
        const WIDTH: usize = 500;
        // As many rows as are left where they are, and more.
        for (dof, is_gathered) in [(512, false), (513, true)] {
            let mut states = Ensemble::zeros(dof, SAMPLES);
            // The last block has 24 samples. Both ends of its rows are written: Miri runs this test, too, and takes a second for
            // some hundred thousand writes.
            let mut blocks = states.blocks_of(WIDTH);
            let last = blocks.last_mut().expect("there are three blocks");
            let written = last.gathered(|block| {
                assert_eq!(block.q.as_mut_slice().is_some(), is_gathered);
                let end = block.len() - 1;
                for i in 0..dof {
                    for k in [0, end] {
                        block.q.row_mut(i)[k] = (i + k) as f64;
                        block.p.row_mut(i)[k] = -((i + k) as f64);
                    }
                }
                Ok::<(), ()>(())
            });
            assert!(written.is_ok());
            for i in 0..dof {
                for (k, in_block) in [(1000, 0), (SAMPLES - 1, 23)] {
                    assert_eq!(states.q().row(i)[k], (i + in_block) as f64);
                    assert_eq!(states.p().row(i)[k], -((i + in_block) as f64));
                }
                assert_eq!(states.q().row(i)[999], 0.0);
            }
        }
    }

    #[test]
    fn errors_are_returned_and_rows_near_each_other_stay_where_they_are() {
        let mut states = Ensemble::zeros(600, 1024);
        let mut blocks = states.blocks_of(32);
        assert_eq!(blocks[0].gathered(|_| Err("no")), Err("no"));
        // Rows nearer than a page.
        let mut states = Ensemble::zeros(600, 64);
        let mut blocks = states.blocks_of(32);
        let in_place = blocks[1].gathered(|block| match block.q.as_mut_slice() {
            None => Ok(()),
            Some(_) => Err(()),
        });
        assert_eq!(in_place, Ok(()));
    }
}

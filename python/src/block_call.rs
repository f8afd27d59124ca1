//! One call of a function of the user for the states of a block, or one for each of them.

use std::ops::Range;

use numpy::ndarray::{Ix1, Ix2};
use pyo3::prelude::*;
use symplint::Block;
use symplint::state::RowsMut;
use symplint_run::JournalError;

use crate::arrays::{copy, pair, read_column, read_rows};
use crate::calls::ends_programs;
use crate::error::other_error;
use crate::memory::{Memory, Number};

/// Rows that a function may get at once, the largest first. There are few, as JAX and other compilers compile a function for each
/// size; loops of more than 2048 samples, which take the two largest, are rare. Conventional: powers of four.
const SIZES: [usize; 8] = [16384, 4096, 1024, 256, 64, 16, 4, 1];

/// Coordinates that a function gets at once, at most: with the results and some temporary arrays, positions and momenta
/// of a batch fit into the cache of a core.
const MAX_COORDINATES: usize = 1 << 15;

/// The remedy for a function that did something else.
const OR_IN_PLACE: &str = "return q and p, or change both in place and return None";

/// An exception, and the sample of the block that caused it; 0 where that is not known.
pub struct Failed {
    pub sample: usize,
    pub error: PyErr,
}

impl From<JournalError> for Failed {
    /// That of states that cannot be noted.
    fn from(error: JournalError) -> Self {
        Failed {
            sample: 0,
            error: Python::attach(|py| other_error(py, &error.to_string())),
        }
    }
}

/// A function that is called for the states of a block.
pub struct BlockCall<'py> {
    pub function: Bound<'py, PyAny>,
    /// Its third argument, if it has one.
    pub h: Option<f64>,
    /// Called before every call of the function, if there is one.
    pub reset: Option<Bound<'py, PyAny>>,
    /// Its name in messages.
    pub what: &'static str,
}

impl<'py> BlockCall<'py> {
    /// Calls the function for all states, one by one or a batch at a time, of numbers in single precision or not, and says
    /// whether all are finite then.
    ///
    /// # Errors
    /// The exception that it raised, or why its result is refused.
    pub fn advance(
        &self,
        per_sample: bool,
        single: bool,
        kept: &mut Option<Py<Memory>>,
        block: &mut Block<'_>,
    ) -> Result<bool, Failed> {
        match (per_sample, single) {
            (false, false) => self.all::<f64>(kept, block),
            (false, true) => self.all::<f32>(kept, block),
            (true, false) => self.each::<f64>(kept, block),
            (true, true) => self.each::<f32>(kept, block),
        }
    }

    /// Calls the function for all states, a batch at a time, and says whether all are finite then.
    ///
    /// # Errors
    /// The exception that it raised, or why its result is refused.
    fn all<T: Number>(
        &self,
        kept: &mut Option<Py<Memory>>,
        block: &mut Block<'_>,
    ) -> Result<bool, Failed> {
        for_each_batch(block, &mut |batch| self.batch::<T>(kept, batch))
    }

    /// Calls the function for all states at once, and says whether all are finite then.
    fn batch<T: Number>(
        &self,
        kept: &mut Option<Py<Memory>>,
        block: &mut Block<'_>,
    ) -> Result<bool, Failed> {
        let batch = Batch::<T>::lend(self.function.py(), kept, block, 0..block.len());
        let called = batch.call(self);
        let result = match called {
            Ok(result) => result,
            Err(error) => {
                batch.end(kept);
                if ends_programs(self.function.py(), &error) {
                    return Err(Failed { sample: 0, error });
                }
                let found = self.first_failure::<T>(kept, block);
                let sample = found.map_err(|error| Failed { sample: 0, error })?;
                return Err(Failed { sample, error });
            }
        };
        let taken = match result.is_none() {
            true => Ok(batch.copy_to(block)),
            false => self.take(result, block, batch.rows),
        };
        batch.end(kept);
        taken.map_err(|error| Failed { sample: 0, error })
    }

    fn take(
        &self,
        result: Bound<'py, PyAny>,
        block: &mut Block<'_>,
        rows: usize,
    ) -> PyResult<bool> {
        let (q, p) = pair(result, self.what, OR_IN_PLACE)?;
        Ok(read_rows(&q, "q", &mut block.q, rows)? & read_rows(&p, "p", &mut block.p, rows)?)
    }

    /// The first state that makes the function fail by itself, by bisection; 0 where none does.
    ///
    /// # Errors
    /// An exception that ends programs.
    fn first_failure<T: Number>(
        &self,
        kept: &mut Option<Py<Memory>>,
        block: &mut Block<'_>,
    ) -> PyResult<usize> {
        let mut fails = |range: Range<usize>| {
            let batch = Batch::<T>::lend(self.function.py(), kept, block, range);
            let called = batch.call(self).map(|_| ());
            batch.end(kept);
            match called {
                Err(error) if ends_programs(self.function.py(), &error) => Err(error),
                called => Ok(called.is_err()),
            }
        };
        let samples = block.len();
        // A fault of the function itself shows in any state.
        if samples == 1 || fails(0..1)? {
            return Ok(0);
        }
        let (mut low, mut high) = (1, samples);
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if fails(low..middle)? {
                high = middle;
            } else {
                low = middle;
            }
        }
        Ok(if fails(low..high)? { low } else { 0 })
    }

    /// Calls the function for one state after the other, and says whether all are finite then.
    ///
    /// # Errors
    /// The exception that it raised, or why its result is refused.
    fn each<T: Number>(
        &self,
        kept: &mut Option<Py<Memory>>,
        block: &mut Block<'_>,
    ) -> Result<bool, Failed> {
        let py = self.function.py();
        let (samples, dof) = (block.len(), block.dof());
        let memory = take_memory::<T>(py, kept, 2 * samples * dof);
        let of_p = samples * dof;
        for (first, rows) in [(0, &block.q), (of_p, &block.p)] {
            Memory::with(&memory, first, samples * dof, |states: &mut [T]| {
                for i in 0..dof {
                    for (state, value) in states.chunks_exact_mut(dof).zip(rows.row(i)) {
                        state[i] = T::of(*value);
                    }
                }
            });
        }
        let advanced = (0..samples).try_for_each(|sample| {
            let state = |of: usize| {
                Memory::array::<T, Ix1>(&memory, of + sample * dof, Ix1(dof), Ix1(1)).into_any()
            };
            let result = self.call(&state(0), &state(of_p));
            let taken = result.and_then(|result| match result.is_none() {
                true => {
                    for (of, rows) in [(0, &mut block.q), (of_p, &mut block.p)] {
                        Memory::with(&memory, of + sample * dof, dof, |state: &mut [T]| {
                            for (i, value) in state.iter().enumerate() {
                                rows.row_mut(i)[sample] = value.value();
                            }
                        });
                    }
                    Ok(())
                }
                false => {
                    let (q, p) = pair(result, self.what, OR_IN_PLACE)?;
                    read_column(&q, "q", &mut block.q, sample)?;
                    read_column(&p, "p", &mut block.p, sample)
                }
            });
            taken.map_err(|error| Failed { sample, error })
        });
        keep_memory(memory, kept);
        advanced.map(|()| block.all_finite())
    }

    fn call(&self, q: &Bound<'py, PyAny>, p: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        if let Some(reset) = &self.reset {
            reset.call0()?;
        }
        match self.h {
            Some(h) => self.function.call1((q, p, h)),
            None => self.function.call1((q, p)),
        }
    }
}

/// Calls `advance` for each batch of a block, and returns whether all states are finite then.
///
/// # Errors
/// The first one of `advance`, with the sample of the block.
pub fn for_each_batch(
    block: &mut Block<'_>,
    advance: &mut impl FnMut(&mut Block<'_>) -> Result<bool, Failed>,
) -> Result<bool, Failed> {
    if block.is_empty() {
        return Ok(true);
    }
    let width = width(block.len(), block.dof());
    if block.len() <= width {
        return advance(block);
    }
    let Block { q, p } = block.reborrow();
    let parts = q.column_blocks(width).zip(p.column_blocks(width));
    let mut finite = true;
    for (k, (q, p)) in parts.enumerate() {
        let advanced = for_each_batch(&mut Block::new(q, p), advance);
        finite &= advanced.map_err(|failed| Failed {
            sample: k * width + failed.sample,
            ..failed
        })?;
    }
    Ok(finite)
}

/// The size of the first batch of `states` states: the one of which they fill more than half, else the largest that they fill.
fn width(states: usize, dof: usize) -> usize {
    let rows = padded(states, dof);
    match rows < 2 * states {
        true => rows,
        false => sizes(dof).find(|&rows| rows <= states).unwrap_or(1),
    }
}

/// The rows that a function gets for a batch of `states` states.
fn padded(states: usize, dof: usize) -> usize {
    let enough = sizes(dof).filter(|&rows| rows >= states);
    // More states than any size has: several batches.
    enough.min().unwrap_or(usize::MAX)
}

/// The sizes of batches in `dof` degrees of freedom, the largest first.
fn sizes(dof: usize) -> impl Iterator<Item = usize> {
    let most = (MAX_COORDINATES / dof.max(1)).max(1);
    SIZES.into_iter().filter(move |&rows| rows <= most)
}

/// Numbers of a cache line.
const LINE: usize = 8;

/// States on loan to a function: for each degree of freedom one number per state, of which the function sees the transpose, in
/// Fortran order. Nothing lies between two degrees of freedom: numpy takes such an array for one long row. The last state is
/// repeated until the function has enough rows, and the results of its copies are dropped.
struct Batch<'py, T> {
    memory: Bound<'py, Memory>,
    dof: usize,
    samples: usize,
    /// Rows that the function sees.
    rows: usize,
    number: std::marker::PhantomData<T>,
}

/// The start of the momenta of `count` positions.
fn of_momenta(count: usize) -> usize {
    // Half a page, so that a position and its momentum do not compete for the same cache lines.
    const APART: usize = 256;
    count.next_multiple_of(LINE) + APART
}

impl<'py, T: Number> Batch<'py, T> {
    /// Copies some states of a block.
    fn lend(
        py: Python<'py>,
        kept: &mut Option<Py<Memory>>,
        block: &Block<'_>,
        range: Range<usize>,
    ) -> Self {
        let (dof, samples) = (block.dof(), range.len());
        let rows = padded(samples, dof);
        let second = of_momenta(dof * rows);
        let memory = take_memory::<T>(py, kept, second + dof * rows);
        for (first, from) in [(0, &block.q), (second, &block.p)] {
            Memory::with(&memory, first, dof * rows, |lent: &mut [T]| {
                for (i, to) in lent.chunks_exact_mut(rows).enumerate() {
                    let (states, copies) = to.split_at_mut(samples);
                    for (to, from) in states.iter_mut().zip(&from.row(i)[range.clone()]) {
                        *to = T::of(*from);
                    }
                    copies.fill(states[samples - 1]);
                }
            });
        }
        Batch {
            memory,
            dof,
            samples,
            rows,
            number: std::marker::PhantomData,
        }
    }

    fn call(&self, call: &BlockCall<'py>) -> PyResult<Bound<'py, PyAny>> {
        let shape = Ix2(self.rows, self.dof);
        let strides = Ix2(1, self.rows);
        let of = |first| Memory::array::<T, Ix2>(&self.memory, first, shape, strides).into_any();
        call.call(&of(0), &of(of_momenta(self.dof * self.rows)))
    }

    /// Copies the states, changed in place, into the block of as many samples, and says whether all are finite.
    fn copy_to(&self, block: &mut Block<'_>) -> bool {
        let count = self.dof * self.rows;
        let take = |first: usize, rows: &mut RowsMut<'_>| {
            Memory::with(&self.memory, first, count, |lent: &mut [T]| {
                let of_rows = lent.chunks_exact(self.rows).enumerate();
                of_rows.fold(true, |finite, (i, row)| {
                    finite & copy(rows.row_mut(i), &row[..self.samples])
                })
            })
        };
        take(0, &mut block.q) & take(of_momenta(count), &mut block.p)
    }

    fn end(self, kept: &mut Option<Py<Memory>>) {
        keep_memory(self.memory, kept);
    }
}

/// Memory for this number of numbers, used again if no array of the user refers to it.
fn take_memory<'py, T: Number>(
    py: Python<'py>,
    kept: &mut Option<Py<Memory>>,
    count: usize,
) -> Bound<'py, Memory> {
    let words = (count * size_of::<T>()).div_ceil(8);
    let kept = kept.take().map(|memory| memory.into_bound(py));
    match kept.filter(|memory| memory.get().words() >= words && Memory::is_unused(memory)) {
        Some(memory) => memory,
        None => Bound::new(py, Memory::zeros(words)).expect("memory for an object"),
    }
}

/// Keeps memory for later, the larger one of two.
fn keep_memory(memory: Bound<'_, Memory>, kept: &mut Option<Py<Memory>>) {
    if kept
        .as_ref()
        .is_none_or(|kept| kept.get().words() < memory.get().words())
    {
        *kept = Some(memory.unbind());
    }
}

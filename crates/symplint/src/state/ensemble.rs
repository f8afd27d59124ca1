//! All samples at one time.

use std::borrow::Cow;

use super::buffer::Buffer;
use super::in_parallel;
use super::rows::{CACHE_LINE, VALUES_OF_PAGE};
use crate::error::{Error, LOOK_AT_MAP, StateLocation};
use crate::signal::unwrap_row;
use crate::state::{Block, Coordinates};
use crate::state::{Rows, RowsMut};

/// Memory of the ensembles besides the measured one: a small part of the memory of a machine.
pub(crate) const SMALL_MEMORY: usize = 64 << 20;

/// The states of all samples, one contiguous row of N_s values for each coordinate.
///
/// Positions and momenta are apart. Rows start a little further apart than they are
/// long where their length is a multiple of a large power of two: rows at such
/// distances compete for the same cache sets.
#[derive(Clone, Debug, PartialEq)]
pub struct Ensemble {
    dof: usize,
    samples: usize,
    stride: usize,
    q: Buffer,
    p: Buffer,
}

/// Distance between rows of `samples` values that does not alias in the caches.
fn row_stride(samples: usize) -> usize {
    if samples.is_multiple_of(VALUES_OF_PAGE) {
        samples + CACHE_LINE
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
            q: Buffer::zeros(dof * stride),
            p: Buffer::zeros(dof * stride),
        }
    }

    /// A copy of rows.
    ///
    /// # Panics
    /// If q and p differ in shape.
    pub(crate) fn of_rows(q: Rows<'_>, p: Rows<'_>) -> Self {
        let mut ensemble = Ensemble::zeros(q.count(), q.len());
        let mut block = ensemble.block();
        for i in 0..q.count() {
            block.q.row_mut(i).copy_from_slice(q.row(i));
            block.p.row_mut(i).copy_from_slice(p.row(i));
        }
        ensemble
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
        self.blocks_of(Self::block_width(self.dof))
    }

    /// The ensemble cut into blocks of `width` samples.
    pub(crate) fn blocks_of(&mut self, width: usize) -> Vec<Block<'_>> {
        let whole = self.block();
        let (q, p) = (whole.q.column_blocks(width), whole.p.column_blocks(width));
        q.zip(p).map(|(q, p)| Block::new(q, p)).collect()
    }

    /// Samples in a block: states of one block take about a quarter of a mebibyte, and a row of
    /// it four cache lines at least, as shorter runs of memory are slow to fetch. In very many
    /// degrees of freedom it is two, as the working memory of a method counts there.
    pub fn block_width(dof: usize) -> usize {
        const BLOCK_VALUES: usize = 32 * 1024;
        const MANY_DOF: usize = 16 * 1024;
        if dof > MANY_DOF {
            return 16;
        }
        // Of multiples of 32 vector loops leave no rest on any processor.
        (BLOCK_VALUES / (2 * dof.max(1)) / 32 * 32).clamp(32, 1024)
    }

    /// Samples 0, k, 2k, … of this ensemble, with the smallest k that leaves `most` of them or fewer.
    pub(crate) fn thinned(&self, most: usize) -> Ensemble {
        let every = self.samples.div_ceil(most);
        let mut thinned = Ensemble::zeros(self.dof, self.samples.div_ceil(every));
        let block = thinned.block();
        let pick = |rows: Rows<'_>, mut to: RowsMut<'_>| {
            for i in 0..self.dof {
                let picked = rows.row(i).iter().step_by(every);
                (to.row_mut(i).iter_mut().zip(picked)).for_each(|(to, value)| *to = *value);
            }
        };
        pick(self.q(), block.q);
        pick(self.p(), block.p);
        thinned
    }

    /// Puts sample k of `between` after sample k of this ensemble, for every k: twice the samples,
    /// and none of them made again.
    pub(crate) fn interleave(&mut self, between: &Ensemble) {
        assert_eq!(
            (self.dof, self.samples),
            (between.dof, between.samples),
            "ensembles of one shape"
        );
        let (samples, old) = (self.samples, self.stride);
        let stride = row_stride(2 * samples);
        let pairs = [(&mut self.q, between.q()), (&mut self.p, between.p())];
        for (values, between) in pairs {
            // Into new memory, row by row, on all threads.
            let mut all = Buffer::zeros(self.dof * stride);
            let rows = all.chunks_mut(stride).zip(values.chunks(old)).enumerate();
            in_parallel(rows, stride, |(i, (row, first))| {
                let pairs = first[..samples].iter().zip(between.row(i));
                for (to, (&first, &second)) in row.as_chunks_mut().0.iter_mut().zip(pairs) {
                    *to = [first, second];
                }
            });
            *values = all;
        }
        (self.samples, self.stride) = (2 * samples, stride);
    }

    /// The samples of a loop with periodic momenta unwrapped, and the degrees of freedom in which they gain whole periods
    /// round the loop or the positions do: there ∮ p·dq has no value.
    pub(crate) fn unwrap_momenta(&self, coordinates: &Coordinates) -> (Cow<'_, Self>, Vec<usize>) {
        if !coordinates.has_momentum_periods() {
            return (Cow::Borrowed(self), Vec::new());
        }
        let mut unwrapped = self.clone();
        let mut winding = Vec::new();
        for i in 0..self.dof {
            let period = coordinates.momentum_period(i);
            if period > 0.0 {
                let of_q = unwrap_row(&mut self.q().row(i).to_vec(), coordinates.period(i));
                let of_p = unwrap_row(unwrapped.block().p.row_mut(i), period);
                if of_q != 0 || of_p != 0 {
                    winding.push(i);
                }
            }
        }
        (Cow::Owned(unwrapped), winding)
    }

    /// Refuses what no machine holds, before the allocation fails.
    pub(crate) fn check_size(dof: usize, samples: usize) -> Result<(), Error> {
        let values = row_stride(samples).checked_mul(2);
        let fits = (values.and_then(|of_each| of_each.checked_mul(dof))).is_some_and(|values| {
            let mut reserved: Vec<f64> = Vec::new();
            let result = reserved.try_reserve_exact(values);
            // Or the compiler leaves out what is given back at once.
            std::hint::black_box(reserved);
            result.is_ok()
        });
        if !fits {
            return Err(Error::TooLarge {
                dof,
                samples,
                bytes: 16.0 * dof as f64 * samples as f64,
            });
        }
        Ok(())
    }

    /// Checks that every state is finite.
    ///
    /// `step_size` is that of the step that made the states, if one did.
    ///
    /// # Errors
    /// Names the first sample that is not, the coordinate and its value.
    pub fn check_finite(&self, step_size: Option<f64>) -> Result<(), Error> {
        match first_not_finite(self.q(), self.p()) {
            None => Ok(()),
            Some(found) => Err(found.into_error(0, step_size)),
        }
    }
}

/// Copies into a block the samples of an ensemble from `first` on.
pub(crate) fn copy_samples(ensemble: &Ensemble, first: usize, block: &mut Block<'_>) {
    let samples = first..first + block.len();
    for i in 0..block.dof() {
        (block.q.row_mut(i)).copy_from_slice(&ensemble.q().row(i)[samples.clone()]);
        (block.p.row_mut(i)).copy_from_slice(&ensemble.p().row(i)[samples.clone()]);
    }
}

/// The first error in the order of the blocks, so that it does not depend on the threads.
pub(crate) fn first_error(results: Vec<Result<(), Error>>) -> Result<(), Error> {
    results.into_iter().collect()
}

/// A state of a block that is not finite.
pub(crate) struct NonFiniteValue {
    coordinate: &'static str,
    dof: usize,
    sample: usize,
    value: f64,
}

impl NonFiniteValue {
    /// `step_size` is that of the step that made the state, if one did.
    pub fn into_error(self, first_sample: usize, step_size: Option<f64>) -> Error {
        let remedy = match step_size {
            None => "give finite states",
            Some(_) => "look at the map there, or take smaller step sizes or a smaller loop",
        };
        self.with(first_sample, step_size, remedy)
    }

    /// The error of a state that a map without a step size made.
    pub fn of_map(self, first_sample: usize) -> Error {
        self.with(first_sample, None, LOOK_AT_MAP)
    }

    fn with(self, first_sample: usize, step_size: Option<f64>, remedy: &'static str) -> Error {
        Error::NotFinite {
            coordinate: self.coordinate,
            dof: self.dof,
            at: StateLocation::Sample(first_sample + self.sample),
            step_size,
            value: self.value,
            remedy,
        }
    }
}

pub(crate) fn first_not_finite(q: Rows<'_>, p: Rows<'_>) -> Option<NonFiniteValue> {
    if q.all_finite() && p.all_finite() {
        return None;
    }
    let mut first: Option<NonFiniteValue> = None;
    for (coordinate, rows) in [("q", q), ("p", p)] {
        for dof in 0..rows.count() {
            let row = rows.row(dof);
            let Some(sample) = row.iter().position(|v| !v.is_finite()) else {
                continue;
            };
            if first.as_ref().is_none_or(|found| sample < found.sample) {
                first = Some(NonFiniteValue {
                    coordinate,
                    dof,
                    sample,
                    value: row[sample],
                });
            }
        }
    }
    first
}

/// Coordinate c of a sample: positions first, then momenta.
pub(crate) fn coordinate(states: &Ensemble, c: usize) -> &[f64] {
    let dof = states.dof();
    if c < dof {
        states.q().row(c)
    } else {
        states.p().row(c - dof)
    }
}

/// Coordinate c of the samples of a block: positions first, then momenta.
pub(crate) fn coordinate_mut<'b>(block: &'b mut Block<'_>, c: usize) -> &'b mut [f64] {
    let dof = block.dof();
    if c < dof {
        block.q.row_mut(c)
    } else {
        block.p.row_mut(c - dof)
    }
}

/// Period of a coordinate: positions first, then momenta.
pub(crate) fn period(coordinates: &Coordinates, c: usize) -> f64 {
    let dof = coordinates.dof();
    if c < dof {
        coordinates.period(c)
    } else {
        coordinates.momentum_period(c - dof)
    }
}

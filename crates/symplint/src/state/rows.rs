//! Views of a strided table of coordinates: one row for each degree of freedom.
//!
//! An [`Ensemble`](crate::Ensemble) keeps one long contiguous row of samples for
//! each degree of freedom; a block of it is a set of equally long pieces of those
//! rows. [`Rows`] and [`RowsMut`] are that set. They need `unsafe`: safe Rust cannot hand
//! out disjoint column ranges of one table.

use std::marker::PhantomData;

use multiversion::multiversion;

/// Values of a cache line.
pub(crate) const CACHE_LINE: usize = 8;

/// Values of a page of memory.
pub(super) const VALUES_OF_PAGE: usize = 512;

/// Read-only rows: `count` rows of `len` values, equally spaced in memory.
#[derive(Clone, Copy)]
pub struct Rows<'a> {
    start: *const f64,
    stride: usize,
    count: usize,
    len: usize,
    life: PhantomData<&'a [f64]>,
}

/// Rows that can be written: `count` rows of `len` values, equally spaced in memory.
pub struct RowsMut<'a> {
    start: *mut f64,
    stride: usize,
    count: usize,
    len: usize,
    life: PhantomData<&'a mut [f64]>,
}

// SAFETY: a `Rows` is a set of shared slices of `f64`, a `RowsMut` a set of
// disjoint exclusive ones; both may go wherever those slices may.
unsafe impl Send for Rows<'_> {}
// SAFETY: as above.
unsafe impl Sync for Rows<'_> {}
// SAFETY: as above.
unsafe impl Send for RowsMut<'_> {}
// SAFETY: as above; a shared `RowsMut` only gives shared slices.
unsafe impl Sync for RowsMut<'_> {}

/// Checks that `count` rows of `len` values, `stride` apart, fit into `available` values.
fn assert_fits(available: usize, count: usize, stride: usize, len: usize) {
    let needed = match count {
        0 => Some(0),
        n => (n - 1)
            .checked_mul(stride)
            .and_then(|start| start.checked_add(len)),
    };
    assert!(
        len <= stride && needed.is_some_and(|needed| needed <= available),
        "{count} rows of {len} values, {stride} apart, do not fit into {available} values"
    );
}

impl<'a> Rows<'a> {
    /// The first `len` values of `count` rows that lie `stride` values apart in `data`.
    ///
    /// # Panics
    /// If `data` is too short or `len` exceeds `stride`.
    pub fn new(data: &'a [f64], count: usize, stride: usize, len: usize) -> Self {
        assert_fits(data.len(), count, stride, len);
        Rows {
            start: data.as_ptr(),
            stride,
            count,
            len,
            life: PhantomData,
        }
    }

    /// Number of rows: degrees of freedom.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Length of a row: samples.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether the rows hold no sample.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Row `i`, one value for each sample.
    ///
    /// # Panics
    /// If row `i` does not exist.
    #[inline]
    pub fn row(&self, i: usize) -> &'a [f64] {
        assert!(i < self.count, "row {i} of {}", self.count);
        // SAFETY: `assert_fits` held when `start`, `stride`, `count` and `len` were
        // set, so row `i` lies inside the slice borrowed for `'a`.
        unsafe { std::slice::from_raw_parts(self.start.add(i * self.stride), self.len) }
    }

    /// All values, row after row, if nothing lies between the rows.
    #[inline]
    pub fn as_slice(&self) -> Option<&'a [f64]> {
        // SAFETY: as in `row`; rows as far apart as they are long fill the memory between the first
        // value and the last.
        (self.stride == self.len)
            .then(|| unsafe { std::slice::from_raw_parts(self.start, self.count * self.len) })
    }

    /// Whether no value is infinite or NaN.
    pub fn all_finite(&self) -> bool {
        all_finite(*self)
    }
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn all_finite(rows: Rows<'_>) -> bool {
    // Without a branch and in words as wide as the values, so that it is vectorised.
    let is_finite = |values: &[f64]| {
        let mut found = 0;
        for value in values {
            found |= u64::from(!value.is_finite());
        }
        found == 0
    };
    match rows.as_slice() {
        Some(values) => is_finite(values),
        None => (0..rows.count).all(|i| is_finite(rows.row(i))),
    }
}

impl<'a> RowsMut<'a> {
    /// The first `len` values of `count` rows that lie `stride` values apart in `data`.
    ///
    /// # Panics
    /// If `data` is too short or `len` exceeds `stride`.
    pub fn new(data: &'a mut [f64], count: usize, stride: usize, len: usize) -> Self {
        assert_fits(data.len(), count, stride, len);
        RowsMut {
            start: data.as_mut_ptr(),
            stride,
            count,
            len,
            life: PhantomData,
        }
    }

    /// Number of rows: degrees of freedom.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Length of a row: samples.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether the rows hold no sample.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Row `i`, one value for each sample.
    ///
    /// # Panics
    /// If row `i` does not exist.
    #[inline]
    pub fn row(&self, i: usize) -> &[f64] {
        self.as_rows().row(i)
    }

    /// Row `i` for writing, one value for each sample.
    ///
    /// # Panics
    /// If row `i` does not exist.
    #[inline]
    pub fn row_mut(&mut self, i: usize) -> &mut [f64] {
        assert!(i < self.count, "row {i} of {}", self.count);
        // SAFETY: as in `Rows::row`; `&mut self` makes this the only live access
        // to these rows, and other `RowsMut` of the same table are disjoint.
        unsafe { std::slice::from_raw_parts_mut(self.start.add(i * self.stride), self.len) }
    }

    /// Whether each row begins on another page of memory.
    pub(crate) fn is_scattered(&self) -> bool {
        self.stride >= VALUES_OF_PAGE && self.len < VALUES_OF_PAGE
    }

    /// All values for writing, row after row, if nothing lies between the rows.
    #[inline]
    pub fn as_mut_slice(&mut self) -> Option<&mut [f64]> {
        // SAFETY: as in `Rows::as_slice` and `row_mut`; nothing between the rows belongs to others.
        (self.stride == self.len)
            .then(|| unsafe { std::slice::from_raw_parts_mut(self.start, self.count * self.len) })
    }

    /// The same rows, read-only.
    #[inline]
    pub fn as_rows(&self) -> Rows<'_> {
        Rows {
            start: self.start,
            stride: self.stride,
            count: self.count,
            len: self.len,
            life: PhantomData,
        }
    }

    /// The same rows for a shorter time, so that they can be passed on and used again.
    pub fn reborrow(&mut self) -> RowsMut<'_> {
        RowsMut {
            start: self.start,
            stride: self.stride,
            count: self.count,
            len: self.len,
            life: PhantomData,
        }
    }

    /// Sets every value.
    pub fn fill(&mut self, value: f64) {
        for i in 0..self.count {
            self.row_mut(i).fill(value);
        }
    }

    /// Copies rows of the same shape.
    ///
    /// # Panics
    /// If the shapes differ.
    pub fn copy_from(&mut self, source: Rows<'_>) {
        assert_eq!((self.count, self.len), (source.count, source.len));
        for i in 0..self.count {
            self.row_mut(i).copy_from_slice(source.row(i));
        }
    }

    /// The first `count` rows, and the others.
    ///
    /// # Panics
    /// If there are fewer.
    pub fn split_at_row(self, count: usize) -> (RowsMut<'a>, RowsMut<'a>) {
        assert!(count <= self.count, "{count} rows of {}", self.count);
        let others = RowsMut {
            // Without other rows there may be no memory where they would begin.
            start: match self.count - count {
                0 => self.start,
                // SAFETY: there is a row `count`, so its start lies inside the table; the
                // rows before it belong to the other half alone.
                _ => unsafe { self.start.add(count * self.stride) },
            },
            count: self.count - count,
            ..self
        };
        (RowsMut { count, ..self }, others)
    }

    /// Cuts the rows into column ranges of at most `width` samples each.
    ///
    /// # Panics
    /// If `width` is zero.
    pub fn column_blocks(self, width: usize) -> impl Iterator<Item = RowsMut<'a>> {
        assert!(width > 0, "a block needs at least one sample");
        // Without rows no memory lies behind the pointer, and nothing is cut.
        let columns = if self.count == 0 { 0 } else { self.len };
        (0..columns).step_by(width).map(move |first| RowsMut {
            // SAFETY: `first < len` and there is a row, so the pointer stays inside the first
            // row; the ranges [first, first + len) of different blocks do not overlap.
            start: unsafe { self.start.add(first) },
            stride: self.stride,
            count: self.count,
            len: width.min(self.len - first),
            life: PhantomData,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_without_gaps_are_one_slice_and_others_are_none() {
        let mut values: Vec<f64> = (0..12).map(f64::from).collect();
        let expected = values.clone();
        let rows = Rows::new(&values, 4, 3, 3);
        assert_eq!(rows.as_slice(), Some(&expected[..]));
        assert!(Rows::new(&values, 3, 4, 3).as_slice().is_none());
        assert_eq!(Rows::new(&[], 0, 3, 3).as_slice(), Some(&[][..]));
        let mut rows = RowsMut::new(&mut values, 4, 3, 3);
        rows.as_mut_slice().unwrap()[5] = -1.0;
        assert_eq!(rows.row(1), [3.0, 4.0, -1.0]);
        let block = RowsMut::new(&mut values, 4, 3, 3).column_blocks(2).next();
        assert!(block.unwrap().as_mut_slice().is_none());
    }

    #[test]
    fn halves_have_the_rows_between_them() {
        let expected: Vec<f64> = (0..11).map(f64::from).collect();
        for count in 0..=3 {
            let mut values = expected.clone();
            let rows = RowsMut::new(&mut values, 3, 4, 3);
            let (mut first, mut second) = rows.split_at_row(count);
            assert_eq!((first.count(), second.count()), (count, 3 - count));
            for i in 0..3 {
                let (half, row) = if i < count {
                    (&mut first, i)
                } else {
                    (&mut second, i - count)
                };
                assert_eq!(half.row(row), &expected[4 * i..4 * i + 3]);
                half.row_mut(row).fill(-1.0);
            }
            let untouched = [3, 7].map(|between| values[between]);
            assert_eq!(untouched, [3.0, 7.0]);
            assert_eq!(values.iter().filter(|&&v| v == -1.0).count(), 9);
        }
    }

    #[test]
    fn values_that_are_not_finite_are_found_anywhere_in_the_rows_and_nowhere_else() {
        let (count, stride, len) = (3, 24, 21);
        let sound = [f64::MAX, f64::MIN, 0.0, -0.0, 5e-324, 1.0].repeat(12);
        assert!(Rows::new(&sound, count, stride, len).all_finite());
        assert!(Rows::new(&[], 0, stride, len).all_finite());
        for at in 0..count * stride {
            for value in [f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let mut values = sound.clone();
                values[at] = value;
                let between_rows = at % stride >= len;
                let rows = Rows::new(&values, count, stride, len);
                assert_eq!(rows.all_finite(), between_rows, "{value} at {at}");
            }
        }
    }
}

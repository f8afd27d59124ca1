//! Reading from and writing to memory of the caller.
//!
//! Null, alignment and sizes are checked here; that so much memory is there is what the caller promises.

use std::ffi::{CStr, c_char};
use std::ops::Range;

use symplint::Ensemble;
use symplint::state::Rows;

use crate::status::Failure;

/// Refuses null, and addresses at which no `T` can be.
fn check<T>(what: &str, pointer: *const T) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::null(what));
    }
    match pointer.is_aligned() {
        true => Ok(()),
        false => Err(Failure::bad_argument(format!("{what} is not aligned"))),
    }
}

/// The values of an array.
///
/// # Safety
/// If it is not null, this number of values is there and does not change during `'a`.
pub unsafe fn values<'a, T>(
    what: &str,
    pointer: *const T,
    count: usize,
) -> Result<&'a [T], Failure> {
    check(what, pointer)?;
    if count
        .checked_mul(size_of::<T>())
        .is_none_or(|bytes| bytes > isize::MAX as usize)
    {
        return Err(Failure::bad_argument(format!(
            "{what}: {count} values are too many"
        )));
    }
    // SAFETY: the pointer is neither null nor misaligned, the size does not overflow, and the caller promises the rest.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// The same of an array that may be null.
///
/// # Safety
/// That of [`values`].
pub unsafe fn optional_values(
    what: &str,
    pointer: *const f64,
    count: usize,
) -> Result<Option<Vec<f64>>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller promises what `values` needs.
    unsafe { values(what, pointer, count) }.map(|values| Some(values.to_vec()))
}

/// A value to be read.
///
/// # Safety
/// If it is not null, a valid value is there and does not change during `'a`.
pub unsafe fn value<'a, T>(what: &str, pointer: *const T) -> Result<&'a T, Failure> {
    check(what, pointer)?;
    // SAFETY: the pointer is neither null nor misaligned, and the caller promises the rest.
    Ok(unsafe { &*pointer })
}

/// Writes values to an array.
///
/// # Safety
/// If it is not null, there is memory for them.
pub unsafe fn write<T: Copy>(what: &str, pointer: *mut T, found: &[T]) -> Result<(), Failure> {
    check(what, pointer.cast_const())?;
    // SAFETY: the pointer is neither null nor misaligned, and the caller promises the memory.
    unsafe { std::ptr::copy_nonoverlapping(found.as_ptr(), pointer, found.len()) };
    Ok(())
}

/// Copies the first `size` bytes of a struct of the caller over `target`.
///
/// # Safety
/// So many bytes are there, every pattern of them is a valid `T`, and the struct begins as `T` does.
pub unsafe fn overlay<T>(
    what: &str,
    source: *const T,
    size: usize,
    target: &mut T,
) -> Result<(), Failure> {
    check(what, source)?;
    let size = size.min(size_of::<T>());
    // SAFETY: not more bytes than `target` has, and the caller promises those of the source.
    unsafe {
        std::ptr::copy_nonoverlapping(source.cast::<u8>(), (&raw mut *target).cast::<u8>(), size);
    }
    Ok(())
}

/// Copies the first `size` bytes of `source` to a struct of the caller, which may be an older one.
///
/// # Safety
/// There is memory for this number of bytes.
pub unsafe fn write_prefix<T>(
    what: &str,
    target: *mut T,
    size: usize,
    source: &T,
) -> Result<(), Failure> {
    check(what, target.cast_const())?;
    let size = size.min(size_of::<T>());
    // SAFETY: not more bytes than `source` has, and the caller promises the memory of the target.
    unsafe {
        std::ptr::copy_nonoverlapping((&raw const *source).cast::<u8>(), target.cast::<u8>(), size);
    }
    Ok(())
}

/// A text that may be null.
///
/// # Safety
/// If it is not null, it ends with a zero and does not change during `'a`.
pub unsafe fn text<'a>(what: &str, pointer: *const c_char) -> Result<Option<&'a str>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: it is not null, and the caller promises that it ends with a zero.
    let text = unsafe { CStr::from_ptr(pointer) };
    (text.to_str().map(Some)).map_err(|_| Failure::bad_argument(format!("{what} is not UTF-8")))
}

/// Samples of some degrees of freedom that are copied together.
const SAMPLES_TOGETHER: usize = 64;

/// The places of the values of an array of states.
#[derive(Clone, Copy)]
pub struct Layout {
    pub dof: usize,
    pub samples: usize,
    /// Values from one degree of freedom to the next.
    pub dof_stride: usize,
    /// Values from one sample to the next.
    pub sample_stride: usize,
}

impl Layout {
    /// Refuses layouts whose last value no memory holds, and those without values.
    pub fn check(&self) -> Result<(), Failure> {
        if self.dof == 0 {
            return Err(Failure::bad_argument(
                "dof is 0; give one degree of freedom or more",
            ));
        }
        if self.samples < 3 {
            let text = format!("samples is {}; give 3 or more", self.samples);
            return Err(Failure::bad_argument(text));
        }
        let far = |count: usize, stride: usize| (count - 1).checked_mul(stride);
        (far(self.dof, self.dof_stride))
            .zip(far(self.samples, self.sample_stride))
            .and_then(|(rows, columns)| rows.checked_add(columns)?.checked_add(1)?.checked_mul(8))
            .filter(|&bytes| bytes <= isize::MAX as usize)
            .map(|_| ())
            .ok_or_else(|| Failure::bad_argument("dof, samples and strides are too large"))
    }

    /// The rows of some degrees of freedom in the memory of the caller, if the samples of each lie side by side.
    ///
    /// # Safety
    /// `values` has a value at i × dof_stride + k × sample_stride for every i < dof and k < samples, and is not written to
    /// during `'a`.
    pub unsafe fn in_place<'a>(
        &self,
        what: &str,
        values: *const f64,
        dofs: Range<usize>,
    ) -> Result<Option<Rows<'a>>, Failure> {
        self.check()?;
        check(what, values)?;
        assert!(dofs.end <= self.dof, "{dofs:?} of {}", self.dof);
        // Rows are transformed one by one.
        self.check_memory(1)?;
        let (count, last) = (dofs.len(), self.samples - 1);
        if self.sample_stride != 1 || (count > 1 && self.dof_stride < self.samples) {
            return Ok(None);
        }
        // SAFETY: `check` found that no offset overflows, and the caller promises the values.
        let values = unsafe {
            let length = (count - 1) * self.dof_stride + last + 1;
            std::slice::from_raw_parts(values.add(dofs.start * self.dof_stride), length)
        };
        let stride = self.dof_stride.max(self.samples);
        Ok(Some(Rows::new(values, count, stride, self.samples)))
    }

    /// Refuses samples of `dof` degrees of freedom whose copies do not fit into memory. Values that are read many times, by a stride of 0,
    /// need none of the caller, but copies and transforms do.
    fn check_memory(&self, dof: usize) -> Result<(), Failure> {
        let mut reserved: Vec<f64> = Vec::new();
        let values = (self.samples.checked_mul(2)).and_then(|of_each| of_each.checked_mul(dof));
        if values.is_none_or(|values| reserved.try_reserve_exact(values).is_err()) {
            return Err(symplint::Error::TooLarge {
                dof,
                samples: self.samples,
                bytes: 16.0 * dof as f64 * self.samples as f64,
            }
            .into());
        }
        drop(std::hint::black_box(reserved));
        Ok(())
    }

    /// A copy of some degrees of freedom, sample by sample.
    ///
    /// # Safety
    /// `q` and `p` have a value at i × dof_stride + k × sample_stride for every i < dof and k < samples.
    pub unsafe fn copy(
        &self,
        q: *const f64,
        p: *const f64,
        dofs: Range<usize>,
    ) -> Result<Ensemble, Failure> {
        self.check()?;
        check("q", q)?;
        check("p", p)?;
        assert!(dofs.end <= self.dof, "{dofs:?} of {}", self.dof);
        self.check_memory(dofs.len())?;
        let mut states = Ensemble::zeros(dofs.len(), self.samples);
        let block = states.block();
        for (from, mut to) in [(q, block.q), (p, block.p)] {
            // As many samples as keep the values of all these degrees of freedom in the cache.
            for first in (0..self.samples).step_by(SAMPLES_TOGETHER) {
                let samples = first..self.samples.min(first + SAMPLES_TOGETHER);
                for (row, i) in dofs.clone().enumerate() {
                    let to = &mut to.row_mut(row)[samples.clone()];
                    for (to, k) in to.iter_mut().zip(samples.clone()) {
                        // SAFETY: `check` found that the offset does not overflow, and the caller promises a value there.
                        *to = unsafe { *from.add(i * self.dof_stride + k * self.sample_stride) };
                    }
                }
            }
        }
        Ok(states)
    }
}

//! Memory that begins with a cache line.

use std::fmt::{Debug, Formatter, Result};
use std::ops::{Deref, DerefMut, Range};

use super::rows::CACHE_LINE;

/// Values of which the first is at the start of a cache line. So are all rows and blocks whose lengths are multiples of a line: no vector
/// of a kernel lies in two lines, and no two blocks share one.
pub(crate) struct Buffer {
    memory: Vec<f64>,
    /// The part that is aligned.
    aligned: Range<usize>,
}

impl Buffer {
    /// A buffer of `len` zeros.
    pub fn zeros(len: usize) -> Self {
        let most = CACHE_LINE - 1;
        let memory = vec![0.0; len + most];
        let to_line = memory.as_ptr().align_offset(size_of::<[f64; CACHE_LINE]>());
        // Miri may know of no such offset.
        let start = to_line.min(most);
        Buffer {
            memory,
            aligned: start..start + len,
        }
    }
}

impl Deref for Buffer {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.memory[self.aligned.clone()]
    }
}

impl DerefMut for Buffer {
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.memory[self.aligned.clone()]
    }
}

impl Clone for Buffer {
    fn clone(&self) -> Self {
        let mut buffer = Buffer::zeros(self.len());
        buffer.copy_from_slice(self);
        buffer
    }
}

impl Debug for Buffer {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        (**self).fmt(f)
    }
}

impl PartialEq for Buffer {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buffers_of_any_length_begin_with_a_cache_line() {
        for len in [0, 1, 7, 8, 9, 100, 1000] {
            let mut buffer = Buffer::zeros(len);
            assert_eq!(buffer.len(), len);
            buffer
                .iter_mut()
                .zip(0..)
                .for_each(|(value, k)| *value = f64::from(k));
            let copy = buffer.clone();
            assert!(copy == buffer);
            for buffer in [buffer, copy] {
                assert_eq!(buffer.as_ptr().addr() % 64, 0);
            }
        }
    }
}

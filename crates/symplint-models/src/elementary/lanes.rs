//! Rows taken a few numbers at a time.

use super::kernel::{Arithmetic, LANES};

/// What is to be done with the numbers of `K` rows and of one that is written.
///
/// A trait in place of a closure, because it must be inlined: a function of its own would be compiled
/// for any processor.
pub(crate) trait LaneMap<const K: usize> {
    /// The new values of `out`; implementations are `#[inline(always)]`.
    fn apply<M: Arithmetic>(&self, inputs: [[f64; LANES]; K], out: [f64; LANES]) -> [f64; LANES];
}

/// Does it for whole rows. What is left at their ends is filled up with zeros, so that every number
/// goes the same way.
///
/// # Panics
/// If the rows differ in length.
#[inline(always)]
pub(crate) fn map_lanes<M: Arithmetic, const K: usize>(
    map: &impl LaneMap<K>,
    inputs: [&[f64]; K],
    out: &mut [f64],
) {
    for input in inputs {
        assert_eq!(input.len(), out.len(), "rows of one length");
    }
    let chunks = inputs.map(|input| input.as_chunks::<LANES>().0);
    let (whole, rest) = out.as_chunks_mut::<LANES>();
    for (c, out) in whole.iter_mut().enumerate() {
        *out = map.apply::<M>(chunks.map(|chunks| chunks[c]), *out);
    }
    if !rest.is_empty() {
        let rests = inputs.map(|input| filled_up(input.as_chunks::<LANES>().1));
        let result = map.apply::<M>(rests, filled_up(rest));
        rest.copy_from_slice(&result[..rest.len()]);
    }
}

#[inline(always)]
fn filled_up(rest: &[f64]) -> [f64; LANES] {
    let mut lanes = [0.0; LANES];
    lanes[..rest.len()].copy_from_slice(rest);
    lanes
}

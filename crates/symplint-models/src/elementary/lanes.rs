//! Rows taken a few numbers at a time.

use super::kernel::{Arithmetic, LANES};

/// A number of each sample, of a few samples.
pub(crate) type Lanes = [f64; LANES];

/// The operation on the numbers of `I` rows that are read and `O` that are written.
///
/// A trait instead of a closure, because it must be inlined: a separate function would be compiled
/// for any processor.
pub(crate) trait LaneMap<const I: usize, const O: usize> {
    /// The new values of what is written; implementations are `#[inline(always)]`.
    fn apply<M: Arithmetic>(&self, read: [Lanes; I], written: [Lanes; O]) -> [Lanes; O];
}

/// Does it for whole rows. The remainder at their ends is filled up with zeros, so that every number
/// goes the same way.
///
/// # Panics
/// If the rows differ in length.
#[inline(always)]
pub(crate) fn map_lanes<M: Arithmetic, const I: usize, const O: usize>(
    map: &impl LaneMap<I, O>,
    read: [&[f64]; I],
    written: [&mut [f64]; O],
) {
    let len = written[0].len();
    let same =
        (read.iter().all(|row| row.len() == len)) && (written.iter().all(|row| row.len() == len));
    assert!(same, "rows of one length");
    let read = read.map(|row| row.as_chunks::<LANES>());
    let mut written = written.map(|row| row.as_chunks_mut::<LANES>());
    map_chunks::<M, I, O>(
        map,
        read.map(|(whole, _)| whole),
        written.each_mut().map(|(whole, _)| &mut **whole),
    );
    if !len.is_multiple_of(LANES) {
        let read = read.map(|(_, end)| filled_up(end));
        let mut lanes = written.each_ref().map(|(_, end)| filled_up(end));
        map_chunks::<M, I, O>(
            map,
            read.each_ref().map(std::slice::from_ref),
            lanes.each_mut().map(std::slice::from_mut),
        );
        for ((_, end), lanes) in written.into_iter().zip(lanes) {
            end.copy_from_slice(&lanes[..end.len()]);
        }
    }
}

#[inline(always)]
fn map_chunks<M: Arithmetic, const I: usize, const O: usize>(
    map: &impl LaneMap<I, O>,
    read: [&[Lanes]; I],
    written: [&mut [Lanes]; O],
) {
    for chunk in 0..written[0].len() {
        let lanes = std::array::from_fn(|w| written[w][chunk]);
        let lanes = map.apply::<M>(read.map(|row| row[chunk]), lanes);
        for w in 0..O {
            written[w][chunk] = lanes[w];
        }
    }
}

#[inline(always)]
fn filled_up(end: &[f64]) -> Lanes {
    let mut lanes = [0.0; LANES];
    lanes[..end.len()].copy_from_slice(end);
    lanes
}

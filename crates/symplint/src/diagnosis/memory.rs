//! What fits into memory.

use super::limits::MOST_BYTES;

/// Whether an ensemble of so many samples may be made without being asked for.
pub(super) fn fits(dof: usize, samples: usize) -> bool {
    samples.saturating_mul(dof) <= MOST_BYTES / 16
}

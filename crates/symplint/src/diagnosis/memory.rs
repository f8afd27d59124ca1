//! What fits into memory.

/// Memory of the largest ensemble that is chosen without being asked for; samples before and after a step
/// make two of them.
pub(super) const MOST_BYTES: usize = 512 << 20;

/// Samples of the smallest ensembles that a diagnosis makes, apart from those that it measures with.
pub(super) const SMALL: usize = 64;

/// Whether an ensemble of so many samples may be made without being asked for.
pub(super) fn fits(dof: usize, samples: usize) -> bool {
    samples.saturating_mul(dof) <= MOST_BYTES / 16
}

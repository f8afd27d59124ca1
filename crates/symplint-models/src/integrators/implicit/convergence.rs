//! Which samples of a block are solved: each by its own figures.

/// Mark of a sample that is solved; changes are not negative.
const SOLVED: f64 = -1.0;

/// The progress of an iteration on every sample of a block.
///
/// A solved sample stays as it is while others go on, so that its result is the same in any block.
pub(super) struct Convergence<'a> {
    tolerance: f64,
    /// Size of a sample's state.
    sizes: &'a mut [f64],
    /// What the last iteration changed, or `SOLVED`.
    last: &'a mut [f64],
    /// What this iteration has changed so far.
    change: &'a mut [f64],
}

impl<'a> Convergence<'a> {
    /// Below this fraction of the state a change that no longer falls is round-off.
    const ROUNDOFF: f64 = 64.0 * f64::EPSILON;

    /// Values of scratch memory for a block of `len` samples.
    pub(super) fn room(len: usize) -> usize {
        3 * len
    }

    /// Nothing solved yet; `sizes` are the sizes of the states.
    pub(super) fn new(
        tolerance: f64,
        of_states: impl Iterator<Item = f64>,
        room: &'a mut [f64],
    ) -> Self {
        let len = room.len() / 3;
        let (sizes, rest) = room.split_at_mut(len);
        let (last, change) = rest.split_at_mut(len);
        for (size, of_state) in sizes.iter_mut().zip(of_states) {
            *size = of_state;
        }
        last.fill(f64::INFINITY);
        change.fill(0.0);
        Convergence {
            tolerance,
            sizes,
            last,
            change,
        }
    }

    /// Whether a sample is not solved yet.
    pub(super) fn is_open(&self, sample: usize) -> bool {
        self.last[sample] != SOLVED
    }

    /// Size of the state of a sample.
    pub(super) fn size(&self, sample: usize) -> f64 {
        self.sizes[sample]
    }

    /// Notes a change of a sample that is open. A change that is not a number stays.
    pub(super) fn note(&mut self, sample: usize, change: f64) {
        let noted = &mut self.change[sample];
        if change > *noted || change.is_nan() {
            *noted = change;
        }
    }

    /// Ends an iteration; whether going on is of no use, because everything is solved or nothing
    /// open is finite.
    pub(super) fn settle(&mut self) -> bool {
        let mut over = true;
        let samples = self
            .last
            .iter_mut()
            .zip(&mut *self.change)
            .zip(&*self.sizes);
        for ((last, change), size) in samples {
            if *last == SOLVED {
                continue;
            }
            let stalled = *change >= *last && *change <= Self::ROUNDOFF * size;
            *last = if *change <= self.tolerance * size || stalled {
                SOLVED
            } else {
                over &= !change.is_finite();
                *change
            };
            *change = 0.0;
        }
        over
    }

    /// The first sample that is not solved, with its last change relative to its size.
    pub(super) fn first_open(&self) -> Option<(usize, f64)> {
        let sample = (0..self.last.len()).find(|&sample| self.is_open(sample))?;
        Some((sample, self.last[sample] / self.sizes[sample]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solved_after(tolerance: f64, changes: &[f64]) -> Option<usize> {
        let mut room = [0.0; 3];
        let mut convergence = Convergence::new(tolerance, [2.0].into_iter(), &mut room);
        changes.iter().position(|&change| {
            convergence.note(0, change);
            convergence.settle();
            !convergence.is_open(0)
        })
    }

    #[test]
    fn the_tolerance_is_relative_to_the_state() {
        assert_eq!(solved_after(1e-3, &[1.0, 2.1e-3, 1.9e-3]), Some(2));
        assert_eq!(solved_after(0.0, &[1.0, 1e-10, 0.0]), Some(2));
    }

    #[test]
    fn a_change_that_no_longer_falls_is_round_off_only_if_it_is_small() {
        assert_eq!(solved_after(0.0, &[1e-3, 1e-3, 1e-3]), None);
        assert_eq!(solved_after(0.0, &[1e-3, 1e-15, 1e-15]), Some(2));
    }

    #[test]
    fn what_is_not_a_number_is_never_solved() {
        let mut room = [0.0; 6];
        let mut convergence = Convergence::new(1.0, [1.0, 1.0].into_iter(), &mut room);
        for change in [0.5, f64::NAN, 0.1] {
            convergence.note(1, change);
        }
        assert!(convergence.settle(), "going on is of no use");
        assert_eq!(convergence.first_open().map(|(sample, _)| sample), Some(1));
    }
}

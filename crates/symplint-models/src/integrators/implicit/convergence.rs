//! Which samples of a block are solved: each by its own figures.

use super::solver::Stop;

/// Mark of a sample that is solved; changes are not negative.
const SOLVED: f64 = -1.0;

/// The progress of an iteration on every sample of a block.
///
/// A solved sample stays unchanged while others continue, so that its result is the same in any block.
pub(super) struct Convergence<'a> {
    /// Size of a sample's state.
    sizes: &'a mut [f64],
    /// Changes up to this may be round-off.
    floors: &'a mut [f64],
    /// The least that an iteration changed so far, or `SOLVED`.
    least: &'a mut [f64],
    /// Iterations since then.
    stalls: &'a mut [f64],
    /// What this iteration has changed so far.
    change: &'a mut [f64],
}

/// A sample that is not solved after the most iterations.
pub(super) struct UnsolvedSample {
    pub(super) sample: usize,
    /// The least change of an iteration, relative to the size of the sample.
    pub(super) change: f64,
    pub(super) tolerance: f64,
    pub(super) max_iterations: usize,
}

impl<'a> Convergence<'a> {
    /// Below this fraction of the state, changes that no longer fall are round-off.
    const ROUNDOFF: f64 = 1e-12;

    /// So many iterations without progress are no accident.
    const PATIENCE: f64 = 3.0;

    /// Values of scratch memory for a block of `len` samples.
    pub(super) fn room(len: usize) -> usize {
        5 * len
    }

    /// Nothing solved yet.
    pub(super) fn new(of_states: impl Iterator<Item = f64>, room: &'a mut [f64]) -> Self {
        let len = room.len() / 5;
        let (sizes, rest) = room.split_at_mut(len);
        let (floors, rest) = rest.split_at_mut(len);
        let (least, rest) = rest.split_at_mut(len);
        let (stalls, change) = rest.split_at_mut(len);
        for (size, of_state) in sizes.iter_mut().zip(of_states) {
            *size = of_state;
        }
        for (floor, size) in floors.iter_mut().zip(&*sizes) {
            *floor = Self::ROUNDOFF * size;
        }
        least.fill(f64::INFINITY);
        stalls.fill(0.0);
        change.fill(0.0);
        Convergence {
            sizes,
            floors,
            least,
            stalls,
            change,
        }
    }

    /// Whether a sample is not solved yet.
    pub(super) fn is_open(&self, sample: usize) -> bool {
        self.least[sample] != SOLVED
    }

    /// Size of the state of a sample.
    pub(super) fn size(&self, sample: usize) -> f64 {
        self.sizes[sample]
    }

    /// Says that changes of a sample up to `change` may be round-off, if that is more than its state's.
    pub(super) fn raise_floor(&mut self, sample: usize, change: f64) {
        self.floors[sample] = self.floors[sample].max(change);
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
    fn settle(&mut self, tolerance: f64) -> bool {
        let mut over = true;
        for sample in 0..self.sizes.len() {
            if !self.is_open(sample) {
                continue;
            }
            let (change, size) = (self.change[sample], self.sizes[sample]);
            self.change[sample] = 0.0;
            if !change.is_finite() {
                // Kept, and never solved: what is not finite stays so.
                self.least[sample] = f64::NAN;
                continue;
            }
            if change < self.least[sample] {
                self.least[sample] = change;
                self.stalls[sample] = 0.0;
            } else {
                self.stalls[sample] += 1.0;
            }
            let stalled =
                self.stalls[sample] >= Self::PATIENCE && self.least[sample] <= self.floors[sample];
            if change <= tolerance * size || stalled {
                self.least[sample] = SOLVED;
            } else {
                over = false;
            }
        }
        over
    }

    /// Iterates until `stop`. A fixed number of iterations leaves nothing unsolved, as it asks for no more.
    pub(super) fn run(
        &mut self,
        stop: Stop,
        mut iterate: impl FnMut(&mut Self),
    ) -> Result<(), UnsolvedSample> {
        let (tolerance, max_iterations) = match stop {
            Stop::Iterations(iterations) => {
                (0..iterations).for_each(|_| iterate(self));
                return Ok(());
            }
            Stop::Converged {
                tolerance,
                max_iterations,
            } => (tolerance, max_iterations),
        };
        for _ in 0..max_iterations {
            iterate(self);
            if self.settle(tolerance) {
                break;
            }
        }
        let unsolved = self.first_open().map(|(sample, change)| UnsolvedSample {
            sample,
            change,
            tolerance,
            max_iterations,
        });
        unsolved.map_or(Ok(()), Err)
    }

    /// The first sample that is not solved, with the least change of it relative to its size.
    fn first_open(&self) -> Option<(usize, f64)> {
        let sample = (0..self.least.len()).find(|&sample| self.is_open(sample))?;
        Some((sample, self.least[sample] / self.sizes[sample]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solved_after(tolerance: f64, changes: &[f64]) -> Option<usize> {
        let mut room = [0.0; 5];
        let mut convergence = Convergence::new([2.0].into_iter(), &mut room);
        changes.iter().position(|&change| {
            convergence.note(0, change);
            convergence.settle(tolerance);
            !convergence.is_open(0)
        })
    }

    #[test]
    fn the_tolerance_is_relative_to_the_state() {
        assert_eq!(solved_after(1e-3, &[1.0, 2.1e-3, 1.9e-3]), Some(2));
        assert_eq!(solved_after(0.0, &[1.0, 1e-10, 0.0]), Some(2));
    }

    #[test]
    fn changes_that_no_longer_fall_are_round_off_only_if_they_are_small() {
        assert_eq!(solved_after(0.0, &[1e-3; 9]), None);
        let noise = [1e-3, 1e-15, 2e-15, 1e-15, 3e-15, 1e-15];
        assert_eq!(solved_after(0.0, &noise), Some(4));
        // A sequence that rises once continues to fall.
        assert_eq!(
            solved_after(1e-15, &[1e-12, 2e-12, 1e-13, 1e-14, 1e-15]),
            Some(4)
        );
    }

    #[test]
    fn noise_that_is_known_is_round_off() {
        let noise = [1e-3, 1e-9, 2e-9, 1e-9, 3e-9, 1e-9];
        assert_eq!(solved_after(0.0, &noise), None);
        let mut room = [0.0; 5];
        let mut convergence = Convergence::new([2.0].into_iter(), &mut room);
        convergence.raise_floor(0, 1.5e-9);
        // A change below the rounding of the state has no effect.
        convergence.raise_floor(0, 1e-30);
        let solved = noise.iter().position(|&change| {
            convergence.note(0, change);
            convergence.settle(0.0);
            !convergence.is_open(0)
        });
        assert_eq!(solved, Some(4));
    }

    #[test]
    fn what_is_not_a_number_is_never_solved() {
        let mut room = [0.0; 10];
        let mut convergence = Convergence::new([1.0, 1.0].into_iter(), &mut room);
        for change in [0.5, f64::NAN, 0.1] {
            convergence.note(1, change);
        }
        assert!(convergence.settle(1.0), "going on is of no use");
        assert_eq!(convergence.first_open().map(|(sample, _)| sample), Some(1));
    }
}

//! Many particles shared out to threads, in portions that are the same on any number of them.
//!
//! Particles are halved until each part is at most two portions. The halves go to any thread that has
//! nothing to do; sums of halves are added in the order of the particles, so that how they are added up
//! depends on how many particles there are and on nothing else.

use std::ops::Range;

use symplint::state::{RowsMut, scratch};

/// How many particles a thread takes at least.
#[derive(Clone, Copy, Debug)]
pub(super) struct Portions {
    least: usize,
}

impl Portions {
    /// For particles that are carried to tables of `table_len` values.
    pub(super) fn new(table_len: usize) -> Self {
        /// Some fifty microseconds, ten times what handing them over costs.
        const MIN_PARTICLES: usize = 1 << 14;
        /// So that clearing and adding tables takes little of the time, and little of the memory.
        const PARTICLES_PER_VALUE: usize = 4;
        Portions {
            least: MIN_PARTICLES.max(PARTICLES_PER_VALUE * table_len),
        }
    }

    /// Two halves of the particles, unless these are one portion.
    fn halves(self, particles: &Range<usize>) -> Option<[Range<usize>; 2]> {
        let middle = particles.start + particles.len() / 2;
        (particles.len() >= 2 * self.least)
            .then_some([particles.start..middle, middle..particles.end])
    }

    /// Writes into `table` the sum of what `deposit` writes for the portions of `particles`.
    pub(super) fn sum(
        self,
        particles: Range<usize>,
        table: &mut [f64],
        deposit: &(impl Fn(Range<usize>, &mut [f64]) + Sync),
    ) {
        let Some([first, second]) = self.halves(&particles) else {
            return deposit(particles, table);
        };
        scratch::with_buffer(table.len(), |other| {
            rayon::join(
                || self.sum(first, table, deposit),
                || self.sum(second, other, deposit),
            );
            for (sum, other) in table.iter_mut().zip(other) {
                *sum += *other;
            }
        });
    }

    /// Calls `work` with portions of the particles and the rows of those, `D` for each.
    pub(super) fn each<const D: usize>(
        self,
        particles: Range<usize>,
        rows: RowsMut<'_>,
        work: &(impl Fn(Range<usize>, RowsMut<'_>) + Sync),
    ) {
        let Some([first, second]) = self.halves(&particles) else {
            return work(particles, rows);
        };
        let (of_first, of_second) = rows.split_at_row(D * first.len());
        rayon::join(
            || self.each::<D>(first, of_first, work),
            || self.each::<D>(second, of_second, work),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALLEST: Portions = Portions { least: 3 };

    /// Every particle once, in the order of their numbers, whatever their number.
    #[test]
    fn all_particles_are_in_one_portion_each() {
        for particles in 0..40 {
            let mut numbers = vec![f64::NAN; particles];
            SMALLEST.sum(0..particles, &mut numbers, &|portion, table| {
                assert!(portion.len() < 2 * SMALLEST.least);
                table.fill(0.0);
                portion.for_each(|a| table[a] += a as f64);
            });
            let rows = RowsMut::new(&mut numbers, 2 * (particles / 2), 1, 1);
            SMALLEST.each::<2>(0..particles / 2, rows, &|portion, mut rows| {
                assert_eq!(rows.count(), 2 * portion.len());
                for (i, row) in (2 * portion.start..2 * portion.end).enumerate() {
                    assert_eq!(rows.row(i), [row as f64]);
                    rows.row_mut(i)[0] += 0.5;
                }
            });
            let expected = (0..particles).map(|a| match a < particles / 2 * 2 {
                true => a as f64 + 0.5,
                false => a as f64,
            });
            assert!(numbers.iter().copied().eq(expected), "{numbers:?}");
        }
    }

    #[test]
    fn sums_have_the_same_bits_on_any_number_of_threads() {
        let sum_on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().unwrap().install(|| {
                let mut sum = [0.0];
                SMALLEST.sum(0..1000, &mut sum, &|portion, sum| {
                    sum[0] = portion.map(|a| (a as f64).sin()).sum();
                });
                sum[0]
            })
        };
        let alone = sum_on(1);
        assert!(f64::abs(alone - (0..1000).map(|a| f64::from(a).sin()).sum::<f64>()) < 1e-12);
        for threads in [2, 3, 7] {
            assert_eq!(sum_on(threads), alone);
        }
    }
}

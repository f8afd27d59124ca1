//! Where particles are: their cells and how far into them, without branches or conversions.

use std::ops::Range;

use multiversion::multiversion;
use symplint::state::Rows;

use symplint_models::PeriodicGrid;

/// Finds places on a grid, many at a time: [`PeriodicGrid::locate`] to the last bit.
#[derive(Clone, Debug)]
pub(super) struct Locator {
    grid: PeriodicGrid,
}

/// Places of a run.
pub(super) const RUN: usize = 128;

/// Where `W` samples have some particles.
#[derive(Clone, Copy)]
pub(super) struct Places<'a, const W: usize> {
    cells: &'a [u32],
    fractions: &'a [f64],
}

impl<'a, const W: usize> Places<'a, W> {
    /// Particles of a run at most.
    pub(super) const MAX_PARTICLES: usize = RUN / W;

    /// For each particle the cells it is in and the fractions of them at which it is, in all samples.
    #[inline]
    pub(super) fn iter(self) -> impl Iterator<Item = (&'a [u32; W], &'a [f64; W])> {
        self.chunks()
    }

    /// The same by `C` places: of particles that have a row for each axis.
    #[inline]
    pub(super) fn chunks<const C: usize>(
        self,
    ) -> impl Iterator<Item = (&'a [u32; C], &'a [f64; C])> {
        let (cells, _) = self.cells.as_chunks();
        let (fractions, _) = self.fractions.as_chunks();
        cells.iter().zip(fractions)
    }

    /// Runs of these particles, and the number of the first of each.
    pub(super) fn runs(self) -> impl Iterator<Item = (usize, Self)> {
        let length = W * Self::MAX_PARTICLES;
        let runs = self.cells.chunks(length).zip(self.fractions.chunks(length));
        let firsts = (0..).step_by(Self::MAX_PARTICLES);
        firsts.zip(runs.map(|(cells, fractions)| Places { cells, fractions }))
    }
}

impl Locator {
    pub(super) fn new(grid: PeriodicGrid) -> Self {
        Locator { grid }
    }

    /// Writes the cell of every position, and the fraction of it at which the position lies.
    ///
    /// # Panics
    /// If the slices differ in length.
    #[inline]
    pub(super) fn locate(&self, x: &[f64], cells: &mut [u32], fractions: &mut [f64]) {
        assert!(x.len() == cells.len() && x.len() == fractions.len());
        if !locate_quickly(&self.grid, x, cells, fractions) {
            self.locate_each(x, cells, fractions);
        }
    }

    /// Calls `work` with runs of `particles` and where `W` neighbouring samples, from `first` on, have
    /// them: the number of the run's first particle, and its places.
    ///
    /// Position a is row a of `q`.
    #[inline]
    pub(super) fn each_run<const W: usize>(
        &self,
        q: Rows<'_>,
        first: usize,
        particles: Range<usize>,
        mut work: impl FnMut(usize, Places<'_, W>),
    ) {
        let (mut cells, mut fractions) = ([0; RUN], [0.0; RUN]);
        for a in particles.clone().step_by(Places::<W>::MAX_PARTICLES) {
            let end = particles.end.min(a + Places::<W>::MAX_PARTICLES);
            work(a, self.places(q, first, a..end, &mut cells, &mut fractions));
        }
    }

    /// Where `W` samples, from `first` on, have these particles. `cells` and `fractions` are memory for `W` values of each particle at
    /// least.
    #[inline]
    pub(super) fn places<'a, const W: usize>(
        &self,
        q: Rows<'_>,
        first: usize,
        particles: Range<usize>,
        cells: &'a mut [u32],
        fractions: &'a mut [f64],
    ) -> Places<'a, W> {
        let len = W * particles.len();
        let (cells, fractions) = (&mut cells[..len], &mut fractions[..len]);
        let whole = q.as_slice().filter(|_| q.len() == W);
        let length = W * Places::<W>::MAX_PARTICLES;
        let runs = cells.chunks_mut(length).zip(fractions.chunks_mut(length));
        let firsts = particles.step_by(Places::<W>::MAX_PARTICLES);
        let mut x = [0.0; RUN];
        for (start, (cells, fractions)) in firsts.zip(runs) {
            let len = cells.len();
            let x = match whole {
                Some(all) => &all[W * start..][..len],
                None => {
                    for (x, a) in x[..len].as_chunks_mut::<W>().0.iter_mut().zip(start..) {
                        x.copy_from_slice(&q.row(a)[first..first + W]);
                    }
                    &x[..len]
                }
            };
            self.locate(x, cells, fractions);
        }
        Places { cells, fractions }
    }

    /// Some positions are at nodes, far out, or not finite: all of them one by one.
    #[cold]
    fn locate_each(&self, x: &[f64], cells: &mut [u32], fractions: &mut [f64]) {
        for ((&x, cell), fraction) in x.iter().zip(cells).zip(fractions) {
            let place = self.grid.locate(x);
            (*cell, *fraction) = (place.0 as u32, place.1);
        }
    }
}

/// Finds places by [`PeriodicGrid::locate_quickly`], and says whether all of them are certain.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn locate_quickly(
    grid: &PeriodicGrid,
    x: &[f64],
    cells: &mut [u32],
    fractions: &mut [f64],
) -> bool {
    let mut certain = true;
    for ((&x, cell), fraction) in x.iter().zip(cells).zip(fractions) {
        let place = grid.locate_quickly(x);
        certain &= place.is_certain;
        (*cell, *fraction) = (place.cell, place.fraction);
    }
    certain
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn assert_as_on_the_grid(grid: PeriodicGrid, x: &[f64]) {
        let (mut cells, mut fractions) = (vec![0; x.len()], vec![0.0; x.len()]);
        Locator::new(grid).locate(x, &mut cells, &mut fractions);
        for ((&x, &cell), &fraction) in x.iter().zip(&cells).zip(&fractions) {
            let expected = grid.locate(x);
            assert_eq!(cell as usize, expected.0, "{x:e} on {grid:?}");
            assert_eq!(
                fraction.to_bits(),
                expected.1.to_bits(),
                "{x:e} on {grid:?}"
            );
        }
    }

    #[test]
    fn edges_and_far_positions_are_placed_as_on_the_grid() {
        for cells in [1, 2, 3, 7, 128, 1000, PeriodicGrid::MAX_CELLS] {
            for length in [1.0, 50.0, std::f64::consts::TAU, 1e-3 * cells as f64] {
                let grid = PeriodicGrid::new(cells, length).unwrap();
                for turns in [0.0, 1.0, -1.0, 1e3, -1e9, 1e9, 1e17, -1e300] {
                    let nodes = (0..=cells).step_by(cells.div_ceil(200));
                    for node in nodes.map(|i| grid.node(i) + turns * length) {
                        // Together they are near or far; alone each is what it is.
                        let around = [node.next_down(), node, node.next_up()];
                        assert_as_on_the_grid(grid, &around);
                        assert_as_on_the_grid(grid, &around[1..2]);
                    }
                }
                let small = [
                    0.0,
                    -0.0,
                    -1e-300,
                    1e-300,
                    -f64::MIN_POSITIVE,
                    -1e-17 * length,
                ];
                assert_as_on_the_grid(grid, &small);
                assert_as_on_the_grid(grid, &[0.3, f64::NAN, f64::INFINITY, -0.3]);
            }
        }
    }

    proptest! {
        #[test]
        fn any_position_is_placed_as_on_the_grid(
            cells in 1_usize..10_000,
            x in prop::collection::vec((-1.0_f64..1.0, -60_i32..70), 1..9),
        ) {
            let grid = PeriodicGrid::new(cells, 50.0).unwrap();
            let x: Vec<f64> = x.iter().map(|(m, e)| m * 2.0_f64.powi(*e)).collect();
            assert_as_on_the_grid(grid, &x);
        }
    }

    #[test]
    fn runs_are_the_rows() {
        let grid = PeriodicGrid::new(8, 8.0).unwrap();
        const PARTICLES: usize = 150;
        const SAMPLES: usize = 11;
        let q: Vec<f64> = (0..PARTICLES * SAMPLES).map(|i| 0.37 * i as f64).collect();
        let rows = Rows::new(&q, PARTICLES, SAMPLES, SAMPLES);
        let mut next = 7;
        Locator::new(grid).each_run::<4>(rows, 5, 7..141, |a, places| {
            assert_eq!(a, next);
            next += places.iter().count();
            for (i, (cells, fractions)) in places.iter().enumerate() {
                for sample in 0..4 {
                    let expected = grid.locate(rows.row(a + i)[5 + sample]);
                    assert_eq!((cells[sample] as usize, fractions[sample]), expected);
                }
            }
        });
        assert_eq!(next, 141);
    }
}

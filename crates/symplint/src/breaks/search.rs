//! All jumps of a coordinate that is known at samples only.
//!
//! A cell is *flagged* where its residual stands out of the noise and does not grow with the width of the cells.
//! Flagged cells are refilled with what their neighbours predict and the search goes
//! on, so that a large jump does not hide a small one. A flagged cell is *confirmed* as a jump if the
//! step has one size over cells of one, two and four spacings.

use super::limits::{
    MAX_FLAGGED_PART, MAX_MISMATCH_OF_SIZES, MAX_RESOLVED_RESIDUAL, MIN_CELLS_BETWEEN_JUMPS,
    MIN_NARROW_OVER_WIDE, MIN_OUTLIER_DEVIATIONS,
};
use super::residual::{NEIGHBOURS, noise, of_cell, of_cells};

/// A cell in which a coordinate jumps, as far as samples can tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Jump {
    /// From sample `cell` to sample `cell + 1`, round the loop.
    pub cell: usize,
    /// How far.
    pub size: f64,
    /// Whether it stays under refinement, from every fourth to every sample.
    pub confirmed: bool,
}

/// The rounding that the samples of one coordinate show.
#[derive(Clone, Debug, Default)]
pub(crate) struct Roughness {
    /// Flagged cells, in their order along the loop.
    pub jumps: Vec<Jump>,
    /// The largest residual that neither grows like a smooth one nor stands out: a jump of this size
    /// would not be noticed.
    pub hidden: f64,
    /// Whether the samples are too few, or too noisy, to show any shape at all.
    pub unresolved: bool,
}

/// Finds the jumps of a coordinate from its increments round the loop. Residuals below `floor` are rounding.
pub(crate) fn find_jumps(increments: &[f64], floor: f64) -> Roughness {
    let n = increments.len();
    let mut search = Search {
        raw: increments,
        filled: increments.to_vec(),
        flagged: vec![false; n],
        floor,
    };
    // Each pass uncovers what larger jumps nearby had covered.
    loop {
        let residuals = [1, 2].map(|width| search.residuals(width));
        if !search.flag(&residuals) {
            return search.conclude(&residuals);
        }
        search.refill();
        let flagged = search.flagged.iter().filter(|&&f| f).count();
        if flagged as f64 > MAX_FLAGGED_PART * n as f64 {
            return Roughness {
                unresolved: true,
                ..Roughness::default()
            };
        }
    }
}

struct Search<'a> {
    raw: &'a [f64],
    /// Increments with flagged cells smoothed over.
    filled: Vec<f64>,
    flagged: Vec<bool>,
    floor: f64,
}

impl Search<'_> {
    fn residuals(&self, width: usize) -> Vec<f64> {
        let mut residuals = of_cells(&self.filled, 0, self.filled.len(), width);
        residuals
            .iter_mut()
            .for_each(|residual| *residual = residual.abs());
        residuals
    }

    /// The largest residual of double cells that contain cell k or touch it.
    fn wide_round(wide: &[f64], k: usize) -> f64 {
        let n = wide.len();
        [k + n - 2, k + n - 1, k, k + 1]
            .iter()
            .fold(0.0, |m: f64, j| m.max(wide[j % n]))
    }

    /// Flags cells that look like jumps by the residuals of single and double cells; whether there were any.
    fn flag(&mut self, [narrow, wide]: &[Vec<f64>; 2]) -> bool {
        let n = self.filled.len();
        let noise = noise(narrow);
        let reach = NEIGHBOURS + 1;
        let is_jump = |k: usize| {
            let residual = narrow[k];
            // The fewest samples are 3, and the reach is 3.
            let around = (k + 3 * n - reach..=k + 3 * n + reach).map(|j| narrow[j % n]);
            !self.flagged[k]
                && residual > self.floor
                && residual > MIN_OUTLIER_DEVIATIONS * noise
                && residual > MIN_NARROW_OVER_WIDE * Self::wide_round(wide, k)
                && residual >= around.fold(0.0, f64::max)
        };
        let found: Vec<usize> = (0..n).filter(|&k| is_jump(k)).collect();
        for &k in &found {
            self.flagged[k] = true;
        }
        !found.is_empty()
    }

    /// Replaces the increments of flagged cells by the values that their neighbours predict.
    fn refill(&mut self) {
        let n = self.filled.len();
        for k in (0..n).filter(|&k| self.flagged[k]) {
            let clean = |distance: usize| !self.flagged[(k + distance) % n];
            let before = (1..n).find(|&j| clean(n - j)).unwrap_or(1);
            let after = (1..n).find(|&j| clean(j)).unwrap_or(1);
            let (left, right) = (self.raw[(k + n - before) % n], self.raw[(k + after) % n]);
            let share = before as f64 / (before + after) as f64;
            self.filled[k] = left + share * (right - left);
        }
        for k in (0..n).filter(|&k| self.flagged[k]) {
            if self.is_alone(k, NEIGHBOURS) {
                self.filled[k] -= of_cell(&self.filled, k, 1);
            }
        }
    }

    fn conclude(mut self, [narrow, wide]: &[Vec<f64>; 2]) -> Roughness {
        let n = self.filled.len();
        let hidden = (0..n)
            .filter(|&k| {
                narrow[k] > self.floor
                    && narrow[k] > MIN_NARROW_OVER_WIDE * Self::wide_round(wide, k)
            })
            .fold(0.0, |m: f64, k| m.max(narrow[k]));
        let mean = |values: &[f64]| values.iter().sum::<f64>() / n as f64;
        let variation: f64 = self.filled.iter().map(|d| d.abs()).sum();
        // Half as many double cells: their sum is what halves, stays or grows.
        let unresolved = mean(narrow) > self.floor
            && mean(narrow) > MAX_RESOLVED_RESIDUAL * variation
            && 2.0 * mean(narrow) > MIN_NARROW_OVER_WIDE * mean(wide);
        let cells: Vec<usize> = (0..n).filter(|&k| self.flagged[k]).collect();
        let jumps = cells.iter().map(|&k| self.jump(k)).collect();
        Roughness {
            jumps,
            hidden,
            unresolved,
        }
    }

    /// Whether no other cell as near as this is flagged.
    fn is_alone(&self, k: usize, distance: usize) -> bool {
        let n = self.flagged.len();
        (1..=distance).all(|j| !self.flagged[(k + j) % n] && !self.flagged[(k + n - j % n) % n])
    }

    /// The step at cell k, looked at with every, every second and every fourth sample.
    fn jump(&mut self, k: usize) -> Jump {
        let n = self.filled.len();
        let alone = self.is_alone(k, MIN_CELLS_BETWEEN_JUMPS);
        let smooth = std::mem::replace(&mut self.filled[k], self.raw[k]);
        let size = self.raw[k] - smooth;
        let stays = |width: usize, back: usize| {
            let residual = of_cell(&self.filled, (k + n - back) % n, width);
            (residual - size).abs() <= MAX_MISMATCH_OF_SIZES * size.abs()
        };
        let confirmed = alone
            && [1, 2, 4]
                .into_iter()
                .all(|width| (0..width).all(|back| stays(width, back)));
        self.filled[k] = smooth;
        Jump {
            cell: k,
            size,
            confirmed,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::signal::UNIT_ROUNDOFF;

    fn search(n: usize, x: impl Fn(f64) -> f64) -> Roughness {
        let row: Vec<f64> = (0..n).map(|k| x(k as f64 / n as f64)).collect();
        let next = |k: usize| row[(k + 1) % n];
        let increments: Vec<f64> = (0..n).map(|k| next(k) - row[k]).collect();
        let largest = row.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        find_jumps(&increments, 32.0 * UNIT_ROUNDOFF * largest)
    }

    #[test]
    fn a_jump_is_found_with_its_size_and_stays() {
        for n in [64, 100, 1024, 16384] {
            for size in [1.0, 0.1] {
                let found = search(n, |s| {
                    (TAU * s).sin() + if s < 0.7103 { 0.0 } else { size } - size * s
                });
                let cell = (0.7103 * n as f64).floor() as usize;
                // The closing cell jumps back by the ramp's step, that is not at all.
                assert_eq!(found.jumps.len(), 1, "{n} samples, {size}: {found:?}");
                let jump = found.jumps[0];
                assert!(jump.cell == cell && jump.confirmed, "{n} samples: {jump:?}");
                assert!(
                    (jump.size / size - 1.0).abs() < 0.02,
                    "{n} samples: {jump:?}"
                );
                assert!(!found.unresolved);
            }
        }
    }

    #[test]
    fn a_small_jump_near_a_large_one_is_found() {
        let found = search(4096, |s| {
            (TAU * s).cos() + f64::from(s > 0.3) + 1e-4 * f64::from(s > 0.302)
                - 1.0001 * f64::from(s > 0.8)
        });
        let cells: Vec<usize> = found.jumps.iter().map(|jump| jump.cell).collect();
        assert_eq!(cells, [1228, 1236, 3276]);
        assert!(found.jumps.iter().all(|jump| jump.confirmed));
    }

    #[test]
    fn kinks_steep_flanks_and_smooth_loops_are_no_jumps() {
        for n in [64, 256, 4096, 65536] {
            for phase in [0.0, 0.3, 0.7] {
                let at = 0.4 + phase / n as f64;
                let closing = (1.0 - 2.0 * at) / 0.1;
                let kink = search(n, |s| {
                    (TAU * s).sin() + (s - at).abs() - closing * (s - 0.9).max(0.0)
                });
                assert!(kink.jumps.is_empty(), "{n} samples: {kink:?}");
                for cells in [1.0, 2.0, 4.0] {
                    let width = cells / n as f64;
                    let steep = search(n, |s| {
                        ((s - at) / width).tanh() - ((s - 0.9) / width).tanh()
                    });
                    assert!(
                        steep.jumps.iter().all(|jump| !jump.confirmed),
                        "{n}: {steep:?}"
                    );
                }
            }
            let smooth = search(n, |s| (TAU * s).sin() + 0.3 * (3.0 * TAU * s + 1.0).cos());
            assert!(smooth.jumps.is_empty() && !smooth.unresolved && smooth.hidden < 1e-14);
        }
    }

    #[test]
    fn noise_hides_jumps_of_its_own_size() {
        let noise = |s: f64| ((s * 12.9898).sin() * 43758.5453).fract();
        let found = search(4096, |s| (TAU * s).sin() + 1e-8 * noise(s));
        assert!(found.jumps.is_empty() && !found.unresolved, "{found:?}");
        assert!((1e-8..1e-7).contains(&found.hidden), "{}", found.hidden);
        assert!(search(4096, |s| (TAU * s).sin() + noise(s)).unresolved);
    }

    /// The increments of a row with jumps, kinks and steep stretches that are not jumps, few enough for no noise to be known.
    fn rough(n: usize, seed: u64) -> Vec<f64> {
        let mut state = seed;
        let mut random = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let (phase, kink, jump) = (random(), random(), [random(), random(), random()]);
        let width = 3.0 * random() / n as f64;
        let at = |s: f64| {
            let jumps: f64 = (jump.iter().enumerate())
                .map(|(i, at)| 0.3f64.powi(i as i32) * f64::from(s > *at))
                .sum();
            (TAU * (s + phase)).sin() + (s - kink).abs() + ((s - phase) / width).tanh() + jumps
        };
        let x = |k: usize| at((k % n) as f64 / n as f64);
        (0..n).map(|k| x(k + 1) - x(k)).collect()
    }

    fn assert_same(
        found: &Roughness,
        expected: &Roughness,
        cell: impl Fn(usize) -> usize,
        sign: f64,
    ) {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert_eq!(found.unresolved, expected.unresolved);
        assert!(
            near(found.hidden, expected.hidden),
            "{found:?}, {expected:?}"
        );
        let mut jumps = expected.jumps.clone();
        jumps
            .iter_mut()
            .for_each(|jump| jump.cell = cell(jump.cell));
        jumps.sort_by_key(|jump| jump.cell);
        assert_eq!(found.jumps.len(), jumps.len(), "{found:?}, {expected:?}");
        for (found, expected) in found.jumps.iter().zip(jumps) {
            assert_eq!(
                (found.cell, found.confirmed),
                (expected.cell, expected.confirmed)
            );
            assert!(
                near(found.size, sign * expected.size),
                "{found:?}, {expected:?}"
            );
        }
    }

    #[test]
    fn where_the_loop_begins_and_which_way_it_goes_change_nothing() {
        let mut jumps = [0; 2];
        for seed in 0..300 {
            // Noise is estimated from groups of 16 cells: these have none, or whole ones.
            let (n, step) = [(6 + seed % 10, 1), (64, 16)][usize::from(seed % 3 == 0)];
            let increments = rough(n, seed as u64);
            let expected = find_jumps(&increments, 1e-14);
            for jump in &expected.jumps {
                jumps[usize::from(jump.confirmed)] += 1;
            }
            for start in (step..n).step_by(step) {
                let mut rotated = increments.clone();
                rotated.rotate_left(start);
                let found = find_jumps(&rotated, 1e-14);
                assert_same(&found, &expected, |cell| (cell + n - start) % n, 1.0);
            }
            let reversed: Vec<f64> = increments.iter().rev().map(|d| -d).collect();
            let found = find_jumps(&reversed, 1e-14);
            assert_same(&found, &expected, |cell| n - 1 - cell, -1.0);
        }
        assert!(jumps.iter().all(|&count| count > 20), "{jumps:?}");
    }

    /// Flagged cells, refilled where `increment` is the increment of the others.
    fn refilled(n: usize, flagged: &[usize], increment: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut raw: Vec<f64> = (0..n).map(increment).collect();
        let mut search_flagged = vec![false; n];
        for &k in flagged {
            raw[k] = 1000.0;
            search_flagged[k] = true;
        }
        let mut search = Search {
            filled: raw.clone(),
            raw: &raw,
            flagged: search_flagged,
            floor: 0.0,
        };
        search.refill();
        flagged.iter().map(|&k| search.filled[k]).collect()
    }

    #[test]
    fn cells_next_to_each_other_lie_on_a_line_between_their_neighbours() {
        assert_eq!(
            refilled(12, &[5, 6, 7], |k| 2.0 + k as f64),
            [7.0, 8.0, 9.0]
        );
        // Round the end of the loop.
        let line = |k: usize| ((k + 6) % 12) as f64;
        assert_eq!(refilled(12, &[10, 11, 0, 1], line), [4.0, 5.0, 6.0, 7.0]);
        // Two cells apart, each is next to one that is flagged.
        assert_eq!(refilled(12, &[4, 6], |k| (k * k) as f64), [17.0, 37.0]);
    }

    #[test]
    fn a_cell_alone_is_what_a_polynomial_has_there() {
        let cubic = |k: usize| (k as f64 - 3.0).powi(3) - (k * k) as f64;
        for k in 2..9 {
            let filled = refilled(12, &[k], cubic)[0];
            assert!((filled - cubic(k)).abs() < 1e-12, "{k}: {filled}");
        }
        // Three cells apart, neither disturbs the other less.
        let [a, b] = refilled(12, &[4, 7], |k| (k * k) as f64)[..] else {
            unreachable!()
        };
        assert!(
            (a - 16.0).abs() < 1e-12 && (b - 49.0).abs() < 1e-12,
            "{a} {b}"
        );
    }

    #[test]
    fn samples_that_jump_everywhere_show_no_shape() {
        let zigzag: Vec<f64> = (0..15).map(|k| f64::from([3, -5, 2][k % 3])).collect();
        let found = find_jumps(&zigzag, 1e-14);
        assert!(found.unresolved && found.jumps.is_empty(), "{found:?}");
    }

    #[test]
    fn noise_is_resolved_as_long_as_it_is_fine() {
        let noise = |s: f64| ((s * 12.9898).sin() * 43758.5453).fract();
        for (size, unresolved) in [(1e-7, false), (1e-2, true)] {
            let found = search(4096, |s| (TAU * s).sin() + size * noise(s));
            assert!(found.jumps.is_empty(), "{size}: {found:?}");
            assert_eq!(found.unresolved, unresolved, "{size}");
        }
    }
}

//! Jumps of a coordinate that is known at samples only.
//!
//! A cell is *flagged* where its residual stands out from those nearby and does not grow with
//! the width of the cells. Flagged cells are refilled with what their neighbours predict and the search goes
//! on, so that a large jump does not hide a small one. A flagged cell is *confirmed* as a jump if the
//! step has one size over cells of one, two and four spacings.

use super::increments::{Increments, STENCILS, Stencil};

/// A cell in which a coordinate jumps, as far as samples can tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Jump {
    /// From sample `cell` to sample `cell + 1`, round the loop.
    pub cell: usize,
    /// How far.
    pub size: f64,
    /// Whether it stays under refinement, from every fourth to every sample.
    pub confirmed: bool,
}

/// What the samples of one coordinate show.
#[derive(Clone, Debug, Default)]
pub(super) struct Roughness {
    /// Flagged cells, in their order along the loop.
    pub jumps: Vec<Jump>,
    /// The largest residual that neither grows like a smooth one nor stands out: a jump of this size
    /// would not be noticed.
    pub hidden: f64,
    /// Whether the samples are too few, or too noisy, to show any shape at all.
    pub unresolved: bool,
}

/// A residual stands out if it is this many times the median of those nearby: noise with a normal
/// distribution reaches 6.7 standard deviations with a chance of 2e-11.
const OUTSTANDING: f64 = 10.0;

/// A residual that is more than this part of those of cells twice as wide has not halved. At a kink the
/// ratio is a half at most.
const STAYS: f64 = 0.75;

/// Sizes of a jump at different spacings agree to this part.
const AGREES: f64 = 0.25;

/// A jump is confirmed only if no other is nearer than this many cells.
const APART: usize = 4;

/// Cells whose median residual is a measure of the local noise.
const NEIGHBOURHOOD: usize = 32;

/// Residuals smaller than this part of the coordinate's variation leave it resolved, even if they are noise.
const FINE: f64 = 1e-5;

/// Finds the jumps of a coordinate.
pub(super) fn find_jumps(increments: &Increments) -> Roughness {
    let n = increments.values.len();
    let mut search = Search {
        raw: &increments.values,
        filled: increments.values.clone(),
        flagged: vec![false; n],
        floor: increments.floor,
    };
    for stencil in STENCILS {
        // Each turn uncovers what larger jumps nearby had covered.
        while search.flag(stencil) {
            search.refill(stencil);
            if search.flagged.iter().filter(|&&f| f).count() > n / 4 {
                return Roughness {
                    unresolved: true,
                    ..Roughness::default()
                };
            }
        }
    }
    search.conclude()
}

struct Search<'a> {
    raw: &'a [f64],
    /// Increments with flagged cells smoothed over.
    filled: Vec<f64>,
    flagged: Vec<bool>,
    floor: f64,
}

impl Search<'_> {
    fn residuals(&self, stencil: Stencil, width: usize) -> Vec<f64> {
        (0..self.filled.len())
            .map(|k| stencil.residual(&self.filled, k, width).abs())
            .collect()
    }

    /// The largest residual of double cells that contain cell k or touch it.
    fn wide_round(wide: &[f64], k: usize) -> f64 {
        let n = wide.len();
        [k + n - 2, k + n - 1, k, k + 1]
            .iter()
            .fold(0.0, |m: f64, j| m.max(wide[j % n]))
    }

    /// Flags cells that look like jumps; whether there were any.
    fn flag(&mut self, stencil: Stencil) -> bool {
        let n = self.filled.len();
        let narrow = self.residuals(stencil, 1);
        let wide = self.residuals(stencil, 2);
        let noise = local_medians(&narrow);
        let reach = stencil.reach() + 1;
        let is_jump = |k: usize| {
            let residual = narrow[k];
            // The fewest samples are 3, and the reach is 4 at most.
            let around = (k + 4 * n - reach..=k + 4 * n + reach).map(|j| narrow[j % n]);
            !self.flagged[k]
                && residual > self.floor
                && residual > OUTSTANDING * noise[k / NEIGHBOURHOOD]
                && residual > STAYS * Self::wide_round(&wide, k)
                && residual >= around.fold(0.0, f64::max)
        };
        let found: Vec<usize> = (0..n).filter(|&k| is_jump(k)).collect();
        for &k in &found {
            self.flagged[k] = true;
        }
        !found.is_empty()
    }

    /// Replaces the increments of flagged cells by what their neighbours predict.
    fn refill(&mut self, stencil: Stencil) {
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
            let reach = stencil.reach();
            if (1..=reach).all(|j| !self.flagged[(k + j) % n] && !self.flagged[(k + n - j) % n]) {
                self.filled[k] = stencil.predict(&self.filled, k);
            }
        }
    }

    fn conclude(mut self) -> Roughness {
        let n = self.filled.len();
        let shortest = STENCILS[0];
        let (narrow, wide) = (self.residuals(shortest, 1), self.residuals(shortest, 2));
        let hidden = (0..n)
            .filter(|&k| narrow[k] > self.floor && narrow[k] > STAYS * Self::wide_round(&wide, k))
            .fold(0.0, |m: f64, k| m.max(narrow[k]));
        let mean = |values: &[f64]| values.iter().sum::<f64>() / n as f64;
        let variation: f64 = self.filled.iter().map(|d| d.abs()).sum();
        // Half as many double cells: their sum is what halves, stays or grows.
        let unresolved = mean(&narrow) > self.floor
            && mean(&narrow) > FINE * variation
            && 2.0 * mean(&narrow) > STAYS * mean(&wide);
        let cells: Vec<usize> = (0..n).filter(|&k| self.flagged[k]).collect();
        let jumps = cells.iter().map(|&k| self.jump(k)).collect();
        Roughness {
            jumps,
            hidden,
            unresolved,
        }
    }

    /// The step at cell k, looked at with every, every second and every fourth sample.
    fn jump(&mut self, k: usize) -> Jump {
        let n = self.filled.len();
        let alone =
            (1..=APART).all(|j| !self.flagged[(k + j) % n] && !self.flagged[(k + n - j) % n]);
        let smooth = std::mem::replace(&mut self.filled[k], self.raw[k]);
        let size = self.raw[k] - smooth;
        let confirmed = alone
            && STENCILS.into_iter().any(|stencil| {
                let stays = |width: usize, back: usize| {
                    let residual = stencil.residual(&self.filled, (k + n - back) % n, width);
                    (residual - size).abs() <= AGREES * size.abs()
                };
                [1, 2, 4]
                    .into_iter()
                    .all(|width| (0..width).all(|back| stays(width, back)))
            });
        self.filled[k] = smooth;
        Jump {
            cell: k,
            size,
            confirmed,
        }
    }
}

/// The median of the values in each stretch of [`NEIGHBOURHOOD`] cells and the two beside it.
fn local_medians(values: &[f64]) -> Vec<f64> {
    let n = values.len();
    let mut window = Vec::with_capacity(3 * NEIGHBOURHOOD);
    (0..n.div_ceil(NEIGHBOURHOOD))
        .map(|block| {
            window.clear();
            let first = block * NEIGHBOURHOOD + n - NEIGHBOURHOOD.min(n);
            let width = (3 * NEIGHBOURHOOD).min(n);
            window.extend((first..first + width).map(|k| values[k % n]));
            let middle = window.len() / 2;
            *window.select_nth_unstable_by(middle, f64::total_cmp).1
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn search(n: usize, x: impl Fn(f64) -> f64) -> Roughness {
        let row: Vec<f64> = (0..n).map(|k| x(k as f64 / n as f64)).collect();
        find_jumps(&Increments::new(&row, 0.0, f64::EPSILON / 2.0))
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
}

//! What samples say of a jump in one of their cells.
//!
//! The *residual* of a cell is its increment less what the increments on both sides predict: the step that is
//! missing between two smooth functions. With cells twice as wide it grows 32-fold where the coordinate is smooth,
//! twofold at a kink, and not at all at a jump.

use multiversion::multiversion;

use super::limits::{
    MAX_ROUNDINGS_OF_RESIDUAL, MAX_SUSPECTS, MIN_NARROW_OVER_WIDE, MIN_OUTLIER_DEVIATIONS,
};
use crate::signal::UNIT_ROUNDOFF;

/// Which coordinate of a degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Coordinate {
    Q,
    P,
}

/// A cell in which a coordinate looks discontinuous.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Suspect {
    pub dof: usize,
    pub coordinate: Coordinate,
    /// From sample `cell` to sample `cell + 1`, round the loop.
    pub cell: usize,
    /// Size of the residual there.
    pub size: f64,
    /// Standard deviation of the residuals' noise.
    pub noise: f64,
}

impl Suspect {
    /// Whether a jump of this size stands out of the noise.
    pub fn stands_out(&self, jump: f64) -> bool {
        jump > MIN_OUTLIER_DEVIATIONS * self.noise
    }
}

/// Keeps the most suspicious cells, those that stand out most first.
pub(crate) fn most_outstanding(found: &mut Vec<Suspect>) {
    // A stable sort: equals stay in the order of the degrees of freedom.
    let over_noise = |suspect: &Suspect| suspect.size / suspect.noise;
    found.sort_by(|a, b| over_noise(b).total_cmp(&over_noise(a)));
    found.truncate(MAX_SUSPECTS);
}

/// Samples that are taken in at once.
pub(crate) const GROUP: usize = 16;

/// Samples before a group that its residuals need.
pub(crate) const REACH: usize = 10;

/// A group of samples and those before it.
pub(crate) type Window = [f64; REACH + GROUP];

/// The largest residual of one coordinate round the loop, from samples that pass by in groups.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Residuals {
    largest: f64,
    /// The cell of the largest.
    cell: usize,
    /// The largest from every second sample.
    largest_wide: f64,
    /// Sum of the [`undisturbed`] residuals of full groups.
    undisturbed: f64,
}

impl Residuals {
    /// The residual of a row, at least a group long, that gains `gain` round the loop. Also returns the number of groups.
    pub fn of(row: &[f64], gain: f64) -> (Self, usize) {
        let mut residuals = Residuals::default();
        let taken = add_groups(&mut residuals, row, 0);
        // Once more round the loop, so that groups are full and have what comes before them.
        let start = taken * GROUP;
        let ends: [f64; REACH + 2 * GROUP] = round_end(row, start, gain);
        let others = (row.len() - start).div_ceil(GROUP);
        add_groups(&mut residuals, &ends[..REACH + others * GROUP], start);
        (residuals, taken + others)
    }

    /// Takes in `count` samples of a group, of which the first is sample `next` of the loop.
    #[inline(always)]
    pub fn add(&mut self, x: &Window, next: usize, count: usize) {
        let (mut narrow, mut wide) = ([0.0; GROUP], [0.0; GROUP]);
        for k in 0..GROUP {
            let at = |back: usize| x[REACH + k - back];
            narrow[k] = residual([at(5), at(4), at(3), at(2), at(1), at(0)]).abs();
        }
        for k in 0..GROUP {
            let at = |back: usize| x[REACH + k - back];
            wide[k] = residual([at(10), at(8), at(6), at(4), at(2), at(0)]).abs();
        }
        narrow[count..].fill(0.0);
        wide[count..].fill(0.0);
        let largest = most(&narrow);
        if largest > self.largest {
            let lane = narrow.iter().position(|&v| v == largest).unwrap_or(0);
            (self.largest, self.cell) = (largest, next + lane - 3);
        }
        self.largest_wide = self.largest_wide.max(most(&wide));
        if count == GROUP {
            self.undisturbed += undisturbed(&narrow);
        }
    }

    /// The cell that looks discontinuous, if one does, after one revolution of `samples` samples in this number of full
    /// `groups`, none of which is larger than `magnitude`.
    pub fn suspect(
        &self,
        dof: usize,
        coordinate: Coordinate,
        [samples, groups]: [usize; 2],
        magnitude: f64,
    ) -> Option<Suspect> {
        let suspect = Suspect {
            dof,
            coordinate,
            cell: self.cell % samples,
            size: self.largest,
            noise: deviation(self.undisturbed, groups),
        };
        let suspicious = self.largest > rounding(UNIT_ROUNDOFF * magnitude)
            && self.largest > MIN_NARROW_OVER_WIDE * self.largest_wide
            && suspect.stands_out(self.largest);
        suspicious.then_some(suspect)
    }
}

/// Adds the whole groups of samples that have those before them in `row`, which begins at sample `first` of the loop; how many.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn add_groups(residuals: &mut Residuals, row: &[f64], first: usize) -> usize {
    let mut groups = 0;
    for window in row.windows(REACH + GROUP).step_by(GROUP) {
        if let Some(window) = window.first_chunk() {
            residuals.add(window, first + groups * GROUP + REACH, GROUP);
            groups += 1;
        }
    }
    groups
}

/// Samples from `start` on, round the end of a row that gains `gain` there.
pub(super) fn round_end<const COUNT: usize>(row: &[f64], start: usize, gain: f64) -> [f64; COUNT] {
    let samples = row.len();
    let at = |k: usize| row[k % samples] + gain * (k / samples) as f64;
    std::array::from_fn(|k| at(start + k))
}

/// The largest, by halves.
#[inline(always)]
fn most(values: &[f64; GROUP]) -> f64 {
    let mut values = *values;
    let mut half = GROUP / 2;
    while half > 0 {
        for k in 0..half {
            let (a, b) = (values[k], values[k + half]);
            values[k] = if a > b { a } else { b };
        }
        half /= 2;
    }
    values[0]
}

/// Whether a cell of a row that does not wind may look discontinuous: its residual stands out of rounding, and is not smaller than
/// those of the double cells around it, as [`find_jumps`](super::find_jumps) has it. Residuals below `floor` are rounding.
pub(super) fn may_jump(row: &[f64], floor: f64) -> bool {
    let taken = row.len().saturating_sub(WIDE_REACH) / GROUP;
    if any_may_jump(&row[..(taken * GROUP + WIDE_REACH).min(row.len())], floor) {
        return true;
    }
    // The others go round the end of the row.
    const ENDS: usize = 3 * GROUP + WIDE_REACH;
    let ends: [f64; ENDS] = round_end(row, taken * GROUP, 0.0);
    let others = (row.len() - taken * GROUP).div_ceil(GROUP);
    any_may_jump(&ends[..others * GROUP + WIDE_REACH], floor)
}

/// Samples before those of a group that the double cells around its cells reach, and after them.
const WIDE_REACH: usize = 13;

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn any_may_jump(row: &[f64], floor: f64) -> bool {
    /// Cells whose residuals are computed together. All are stored before they are compared with those of their neighbours: a processor
    /// waits if it loads a vector whose numbers it has just stored one by one.
    const AT_ONCE: usize = 16 * GROUP;
    // Rounding in another order changes a residual by less than half of the floor. Residuals are not divided yet.
    let slack = 0.5 * DIVISOR_OF_RESIDUAL * floor;
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let (mut narrow, mut wide) = ([0.0; AT_ONCE], [0.0; AT_ONCE + 3]);
    let cells = row.len().saturating_sub(WIDE_REACH);
    for first in (0..cells).step_by(AT_ONCE) {
        let count = AT_ONCE.min(cells - first);
        let narrow = &mut narrow[..count];
        for (residual, x) in narrow.iter_mut().zip(row[first + 4..].windows(6)) {
            *residual = undivided([x[0], x[1], x[2], x[3], x[4], x[5]]).abs();
        }
        // Most cells are smooth, and their double cells need not be looked at.
        let stands_out = |narrow: &f64| *narrow > slack;
        let standing_out =
            (narrow.iter()).fold(0, |any, narrow| any | u64::from(stands_out(narrow)));
        if standing_out == 0 {
            continue;
        }
        // Double cells around each of the cells.
        let wide = &mut wide[..count + 3];
        for (residual, x) in wide.iter_mut().zip(row[first..].windows(11)) {
            *residual = undivided([x[0], x[2], x[4], x[6], x[8], x[10]]).abs();
        }
        let mut jumps = 0;
        for (narrow, wide) in narrow.iter().zip(wide.windows(4)) {
            let around = larger(larger(wide[0], wide[1]), larger(wide[2], wide[3]));
            let stays = narrow + slack > MIN_NARROW_OVER_WIDE * around;
            jumps |= u64::from(stands_out(narrow) & stays);
        }
        if jumps != 0 {
            return true;
        }
    }
    false
}

/// The sum of the residuals of a group that a jump leaves alone: it disturbs those of five cells, so that of cells four
/// apart the least counts.
#[inline(always)]
fn undisturbed(residuals: &[f64; GROUP]) -> f64 {
    let least = |a: f64, b: f64| if a < b { a } else { b };
    let of_four = |k: usize| {
        let of = |j: usize| residuals[k + 4 * j];
        least(least(of(0), of(1)), least(of(2), of(3)))
    };
    (0..GROUP / 4).map(of_four).sum()
}

/// The standard deviation of the noise of residuals, from the sum of the undisturbed ones in `groups` groups.
fn deviation(undisturbed: f64, groups: usize) -> f64 {
    /// The expected least of four absolute values of a standard normal distribution, ∫ erfc(x/√2)⁴ dx.
    const LEAST_OF_FOUR: f64 = 0.262;
    undisturbed / (LEAST_OF_FOUR * (groups.max(1) * (GROUP / 4)) as f64)
}

/// The noise of some absolute residuals.
pub(super) fn noise(residuals: &[f64]) -> f64 {
    let (groups, _) = residuals.as_chunks();
    deviation(groups.iter().map(undisturbed).sum(), groups.len())
}

/// Residuals no larger than this are rounding of values below `magnitude`, each by a part `unit_roundoff` of it.
pub(crate) fn rounding(rounding_error: f64) -> f64 {
    MAX_ROUNDINGS_OF_RESIDUAL * rounding_error
}

/// Increments on either side that predict that of a cell.
pub(super) const NEIGHBOURS: usize = 2;

/// The step from x_2 to x_3 that the values of polynomials up to the fourth degree do not explain.
#[inline(always)]
fn residual(x: [f64; 6]) -> f64 {
    undivided(x) / DIVISOR_OF_RESIDUAL
}

/// Six times the residual.
#[inline(always)]
fn undivided(x: [f64; 6]) -> f64 {
    10.0 * (x[3] - x[2]) - 5.0 * (x[4] - x[1]) + (x[5] - x[0])
}

const DIVISOR_OF_RESIDUAL: f64 = 6.0;

/// The residual of the cell that consists of `width` cells from `first` on, from increments round the loop.
pub(super) fn of_cell(increments: &[f64], first: usize, width: usize) -> f64 {
    of_cells(increments, first, 1, width)[0]
}

/// The residuals of `count` cells that consist of `width` cells from `first` on, from `first` + 1 on, and so forth.
pub(super) fn of_cells(increments: &[f64], first: usize, count: usize, width: usize) -> Vec<f64> {
    let reach = NEIGHBOURS * width;
    let n = increments.len();
    let start = (first + reach * n - reach) % n;
    // With what they need beyond the ends, so that nothing is wrapped for a cell.
    let len = count - 1 + 2 * reach + width;
    let mut row = Vec::with_capacity(len);
    let mut from = start;
    while row.len() < len {
        let to = n.min(from + len - row.len());
        row.extend_from_slice(&increments[from..to]);
        from = 0;
    }
    let wide: Vec<f64> = row.windows(width).map(|cells| cells.iter().sum()).collect();
    let [a, b, c, d, e] = std::array::from_fn(|cell| &wide[cell * width..][..count]);
    let residual = |k: usize| c[k] - 4.0 / 6.0 * (b[k] + d[k]) + 1.0 / 6.0 * (a[k] + e[k]);
    (0..count).map(residual).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_its_residual_and_polynomials_have_none() {
        let step = |x: f64| if x > 0.0 { 0.7 } else { 0.0 };
        let at: [f64; 6] = std::array::from_fn(|k| k as f64 - 2.5);
        assert!((residual(at.map(step)) - 0.7).abs() < 1e-15);
        for power in 0..5 {
            assert!(residual(at.map(|x| x.powi(power))).abs() < 1e-13);
        }
        assert!((residual(at.map(|x| x.powi(5))) - 20.0).abs() < 1e-12);
    }

    #[test]
    fn rows_are_taken_in_with_what_follows_their_end() {
        for n in [16_usize, 17, 25, 26, 40, 64, 99] {
            let row: Vec<f64> = (0..n).map(|k| (1.3 * (k * k) as f64).sin()).collect();
            let (found, groups) = Residuals::of(&row, 0.5);
            assert_eq!(groups, n.div_ceil(GROUP));
            let x = |k: usize| row[k % n] + 0.5 * (k / n) as f64;
            let largest = |width: usize| {
                let of_cell = |k: usize| residual([0, 1, 2, 3, 4, 5].map(|j| x(k + j * width)));
                // Groups that are filled up continue beyond the turn.
                let cells = REACH - 5 * width..groups * GROUP + REACH - 5 * width;
                cells.map(of_cell).fold(0.0, |m: f64, v| m.max(v.abs()))
            };
            assert_eq!(
                [found.largest, found.largest_wide],
                [1, 2].map(largest),
                "{n}"
            );
        }
    }

    #[test]
    fn rows_that_may_not_jump_have_no_jumps() {
        let mut skipped = 0;
        for seed in 0..400 {
            let random = |k: usize| (0.137 + 0.618_034 * (7 * seed + 31 * k) as f64).fract();
            let n = [7, 16, 29, 30, 45, 64, 200, 1024][seed % 8];
            let (jump, kink) = ([0.0, 1e-12, 1e-3][seed % 3], [0.0, 1e-2][seed / 3 % 2]);
            let at = |k: usize| {
                let s = k as f64 / n as f64;
                let bend = (s - random(1)).abs().min(1.0 - (s - random(1)).abs());
                let phase = std::f64::consts::TAU * (s + random(2));
                phase.sin() + kink * bend + jump * f64::from(s > random(3))
            };
            let row: Vec<f64> = (0..n).map(at).collect();
            let floor = rounding(UNIT_ROUNDOFF * 1.5);
            let increments: Vec<f64> = (0..n).map(|k| row[(k + 1) % n] - row[k]).collect();
            let found = crate::breaks::find_jumps(&increments, floor);
            if may_jump(&row, floor) {
                continue;
            }
            skipped += 1;
            assert!(found.jumps.is_empty(), "{n}, {jump}, {kink}: {found:?}");
        }
        assert!(skipped > 150, "{skipped}");
    }

    #[test]
    fn residuals_grow_with_the_width_of_cells_as_theory_says() {
        let growth = |n: usize, x: &dyn Fn(f64) -> f64| {
            let at = |k: usize| x((k % n) as f64 / n as f64);
            let increments: Vec<f64> = (0..n).map(|k| at(k + 1) - at(k)).collect();
            let largest = |width: usize| {
                let all = of_cells(&increments, 0, n, width).into_iter();
                all.fold(0.0, |m: f64, v| m.max(v.abs()))
            };
            largest(2) / largest(1)
        };
        let smooth = growth(100, &|s| (std::f64::consts::TAU * s).sin());
        assert!((smooth / 32.0 - 1.0).abs() < 0.03, "{smooth}");
        // Twofold, or more where the kink lies off the middle of the wide cells.
        let kinked = growth(512, &|s| (s - 0.3).abs() - 2.0 * (s - 0.8).max(0.0));
        assert!((1.5..4.0).contains(&kinked), "{kinked}");
        let broken = growth(512, &|s| f64::from(s > 0.3) - f64::from(s > 0.8));
        assert!((broken - 1.0).abs() < 1e-15, "{broken}");
    }
}

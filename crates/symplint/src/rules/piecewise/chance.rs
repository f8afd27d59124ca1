//! Features of the loop that were met by chance.
//!
//! What is narrower than the distance of equispaced samples is met where one of them, or a state of a piece, happens
//! to fall into it. Of two alike, where the loop passes one place of phase space twice, one may be found and the
//! other missed. A symplectic map keeps what they contribute to the integral in all, so what those that were found
//! contribute in all, and do not cancel, is doubtful: others that were missed may cancel it.
//!
//! Kinks and jumps are narrow as well, but nothing is left to chance there: the states on one side do not continue
//! those on the other, and any piece across them shows it. A feature is met by chance where samples on both sides
//! continue each other as if there was nothing in between.

use super::lobatto::{LOBATTO, Values};
use super::path::Path;
use super::queue::Queue;
use super::scales::period;
use crate::signal::nearest;
use crate::state::Ensemble;
use crate::state::coordinate;

/// A piece this many distances long has two samples, so that one can tell how the loop goes on beyond it.
const CALM: f64 = 2.0;

/// So many distances may lie between two such pieces: a feature of one, and on both sides of it shorter pieces,
/// which halve from `CALM` down to its width, and are cut at a sample.
const WIDEST: f64 = 8.0;

/// Samples on either side that continue each other. Where they are a hundredth of the loop's smallest structure
/// apart, as many as these do so to round-off; more would amplify it.
const BESIDE: usize = 6;

/// A stretch of short pieces between two long ones.
pub(super) struct Stretch<'a> {
    queue: &'a Queue<'a>,
    seen: &'a Ensemble,
    /// Its pieces, in order.
    pieces: Vec<usize>,
    /// Where it begins, and where it ends: beyond 1 if that is in the next turn.
    pub ends: [f64; 2],
    /// Samples in the long pieces on the left and on the right, rising, counted on from one turn to the next.
    beside: [Vec<usize>; 2],
}

/// What a stretch contributes more than if there was nothing in it.
struct Departure {
    area: f64,
    /// How well that is known: as well as the samples on both sides continue each other.
    doubt: f64,
}

/// What the integral may be off because features were met by chance.
pub(super) fn doubt_of_chance(queue: &Queue<'_>) -> f64 {
    let (mut net, mut doubt) = (0.0, 0.0);
    for stretch in stretches(queue) {
        for i in 0..queue.coordinates.dof() {
            if let Some(departure) = stretch.by_chance(i) {
                net += departure.area;
                doubt += departure.doubt;
            }
        }
    }
    net.abs() + doubt
}

/// The stretches of the loop that may hold a feature met by chance.
pub(super) fn stretches<'a>(queue: &'a Queue<'_>) -> Vec<Stretch<'a>> {
    let Some(seen) = queue.seen else {
        return Vec::new();
    };
    let samples = seen.samples() as f64;
    let mut order: Vec<usize> = (0..queue.smooth.len())
        .filter(|&k| queue.smooth[k].piece.curve == 0)
        .collect();
    let piece = |k: usize| &queue.smooth[k].piece;
    order.sort_by(|&x, &y| piece(x).a.total_cmp(&piece(y).a));
    let is_calm = |k: usize| piece(k).length() * samples >= CALM;
    // From a long piece after a short one on, once round.
    let count = order.len();
    let first = (0..count).find(|&k| is_calm(order[k]) && !is_calm(order[(k + count - 1) % count]));
    let Some(first) = first else {
        return Vec::new();
    };
    let turn = |k: usize| if k < count { 0.0 } else { 1.0 };
    // Where long pieces begin and end, with the short ones that follow them.
    let mut calm: Vec<([f64; 2], Vec<usize>)> = Vec::new();
    let mut was_calm = false;
    for k in first..first + count {
        let index = order[k % count];
        let (a, b) = (piece(index).a + turn(k), piece(index).b + turn(k));
        match (is_calm(index), calm.last_mut()) {
            (true, Some(last)) if was_calm => last.0[1] = b,
            (true, _) => calm.push(([a, b], Vec::new())),
            (false, last) => last.expect("it begins calm").1.push(index),
        }
        was_calm = is_calm(index);
    }
    let again = calm[0].0.map(|s| s + 1.0);
    let after: Vec<[f64; 2]> = (calm.iter().skip(1).map(|calm| calm.0))
        .chain([again])
        .collect();
    let fitting = calm
        .into_iter()
        .zip(after)
        .filter(|((left, _), right)| (right[0] - left[1]) * samples <= WIDEST);
    fitting
        .map(|((left, pieces), right)| {
            let [from, to] = left.map(|s| s * samples);
            let last = to.floor() as usize;
            let on_the_left = (from.ceil() as usize).max((last + 1).saturating_sub(BESIDE))..=last;
            let [from, to] = right.map(|s| s * samples);
            let next = from.ceil() as usize;
            let on_the_right = next..=(to.floor() as usize).min(next + BESIDE - 1);
            Stretch {
                queue,
                seen,
                pieces,
                ends: [left[1], right[0]],
                beside: [on_the_left.collect(), on_the_right.collect()],
            }
        })
        .collect()
}

impl Stretch<'_> {
    /// The ends of its pieces, rising.
    pub fn edges(&self) -> Vec<f64> {
        let from = self.ends[0];
        let edge = |k: &usize| {
            let a = self.queue.smooth[*k].piece.a;
            if a < from { a + 1.0 } else { a }
        };
        (self.pieces.iter().map(edge))
            .chain([self.ends[1]])
            .collect()
    }

    /// Whether degree of freedom i has a feature here that was met by chance.
    pub fn is_by_chance(&self, i: usize) -> bool {
        self.by_chance(i).is_some()
    }

    /// Whether it reaches into the cell between sample k and the next.
    pub fn touches(&self, k: usize) -> bool {
        let samples = self.seen.samples();
        let [from, to] = self.ends.map(|s| s * samples as f64);
        [k, k + samples]
            .iter()
            .any(|&k| ((k + 1) as f64) > from && (k as f64) < to)
    }

    /// A row of samples, as many as are seen, as if there was nothing here.
    pub fn across(&self, row: &[f64], period: f64) -> Path {
        let [left, right] = &self.beside;
        self.path(row, period, &[&left[..], &right[..]].concat())
    }

    /// A row through some of its samples.
    fn path(&self, row: &[f64], period: f64, at: &[usize]) -> Path {
        let count = row.len();
        let origin = row[self.beside[0][0] % count];
        let points = at.iter().map(|k| {
            let value = origin + nearest(row[k % count] - origin, period);
            (*k as f64 / count as f64, value)
        });
        Path::through(points.collect())
    }

    /// What degree of freedom i contributes more than if there was nothing here, if that is
    /// more than what samples on both sides disagree on.
    fn by_chance(&self, i: usize) -> Option<Departure> {
        let [left, right] = &self.beside;
        let dof = self.seen.dof();
        let samples = self.seen.samples() as f64;
        let gap = [
            *left.last()? as f64 / samples,
            *right.first()? as f64 / samples,
        ];
        let weight = self.queue.coordinates.weight(i);
        let rows =
            [i, dof + i].map(|c| (coordinate(self.seen, c), period(self.queue.coordinates, c)));
        let [q, p] = rows.map(|(row, period)| self.across(row, period));
        let (across, above) = (q.values(self.ends), p.values(self.ends));
        // Momenta count from one of the stretch, so that all that a difference at its ends makes is small.
        let local = above[0];
        let smooth =
            weight * LOBATTO.area(&above.map(|v| v - local), &across.map(|v| v - across[0]));
        let area = self.area(i, local) - smooth;
        // How far the two sides are apart where they should meet, and what pieces may be off.
        let apart = |(row, period)| {
            let sides = [left, right].map(|at| self.path(row, period, at).values(gap));
            let apart = sides[0].iter().zip(&sides[1]).map(|(x, y)| (x - y).abs());
            apart.fold(0.0, f64::max)
        };
        let [off_q, off_p] = [i, dof + i].map(|c| self.allowance(c));
        let [off_q, off_p] = [off_q + apart(rows[0]), off_p + apart(rows[1])];
        let doubt = weight.abs() * (off_p * range(&q.values(gap)) + off_q * range(&p.values(gap)));
        (area.abs() > doubt).then_some(Departure { area, doubt })
    }

    /// What coordinate c of its pieces may be off.
    fn allowance(&self, c: usize) -> f64 {
        let pieces = self.pieces.iter().map(|&k| &self.queue.smooth[k].piece);
        let allowances = pieces.map(|piece| piece.allowance(c, &self.queue.scales));
        allowances.fold(0.0, f64::max)
    }

    /// ∫ (p − `reference`) dq over the stretch, its breaks closed by chords as far as they are known.
    fn area(&self, i: usize, reference: f64) -> f64 {
        let pieces = (self.pieces.iter())
            .map(|&k| &self.queue.smooth[k])
            .map(|piece| (piece.areas[i], piece.gains[i]));
        let [from, to] = self.ends;
        let inside = |s: f64| (from..=to).contains(&s) || (from..=to).contains(&(s + 1.0));
        let breaks = self.queue.breaks.iter();
        let chords = breaks
            .filter(|found| found.curve == 0 && inside(found.sides[0]))
            .filter_map(|found| Some((*found.areas.get(i)?, *found.jumps.get(i)?)));
        let (area, gain) = (pieces.chain(chords))
            .fold((0.0, 0.0), |sum, (area, gain)| (sum.0 + area, sum.1 + gain));
        let weight = self.queue.coordinates.weight(i);
        area + weight * (self.queue.scales.p_reference[i] - reference) * gain
    }
}

fn range(values: &Values) -> f64 {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max) - low
}

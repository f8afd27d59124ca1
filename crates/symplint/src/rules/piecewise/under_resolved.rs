//! Features of the loop that are narrower than the distance of its equispaced samples.
//!
//! They are found where a sample, or a state of a piece, happens to fall into one. Of two alike, where the loop passes
//! one point of phase space twice, one may be found and the other missed. A symplectic map conserves what they
//! contribute to the integral in all; so what those that were found contribute in all, and does not cancel, is a part
//! of the error.
//!
//! Kinks and jumps are narrow as well, but the states on one side do not continue those on the other, and any
//! piece across them shows it. A feature is under-resolved where the samples on both
//! sides of it continue each other as if there was nothing in between.
//!
//! Without this, bumps next to a kink and narrow jumps of which one is missed are called not symplectic (tests in
//! `traps/under_resolved.rs`).

use super::limits::{
    MAX_EXPONENT_OF_SPIKES, MAX_WIDTH_OF_FEATURE, MIN_LENGTH_OF_CALM_PIECE, NEIGHBOURING_SAMPLES,
};
use super::lobatto::{LOBATTO, NODES, Values};
use super::piece::SmoothPiece;
use super::refinement::Refinement;
use crate::error::Error;
use crate::rules::{LoopIntegral, Rule};
use crate::signal::{Barycentric, Extent, nearest};
use crate::state::{Ensemble, coordinate, in_parallel, period};

/// Operations for one degree of freedom of a stretch: five polynomials through a dozen samples, at the nodes of a piece.
const STRETCH_OPERATIONS: usize = 1 << 10;

/// A stretch of short pieces between two long ones.
struct Stretch<'a> {
    refinement: &'a Refinement<'a>,
    samples: &'a Ensemble,
    pieces: &'a [&'a SmoothPiece],
    /// Its start and its end: beyond 1 if that is in the next revolution.
    ends: [f64; 2],
    /// Samples in the long pieces on the left, then on the right, rising, counted on from one revolution to the next.
    beside: Vec<usize>,
    /// The samples on the left, on the right and on both sides where the two sides should meet.
    to_the_gap: [Continuation; 3],
    /// The samples on both sides, continued over the whole stretch.
    across: Continuation,
    /// How many are on the left.
    on_the_left: usize,
}

/// The polynomial through some samples of a row, at the nodes of a piece over an interval.
struct Continuation {
    /// For each sample, its weight in the value at each node.
    weights: Vec<Values>,
}

impl Continuation {
    /// The samples with these numbers, of `count` equispaced samples, determine the polynomial.
    fn new(at: &[usize], count: usize, [from, to]: [f64; 2]) -> Self {
        let s = at.iter().map(|&k| k as f64 / count as f64).collect();
        let polynomial = Barycentric::at(s);
        let node = |x: f64| polynomial.basis(from + 0.5 * (1.0 + x) * (to - from));
        let basis: [Vec<f64>; NODES] = LOBATTO.nodes.map(node);
        let of_sample = |k: usize| basis.each_ref().map(|weights| weights[k]);
        Continuation {
            weights: (0..at.len()).map(of_sample).collect(),
        }
    }

    /// Its values at the nodes.
    fn values(&self, samples: &[f64]) -> Values {
        let mut values = Values::default();
        for (weights, sample) in self.weights.iter().zip(samples) {
            for (value, weight) in values.iter_mut().zip(weights) {
                *value += weight * sample;
            }
        }
        values
    }
}

/// The error of the integral if features that were found have counterparts that were missed.
pub(super) fn under_resolved(refinement: &Refinement<'_>) -> f64 {
    let Some(samples) = refinement.samples else {
        return 0.0;
    };
    let count = samples.samples() as f64;
    let is_calm = |piece: &SmoothPiece| (piece.b - piece.a) * count >= MIN_LENGTH_OF_CALM_PIECE;
    let of_loop = refinement.smooth.iter().filter(|piece| piece.curve == 0);
    let mut pieces: Vec<&SmoothPiece> = of_loop.collect();
    pieces.sort_by(|x, y| x.a.total_cmp(&y.a));
    // From a long piece after a short one on, once round.
    let before = |k: usize| pieces[(k + pieces.len() - 1) % pieces.len()];
    let first = (0..pieces.len()).find(|&k| is_calm(pieces[k]) && !is_calm(before(k)));
    let Some(first) = first else {
        return 0.0;
    };
    pieces.rotate_left(first);
    let runs: Vec<&[&SmoothPiece]> = pieces.chunk_by(|x, y| is_calm(x) == is_calm(y)).collect();
    let ends = |k: usize| {
        let run = runs[k % runs.len()];
        let [from, to] = [run[0], run[run.len() - 1]];
        let revolution =
            |piece: &SmoothPiece| (k / runs.len()) as f64 + f64::from(piece.a < pieces[0].a);
        [from.a + revolution(from), to.b + revolution(to)]
    };
    let (mut net, mut error) = (0.0, 0.0);
    for k in (0..runs.len()).step_by(2) {
        let [left, right] = [ends(k), ends(k + 2)];
        if (right[0] - left[1]) * count > MAX_WIDTH_OF_FEATURE {
            continue;
        }
        let (ends, beside) = ([left[1], right[0]], beside(left, right, count));
        let stretch = Stretch::new(refinement, samples, runs[k + 1], ends, &beside);
        let dof = refinement.coordinates.dof();
        let of_dofs = in_parallel(0..dof, STRETCH_OPERATIONS, |i| stretch.excess(i));
        for (area, uncertainty) in of_dofs {
            if area.abs() > uncertainty {
                net += area;
                error += uncertainty;
            }
        }
    }
    f64::abs(net) + error
}

/// The samples next to a stretch in the long pieces on its left and on its right.
fn beside(left: [f64; 2], right: [f64; 2], count: f64) -> [Vec<usize>; 2] {
    let [from, to] = left.map(|s| s * count);
    let last = to.floor() as usize;
    let on_the_left = (from.ceil() as usize).max((last + 1).saturating_sub(NEIGHBOURING_SAMPLES));
    let [from, to] = right.map(|s| s * count);
    let next = from.ceil() as usize;
    let on_the_right = (to.floor() as usize).min(next + NEIGHBOURING_SAMPLES - 1);
    [
        (on_the_left..=last).collect(),
        (next..=on_the_right).collect(),
    ]
}

impl<'a> Stretch<'a> {
    fn new(
        refinement: &'a Refinement<'a>,
        samples: &'a Ensemble,
        pieces: &'a [&'a SmoothPiece],
        ends: [f64; 2],
        [left, right]: &[Vec<usize>; 2],
    ) -> Self {
        let count = samples.samples();
        let beside = [&left[..], &right[..]].concat();
        let gap =
            [left.last(), right.first()].map(|k| k.map_or(f64::NAN, |&k| k as f64 / count as f64));
        Stretch {
            refinement,
            samples,
            pieces,
            ends,
            to_the_gap: [left, right, &beside].map(|at| Continuation::new(at, count, gap)),
            across: Continuation::new(&beside, count, ends),
            on_the_left: left.len(),
            beside,
        }
    }

    /// What degree of freedom i contributes more than if there was nothing here, and how well that is known: as well
    /// as the samples on both sides continue each other.
    fn excess(&self, i: usize) -> (f64, f64) {
        let coordinates = self.refinement.coordinates;
        let weight = coordinates.weight(i);
        let count = self.samples.samples();
        let across = [i, self.samples.dof() + i].map(|c| {
            let (row, period) = (coordinate(self.samples, c), period(coordinates, c));
            let origin = row[self.beside[0] % count];
            let value = |&k: &usize| origin + nearest(row[k % count] - origin, period);
            let values: Vec<f64> = self.beside.iter().map(value).collect();
            let (left, right) = values.split_at(self.on_the_left);
            let [of_left, of_right, of_both] = &self.to_the_gap;
            let (left, right) = (of_left.values(left), of_right.values(right));
            let apart = left.iter().zip(right).map(|(x, y)| (x - y).abs());
            let range = Extent::of(&of_both.values(&values)).length();
            (
                self.across.values(&values),
                apart.fold(0.0, f64::max),
                range,
            )
        });
        let [(q, q_apart, q_range), (p, p_apart, p_range)] = across;
        // Momenta count from one of the stretch, so that all that a difference at its ends makes is small.
        let local = p[0];
        let smooth = weight * LOBATTO.area(&p.map(|v| v - local), &q.map(|v| v - q[0]));
        let uncertainty = weight.abs() * (p_apart * q_range + q_apart * p_range)
            + self.pieces.iter().map(|piece| piece.error).sum::<f64>();
        (self.area(i, local) - smooth, uncertainty)
    }

    /// ∫ (p − `reference`) dq over the stretch, its breaks closed by chords.
    fn area(&self, i: usize, reference: f64) -> f64 {
        let Stretch {
            refinement,
            ends: [from, to],
            ..
        } = *self;
        let (scales, coordinates) = (&refinement.scales, refinement.coordinates);
        let pieces = self
            .pieces
            .iter()
            .map(|piece| (piece.areas[i], piece.gains[i]));
        let inside = |s: f64| (from..=to).contains(&s) || (from..=to).contains(&(s + 1.0));
        let breaks = refinement.breaks.iter();
        let chords = breaks
            .filter(|found| found.curve == 0 && inside(found.sides[0]))
            .map(|found| found.chord(scales, coordinates))
            .map(|chord| (chord.areas[i], chord.gains[i]));
        let (area, gain) = (pieces.chain(chords))
            .fold((0.0, 0.0), |sum, (area, gain)| (sum.0 + area, sum.1 + gain));
        area + coordinates.weight(i) * (scales.p_reference[i] - reference) * gain
    }
}

/// The error of the integral of the pieces by the integral of the samples, and the Sobolev exponent that it shows.
///
/// If the samples show features that are narrower than their distance, another one may lie between two of them, and no
/// piece has met it: then the integral is known as the samples have it, and not at all where these do not tell. (Fourier
/// coefficients of many breaks look like those of spikes, but breaks are known.) A smooth loop may be known better by its
/// samples than by its pieces.
pub(super) fn beside_samples(
    refinement: &Refinement<'_>,
    value: f64,
    error: f64,
    broken: bool,
) -> Result<(Option<f64>, Option<f64>), Error> {
    let Some(samples) = refinement.samples else {
        return Ok((Some(error), None));
    };
    let rule = Rule::Pseudospectral;
    let of_samples = LoopIntegral::in_coordinates(samples, &rule, refinement.coordinates)?;
    let spiky = of_samples
        .regularity
        .is_some_and(|s| s < MAX_EXPONENT_OF_SPIKES);
    let apart = (of_samples.quadrature_error).map(|error| (of_samples.value - value).abs() + error);
    let error = match (spiky && !broken, refinement.breaks.is_empty()) {
        (true, _) => apart.map(|apart| error.max(apart)),
        (false, true) => Some(apart.map_or(error, |apart| error.min(apart))),
        (false, false) => Some(error),
    };
    Ok((error, of_samples.regularity))
}

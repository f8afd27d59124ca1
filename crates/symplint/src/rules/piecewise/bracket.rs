//! Closing in on a jump, one state at a time.

use super::lobatto::{SMOOTH, TERMS, evaluate, polynomial};
use super::piece::{Piece, Smooth};
use super::scales::period;
use crate::signal::nearest;
use crate::state::Coordinates;
use crate::state::Ensemble;
use crate::state::coordinate;

/// A jump between two points of a piece.
///
/// Left and right of it the coordinates, projected on the direction of the jump, are two smooth
/// functions: a point in between belongs to the one it is nearer to.
pub(super) struct Bracket {
    pub piece: Piece,
    /// The gap between two nodes that it was in at first.
    pub gap: [f64; 2],
    /// The ends: the jump is after `low` and not after `high`.
    pub low: f64,
    pub high: f64,
    /// Where the direction of the jump points, for each coordinate.
    pub direction: Vec<f64>,
    /// A state nearby, from which periodic positions are counted.
    pub reference: Vec<f64>,
    /// The function on the left, and what the right has more, over the piece.
    pub left: [f64; SMOOTH],
    pub jump: [f64; TERMS],
    /// Its values at `low` and `high`.
    pub projected: [f64; 2],
    /// The size that the jump should have.
    pub expected: f64,
    pub turns: usize,
    /// Whether its surroundings are looked at a second time.
    pub again: bool,
    /// The piece as it is.
    pub as_it_is: Box<Smooth>,
}

/// What a point in the bracket told.
pub(super) enum Closed {
    /// Go on.
    No,
    /// No doubles lie between the ends.
    Jump,
    /// The difference of the ends has shrunk: steep, not broken.
    Faded,
}

/// A jump keeps its size; a difference below this part of it is none.
const STAYS: f64 = 0.25;

/// Near s = 0 doubles lie far closer than anything of a loop does.
const NARROWEST: f64 = 1.0 / (1u128 << 64) as f64;

/// States that tell a jump from noise, half of them on each side of it: at a first look, and at a second one
/// if need be.
pub(super) const SURROUNDINGS: [usize; 2] = [6, 12];

/// Their distance: many doubles, so that rounding of s itself is none of the noise, and nothing of a loop.
const SPACING: f64 = 1.0 / (1u64 << 47) as f64;

/// Turns before a difference is expected to be that of the jump alone.
const PATIENCE: usize = 2;

impl Bracket {
    /// The point to evaluate next.
    pub fn middle(&self) -> f64 {
        self.low + 0.5 * (self.high - self.low)
    }

    /// Points close by, on the left and then on the right.
    pub fn surroundings(&self) -> impl Iterator<Item = f64> + '_ {
        let half = self.looks() / 2;
        (0..2 * half).map(move |k| {
            if k < half {
                (self.low - (half - 1 - k) as f64 * SPACING).max(self.piece.a)
            } else {
                (self.high + (k - half) as f64 * SPACING).min(self.piece.b)
            }
        })
    }

    /// How many they are.
    pub fn looks(&self) -> usize {
        SURROUNDINGS[usize::from(self.again)]
    }

    /// Whether what looked like a jump was a wrap: little of it is left, counted modulo the periods.
    pub fn wraps(&self, jump: f64) -> bool {
        jump < STAYS * (self.projected[1] - self.projected[0]).abs()
    }

    /// How far the projected values of the surroundings climb over the width of the bracket: that is no
    /// jump, but the distance of two doubles where the loop is steep.
    pub fn climb(&self, projected: &[f64]) -> f64 {
        let (left, right) = projected.split_at(projected.len() / 2);
        let steps = left.windows(2).chain(right.windows(2));
        let steepest = steps.fold(0.0, |m: f64, x| m.max((x[1] - x[0]).abs()));
        steepest * (self.high - self.low) / SPACING
    }

    /// How far values of surroundings scatter, on the side where they do so more.
    ///
    /// Second differences of a straight line vanish; those of noise are larger than it. Noise fills a side; a
    /// second jump close by spoils two of its four differences at most, and the second smallest counts. At the
    /// first look there is one alone.
    pub fn scatter(values: &[f64]) -> f64 {
        let (left, right) = values.split_at(values.len() / 2);
        let of_side = |side: &[f64]| {
            let mut bends: Vec<f64> = (side.windows(3))
                .map(|x| (x[0] - 2.0 * x[1] + x[2]).abs())
                .collect();
            bends.sort_by(f64::total_cmp);
            bends[usize::from(bends.len() > 1)]
        };
        of_side(left).max(of_side(right))
    }

    pub fn project(&self, states: &Ensemble, sample: usize, coordinates: &Coordinates) -> f64 {
        let terms = self.direction.iter().zip(&self.reference).enumerate();
        terms
            .map(|(c, (direction, reference))| {
                let difference = coordinate(states, c)[sample] - reference;
                direction * nearest(difference, period(coordinates, c))
            })
            .sum()
    }

    /// The same, counted from another sample.
    pub fn project_from(
        &self,
        states: &Ensemble,
        sample: usize,
        origin: usize,
        coordinates: &Coordinates,
    ) -> f64 {
        let terms = self.direction.iter().enumerate();
        terms
            .map(|(c, direction)| {
                let row = coordinate(states, c);
                direction * nearest(row[sample] - row[origin], period(coordinates, c))
            })
            .sum()
    }

    /// Halves the bracket, with the projected value at its middle.
    pub fn halve(&mut self, value: f64) -> Closed {
        let middle = self.middle();
        let x = self.piece.x(middle);
        let threshold = evaluate(&self.left, x) + 0.5 * polynomial(&self.jump, x);
        if value < threshold {
            (self.low, self.projected[0]) = (middle, value);
        } else {
            (self.high, self.projected[1]) = (middle, value);
        }
        self.turns += 1;
        let difference = (self.projected[1] - self.projected[0]).abs();
        if self.turns > PATIENCE && difference < STAYS * self.expected {
            return Closed::Faded;
        }
        let narrow = self.high - self.low < NARROWEST;
        if narrow || self.middle() <= self.low || self.middle() >= self.high {
            return Closed::Jump;
        }
        Closed::No
    }
}

//! Closing in on a jump, one state at a time.

use super::curves::coordinate;
use super::lobatto::{SMOOTH, TERMS, evaluate, polynomial};
use super::piece::Piece;
use super::scales::{nearest, period};
use crate::coordinates::Coordinates;
use crate::ensemble::Ensemble;

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

/// Turns before a difference is expected to be that of the jump alone.
const PATIENCE: usize = 2;

impl Bracket {
    /// The point to evaluate next.
    pub fn middle(&self) -> f64 {
        self.low + 0.5 * (self.high - self.low)
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
        if self.middle() <= self.low || self.middle() >= self.high {
            return Closed::Jump;
        }
        Closed::No
    }
}

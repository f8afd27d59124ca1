//! The states at all points of a piece, read by coordinate.

use std::ops::Range;

use super::limits::CHECKS;
use super::lobatto::{DEGREE, LOBATTO, NODES, POINTS};
use super::piece::Piece;
use crate::signal::nearest;
use crate::state::{Coordinates, period};

/// Coordinates of a state in one cache line.
const LINE: usize = 8;

/// The states of one stage at all points of a piece that are known.
pub(super) struct StageStates<'a> {
    coordinates: &'a Coordinates,
    points: [Option<&'a [f64]>; POINTS],
    /// The nodes after the checks: a check lies between two nodes.
    after: [usize; CHECKS.len()],
}

impl<'a> StageStates<'a> {
    pub fn new(piece: &'a Piece, coordinates: &'a Coordinates, stage: usize) -> Self {
        let points = std::array::from_fn(|k| Some(piece.images[k].as_ref()?.stage(stage)));
        let is_after = |j: &usize, x: f64| LOBATTO.nodes[*j] > x && piece.images[*j].is_some();
        let after = CHECKS.map(|x| (0..NODES).find(|j| is_after(j, x)).unwrap_or(DEGREE));
        StageStates {
            coordinates,
            points,
            after,
        }
    }

    /// Some coordinates, unwrapped. A cache line of each state is read at once.
    pub fn tiles(&self, coordinates: Range<usize>) -> impl Iterator<Item = [f64; POINTS]> {
        let end = coordinates.end;
        coordinates.step_by(LINE).flat_map(move |first| {
            let tile = first..end.min(first + LINE);
            let mut values = [[0.0; POINTS]; LINE];
            for (k, state) in self.points.iter().enumerate() {
                if let Some(state) = state {
                    let of_state = values.iter_mut().zip(&state[tile.clone()]);
                    of_state.for_each(|(values, value)| values[k] = *value);
                }
            }
            values
                .into_iter()
                .zip(tile)
                .map(|(values, c)| self.unwrapped(values, c))
        })
    }

    /// A coordinate, unwrapped.
    pub fn values(&self, c: usize) -> [f64; POINTS] {
        let value = |state: &Option<&[f64]>| state.map_or(0.0, |state| state[c]);
        self.unwrapped(self.points.each_ref().map(value), c)
    }

    fn unwrapped(&self, mut values: [f64; POINTS], c: usize) -> [f64; POINTS] {
        let period = period(self.coordinates, c);
        if period == 0.0 {
            return values;
        }
        // Periods added so far.
        let (mut last, mut added) = (None, 0.0);
        for (value, state) in values.iter_mut().zip(&self.points[..NODES]) {
            if state.is_none() {
                continue;
            }
            let step = last.map_or(0.0, |last| *value + added - last);
            let nearest = nearest(step, period);
            if nearest != step {
                added += nearest - step;
            }
            *value += added;
            last = Some(*value);
        }
        for (k, after) in (NODES..).zip(self.after) {
            values[k] = values[after] + nearest(values[k] - values[after], period);
        }
        values
    }
}

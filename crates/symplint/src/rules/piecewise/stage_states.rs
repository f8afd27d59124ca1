//! The states at all points of a piece, read by coordinate.

use std::ops::Range;

use super::limits::CHECKS;
use super::lobatto::{DEGREE, LOBATTO, NODES, POINTS};
use super::piece::Piece;
use crate::signal::nearest;
use crate::state::{CACHE_LINE, Coordinates, period};

/// The values of coordinates that share a cache line of each state, at all points.
pub(super) type Tile = [[f64; POINTS]; CACHE_LINE];

/// The coordinates of each tile.
pub(super) fn tiles(coordinates: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let end = coordinates.end;
    (coordinates.step_by(CACHE_LINE)).map(move |first| first..end.min(first + CACHE_LINE))
}

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

    /// Reads the coordinates of a tile, unwrapped.
    pub fn read(&self, coordinates: Range<usize>, tile: &mut Tile) {
        for (k, state) in self.points.iter().enumerate() {
            let line = match state {
                Some(state) => &state[coordinates.clone()],
                None => &[0.0; CACHE_LINE][..coordinates.len()],
            };
            // Of a known length, the loop is unrolled.
            match <&[f64; CACHE_LINE]>::try_from(line) {
                Ok(line) => (tile.iter_mut().zip(line)).for_each(|(of, value)| of[k] = *value),
                Err(_) => (tile.iter_mut().zip(line)).for_each(|(of, value)| of[k] = *value),
            }
        }
        for (values, c) in tile.iter_mut().zip(coordinates) {
            self.unwrap(values, c);
        }
    }

    /// A coordinate, unwrapped.
    pub fn values(&self, c: usize) -> [f64; POINTS] {
        let value = |state: &Option<&[f64]>| state.map_or(0.0, |state| state[c]);
        let mut values = self.points.each_ref().map(value);
        self.unwrap(&mut values, c);
        values
    }

    fn unwrap(&self, values: &mut [f64; POINTS], c: usize) {
        let period = period(self.coordinates, c);
        if period == 0.0 {
            return;
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
    }
}

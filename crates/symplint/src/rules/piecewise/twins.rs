//! Twins of features that were met by chance.
//!
//! A force that is a function of one coordinate acts wherever the loop passes the same value of it. So where a narrow
//! feature was met, the loop is looked at again wherever a coordinate is what it is there, in pieces as short. Which
//! state the force belongs to is not known of a step that is one whole: that before the step in a kick that comes first,
//! that after it in one that comes last, and of a kick between two drifts half way between both, where positions are a
//! function of those that the kick meets.

use super::POINTS;
use super::chance::{Stretch, stretches};
use super::path::Path;
use super::piece::{Piece, SHORTEST};
use super::queue::Queue;
use super::scales::period;
use crate::error::Error;
use crate::signal::nearest;
use crate::state::Ensemble;
use crate::state::coordinate;

/// Places closer than this are one: pieces between them should be more than straight lines.
const APART: f64 = 100.0 * SHORTEST;

/// Looks at the loop again where twins of features met by chance may be, as far as evaluations may be made.
pub(super) fn look_for_twins(queue: &mut Queue<'_>) -> Result<(), Error> {
    let places = places(queue)?;
    if places.is_empty() {
        return Ok(());
    }
    let mut again = Vec::new();
    for smooth in std::mem::take(&mut queue.smooth) {
        let Piece { curve, a, b, .. } = smooth.piece;
        let mut edges = vec![a];
        if curve == 0 {
            let first = places.partition_point(|&s| s <= a + APART);
            let inside = places[first..].iter().copied();
            edges.extend(inside.take_while(|&s| s < b - APART));
        }
        edges.push(b);
        if edges.len() > 2 && queue.grant((edges.len() - 1) * POINTS) {
            let parts = edges.windows(2);
            again.extend(parts.map(|ends| smooth.piece.part(ends[0], ends[1])));
        } else {
            queue.smooth.push(smooth);
        }
    }
    queue.run(0, again)
}

/// Where the coordinates are what they are at the ends of pieces round features that were met by chance: rising.
fn places(queue: &Queue<'_>) -> Result<Vec<f64>, Error> {
    let dof = queue.coordinates.dof();
    let stretches = stretches(queue);
    let found: Vec<(usize, Vec<&Stretch<'_>>)> = (0..dof)
        .map(|i| (i, stretches.iter().filter(|x| x.is_by_chance(i)).collect()))
        .filter(|(_, stretches): &(usize, Vec<_>)| !stretches.is_empty())
        .collect();
    let (Some(after), false) = (queue.seen, found.is_empty()) else {
        return Ok(Vec::new());
    };
    let before = Ensemble::sample(queue.curves.phase_loop, after.samples())?;
    let mut places = Vec::new();
    for (i, stretches) in found {
        for c in [i, dof + i] {
            let period = period(queue.coordinates, c);
            let [before, after] = [&before, after].map(|states| coordinate(states, c));
            let half_way: Vec<f64> = (before.iter().zip(after))
                .map(|(x, y)| x + 0.5 * nearest(y - x, period))
                .collect();
            for row in [before, after, &half_way] {
                for stretch in &stretches {
                    add_places(&mut places, stretch, row, period);
                }
            }
        }
    }
    places.sort_by(f64::total_cmp);
    places.dedup_by(|next, last| *next - *last < APART);
    Ok(places)
}

/// Adds where a row of samples takes the values that it has at the ends of the pieces of a stretch.
fn add_places(places: &mut Vec<f64>, stretch: &Stretch<'_>, row: &[f64], period: f64) {
    let samples = row.len();
    let across = stretch.across(row, period);
    let values: Vec<f64> = (stretch.edges().iter()).map(|&s| across.at(s)).collect();
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    for k in 0..samples {
        // Most cells are far from all of them.
        let from = nearest(row[k] - middle, period);
        let to = from + nearest(row[(k + 1) % samples] - row[k], period);
        if from.min(to) > half || from.max(to) < -half || stretch.touches(k) {
            continue;
        }
        let path = Path::through(
            // A cubic through the two samples on both sides, as differences from the middle.
            ([-1, 0, 1, 2].iter())
                .map(|step| {
                    let at = (k + samples).wrapping_add_signed(*step) % samples;
                    let value = from + nearest(row[at] - row[k], period);
                    ((k as f64 + *step as f64) / samples as f64, value)
                })
                .collect(),
        );
        let ends = [k, k + 1].map(|k| k as f64 / samples as f64);
        let of_cell = values.iter().map(|value| value - middle);
        places.extend(of_cell.filter_map(|value| crossing(&path, ends, value)));
    }
}

/// Where a path takes a value, if its ends are on both sides of it.
fn crossing(path: &Path, [mut low, mut high]: [f64; 2], value: f64) -> Option<f64> {
    let below = path.at(low) < value;
    if below == (path.at(high) < value) {
        return None;
    }
    while high - low > APART {
        let middle = 0.5 * (low + high);
        if (path.at(middle) < value) == below {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
}

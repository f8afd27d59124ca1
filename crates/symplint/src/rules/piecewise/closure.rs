//! Closing the breaks.

use super::Closure;
use super::curves::{At, Segment};
use super::piece::Piece;
use super::queue::Queue;
use super::scales::period;
use crate::error::Error;
use crate::signal::nearest;
use crate::state::Ensemble;
use crate::state::coordinate;

/// A straight segment between the two sides of a break.
pub(super) struct Chord {
    /// ∫ (p − p_ref) dq along it, for each degree of freedom.
    pub areas: Vec<f64>,
    /// ∫ dq along it.
    pub gains: Vec<f64>,
}

/// A difference of two states is a jump if it is this part of what it becomes.
const BORN: f64 = 1e-4;

/// Closes every break of the loop, and those of the closing segments.
pub(super) fn close(queue: &mut Queue<'_>, closure: Closure) -> Result<Vec<Chord>, Error> {
    let substeps = queue.curves.evaluator.substeps();
    let mut chords = Vec::new();
    let mut closed = 0;
    for substep in 0..substeps {
        // Segments that begin here are from breaks of earlier substeps: all of them are known.
        if substep > 0 {
            let segments = queue.curves.segments.iter().enumerate();
            let pieces: Vec<Piece> = segments
                .filter(|(_, segment)| segment.substep == substep)
                .map(|(k, _)| Piece::new(k + 1, 0.0, 1.0))
                .collect();
            queue.run(substep, pieces)?;
        }
        let first = std::mem::replace(&mut closed, queue.breaks.len());
        let points: Vec<At> = (queue.breaks[first..].iter())
            .flat_map(|found| {
                let curve = found.curve;
                found.sides.map(|s| At { curve, s })
            })
            .collect();
        if points.is_empty() {
            continue;
        }
        let stages = queue.curves.stages(&points, substep)?;
        queue.evaluations += points.len();
        queue.measure_breaks(first, &stages[stages.len() - 1]);
        for k in 0..points.len() / 2 {
            let sides = [2 * k, 2 * k + 1];
            if queue.breaks[first + k].curve == 0 {
                queue.breaks[first + k].areas =
                    chord(queue, &stages[stages.len() - 1], sides).areas;
            }
            let born = birth(queue, &stages, sides);
            if substeps > 1 {
                queue.breaks[first + k].summary.substep = Some(substep + born.max(1) - 1);
            }
            let birth = match closure {
                Closure::Chords => stages.len() - 1,
                Closure::Substeps => born,
            };
            if birth + 1 == stages.len() {
                chords.push(chord(queue, &stages[birth], sides));
            } else {
                queue.curves.segments.push(Segment {
                    ends: sides.map(|side| state(&stages[birth], side)),
                    substep: substep + birth,
                });
            }
        }
    }
    Ok(chords)
}

/// The first of `stages` at which the two sides of a break are apart.
fn birth(queue: &Queue<'_>, stages: &[Ensemble], sides: [usize; 2]) -> usize {
    let apart: Vec<f64> = stages
        .iter()
        .map(|states| size(queue, states, sides))
        .collect();
    let most = apart.iter().copied().fold(0.0, f64::max);
    (apart.iter().position(|&size| size > BORN * most)).unwrap_or(stages.len() - 1)
}

/// How far two states are apart, in the sizes of the coordinates.
fn size(queue: &Queue<'_>, states: &Ensemble, [left, right]: [usize; 2]) -> f64 {
    (0..2 * states.dof())
        .map(|c| {
            let row = coordinate(states, c);
            let apart = nearest(row[right] - row[left], period(queue.coordinates, c));
            (queue.scales.weight(c) * apart).abs()
        })
        .fold(0.0, f64::max)
}

fn state(states: &Ensemble, sample: usize) -> Vec<f64> {
    (0..2 * states.dof())
        .map(|c| coordinate(states, c)[sample])
        .collect()
}

fn chord(queue: &Queue<'_>, states: &Ensemble, [left, right]: [usize; 2]) -> Chord {
    let gains: Vec<f64> = (0..states.dof())
        .map(|i| {
            let q = states.q().row(i);
            nearest(q[right] - q[left], queue.coordinates.period(i))
        })
        .collect();
    let areas = gains.iter().enumerate().map(|(i, gain)| {
        let p = states.p().row(i);
        let mean = 0.5 * (p[left] + p[right]) - queue.scales.p_reference[i];
        queue.coordinates.weight(i) * mean * gain
    });
    Chord {
        areas: areas.collect(),
        gains,
    }
}

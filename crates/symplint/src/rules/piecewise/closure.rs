//! Closing the breaks.

use super::Closure;
use super::curves::{PointImage, Segment};
use super::limits::MIN_PART_OF_FINAL_JUMP;
use super::piece::Piece;
use super::refinement::{CurveBreak, Refinement};
use super::scales::Scales;
use crate::error::Error;
use crate::signal::nearest;
use crate::state::{Coordinates, period};

/// A straight segment between the two sides of a break.
pub(super) struct Chord {
    /// ∫ (p − p_ref) dq along it, for each degree of freedom.
    pub areas: Vec<f64>,
    /// ∫ dq along it.
    pub gains: Vec<f64>,
}

/// What closes the breaks.
pub(super) struct ClosingChords {
    /// The segments that are straight after the whole step; the others are curves of the refinement.
    pub chords: Vec<Chord>,
    /// See [`PiecewiseIntegral::bend`](super::PiecewiseIntegral::bend).
    pub bend: f64,
}

/// Closes every break of the loop, and those of the closing segments.
pub(super) fn close(
    refinement: &mut Refinement<'_>,
    closure: Closure,
) -> Result<ClosingChords, Error> {
    let substeps = refinement.curves.evaluator.substeps();
    // On a manifold a segment is put onto it and integrated as a curve, beyond the last substep, too.
    let straight = refinement.curves.evaluator.constraint().is_none();
    let (mut chords, mut bend) = (Vec::new(), 0.0);
    let mut closed = 0;
    for substep in 0..substeps + usize::from(!straight) {
        // Segments that begin here are from breaks of earlier substeps: all of them are known.
        if substep > 0 {
            let segments = refinement.curves.segments.iter().enumerate();
            let pieces = segments
                .filter(|(_, segment)| segment.substep == substep)
                .map(|(k, segment)| {
                    let ends = segment.ends.clone().map(Some);
                    Piece::new(k + 1, [0.0, 1.0], 0, ends)
                });
            let pieces = pieces.collect();
            refinement.run(substep, pieces)?;
        }
        let (coordinates, scales) = (refinement.coordinates, &refinement.scales);
        for found in &mut refinement.breaks[closed..] {
            let last = found.images[0].stages() - 1;
            let born = birth(found, scales, coordinates);
            if substeps > 1 {
                found.substep = Some(substep + born.max(1) - 1);
            }
            let birth = match closure {
                Closure::Chords => last,
                Closure::Substeps => born,
            };
            bend += found.bend(birth, coordinates);
            if birth == last && straight {
                chords.push(found.chord(scales, coordinates));
            } else {
                refinement.curves.segments.push(Segment {
                    ends: found
                        .images
                        .each_ref()
                        .map(|image| image.starting_at(birth)),
                    substep: substep + birth,
                });
            }
        }
        closed = refinement.breaks.len();
    }
    Ok(ClosingChords { chords, bend })
}

/// The first stage at which the two sides of a break are apart.
fn birth(found: &CurveBreak, scales: &Scales, coordinates: &Coordinates) -> usize {
    let [low, high] = &found.images;
    // How far two states are apart, in the sizes of the coordinates.
    let size = |stage: usize| {
        let sides = low.stage(stage).iter().zip(high.stage(stage)).enumerate();
        sides.fold(0.0, |most: f64, (c, (low, high))| {
            let apart = nearest(high - low, period(coordinates, c));
            most.max((scales.weight(c) * apart).abs())
        })
    };
    let sizes: Vec<f64> = (0..low.stages()).map(size).collect();
    let most = sizes.iter().copied().fold(0.0, f64::max);
    (sizes
        .iter()
        .position(|&size| size > MIN_PART_OF_FINAL_JUMP * most))
    .unwrap_or(sizes.len() - 1)
}

impl CurveBreak {
    /// The area of the rectangles that the segment between its sides at this stage is a diagonal of, in the planes of the
    /// degrees of freedom: other monotone curves between them stay within.
    fn bend(&self, stage: usize, coordinates: &Coordinates) -> f64 {
        let dof = coordinates.dof();
        let [low, high] = self.images.each_ref().map(|image| image.stage(stage));
        let apart = |c: usize| nearest(high[c] - low[c], period(coordinates, c));
        (0..dof)
            .map(|i| (coordinates.weight(i) * apart(i) * apart(dof + i)).abs())
            .sum()
    }

    /// The straight segment between its sides after the step.
    pub fn chord(&self, scales: &Scales, coordinates: &Coordinates) -> Chord {
        let dof = coordinates.dof();
        let [low, high] = self.images.each_ref().map(PointImage::after);
        let gains: Vec<f64> = (0..dof).map(|i| self.jump(i, coordinates)).collect();
        let areas = gains.iter().enumerate().map(|(i, gain)| {
            let mean = 0.5 * (low[dof + i] + high[dof + i]) - scales.p_reference[i];
            coordinates.weight(i) * mean * gain
        });
        Chord {
            areas: areas.collect(),
            gains,
        }
    }
}

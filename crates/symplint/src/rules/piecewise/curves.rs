//! Curves of states under the map: the loop, and the segments that close its breaks.

use std::collections::HashMap;
use std::sync::Arc;

use super::lift::Lift;
use crate::breaks::displace;
use crate::error::{Error, StateLocation};
use crate::loops::Loop;
use crate::map::Evaluator;
use crate::state::{Block, CACHE_LINE, Ensemble, in_parallel};

/// One step of a map, and the curves that are sent through it.
pub(super) struct Curves<'a> {
    pub evaluator: &'a Evaluator<'a>,
    pub h: f64,
    pub phase_loop: &'a dyn Loop,
    /// Segments that close breaks; curve 0 is the loop, curve k is `segments[k − 1]`.
    pub segments: Vec<Segment>,
    /// Unwraps the momenta of images.
    pub lift: Lift,
}

/// A straight segment of states, t in [0, 1], between substeps of the map; if the map has a manifold that it does not leave
/// there, one that is put onto it.
pub(super) struct Segment {
    /// Both ends, from where the segment begins on.
    pub ends: [PointImage; 2],
    /// The substep that it meets first.
    pub substep: usize,
}

/// A point of a curve.
#[derive(Clone, Copy)]
pub(super) struct CurvePoint {
    pub curve: usize,
    /// s of the loop, t of a segment.
    pub s: f64,
    /// How the state is displaced by a few roundings: 0 if it is not.
    pub pattern: usize,
}

impl CurvePoint {
    /// A point that is not displaced.
    pub fn on(curve: usize, s: f64) -> Self {
        CurvePoint {
            curve,
            s,
            pattern: 0,
        }
    }
}

/// The images of a point of a curve: the states before each substep that it meets, and after the last.
#[derive(Clone)]
pub(super) struct PointImage {
    /// One state after the other: positions, then momenta.
    states: Arc<[f64]>,
    /// Coordinates of a state.
    width: usize,
    /// The start of the first state.
    start: usize,
}

impl PointImage {
    /// Number of states.
    pub fn stages(&self) -> usize {
        (self.states.len() - self.start) / self.width.max(1)
    }

    /// One of them.
    pub fn stage(&self, k: usize) -> &[f64] {
        let start = self.start + k * self.width;
        &self.states[start..start + self.width]
    }

    /// The state after the step.
    pub fn after(&self) -> &[f64] {
        &self.states[self.states.len() - self.width..]
    }

    /// The same without the states before stage `k`.
    pub fn starting_at(&self, k: usize) -> Self {
        PointImage {
            start: self.start + k * self.width,
            ..self.clone()
        }
    }
}

impl Curves<'_> {
    pub fn dof(&self) -> usize {
        self.phase_loop.dof()
    }

    /// The states at `points` of curves that meet `substep` first, before it.
    fn before(&self, points: &[CurvePoint], substep: usize) -> Ensemble {
        let mut states = Ensemble::zeros(self.dof(), points.len());
        let width = Ensemble::block_width(self.dof());
        let blocks = states.blocks().into_iter().zip(points.chunks(width));
        in_parallel(blocks, 2 * self.dof() * width, |(mut block, points)| {
            if substep == 0 {
                let s: Vec<f64> = points.iter().map(|point| point.s).collect();
                self.phase_loop.sample(&s, &mut block);
                return;
            }
            for (k, point) in points.iter().enumerate() {
                let ends = &self.segments[point.curve - 1].ends;
                let [from, to] = [ends[0].stage(0), ends[1].stage(0)];
                // It must not turn back and forth, however close the ends are: a break of the force may
                // lie between them.
                let blend = |i: usize| {
                    let between = from[i] + (to[i] - from[i]) * point.s;
                    between.max(from[i].min(to[i])).min(from[i].max(to[i]))
                };
                for i in 0..self.dof() {
                    block.q.row_mut(i)[k] = blend(i);
                    block.p.row_mut(i)[k] = blend(self.dof() + i);
                }
            }
            if let Some(constraint) = self.evaluator.constraint()
                && (constraint.holds_between_substeps() || substep == self.evaluator.substeps())
            {
                constraint.project(&mut block);
            }
        });
        states
    }

    /// Sends `points` of curves that meet `substep` first through the rest of the step, each once; returns their
    /// images, and how many points there are.
    pub fn images(
        &self,
        points: &[CurvePoint],
        substep: usize,
    ) -> Result<(Vec<PointImage>, usize), Error> {
        let mut different: Vec<CurvePoint> = Vec::with_capacity(points.len());
        let mut index_of = HashMap::with_capacity(points.len());
        let indices: Vec<usize> = (points.iter())
            .map(|&at| {
                *(index_of.entry((at.curve, at.s.to_bits(), at.pattern))).or_insert_with(|| {
                    different.push(at);
                    different.len() - 1
                })
            })
            .collect();
        let images = self.images_of_each(&different, substep)?;
        // Beyond the last substep nothing is left to be evaluated.
        let evaluations = match substep == self.evaluator.substeps() {
            true => 0,
            false => different.len(),
        };
        let images = match different.len() == points.len() {
            true => images,
            false => indices.into_iter().map(|k| images[k].clone()).collect(),
        };
        Ok((images, evaluations))
    }

    fn images_of_each(
        &self,
        points: &[CurvePoint],
        substep: usize,
    ) -> Result<Vec<PointImage>, Error> {
        let mut states = self.before(points, substep);
        for (k, point) in points.iter().enumerate() {
            if point.pattern > 0 {
                displace(&mut states.block(), k, point.pattern);
            }
        }
        let position = |sample: usize| match points[sample] {
            CurvePoint { curve: 0, s, .. } => StateLocation::Loop(s),
            CurvePoint { s, .. } => StateLocation::Segment(s),
        };
        let at = |error: Error| error.at(position);
        states.check_finite(None).map_err(at)?;
        let substeps = self.evaluator.substeps();
        let width = 2 * self.dof();
        let numbers = width * (substeps - substep + 1);
        type Visits = (usize, Vec<Arc<[f64]>>);
        let begin = |first: usize, samples: usize| -> Visits {
            let image = || (0..numbers).map(|_| 0.0).collect();
            (first, std::iter::repeat_with(image).take(samples).collect())
        };
        let visit = |(first, images): &mut Visits, next: usize, block: &mut Block<'_>| {
            if next == substeps {
                for (sample, point) in points[*first..][..block.len()].iter().enumerate() {
                    self.unwrap(block, sample, point);
                }
            }
            let images = images.iter_mut().map(|image| {
                let states = Arc::get_mut(image).expect("an image is shared when it is complete");
                &mut states[width * (next - substep)..]
            });
            write_states(&mut images.collect::<Vec<_>>(), block);
        };
        let images = (self.evaluator)
            .advance_substeps(&mut states, substep, self.h, begin, visit)
            .map_err(at)?;
        let image = |states| PointImage {
            states,
            width,
            start: 0,
        };
        let each = images.into_iter().flat_map(|(_, images)| images);
        Ok(each.map(image).collect())
    }

    /// Unwraps the momenta of a state after the step, which is the image of a point.
    fn unwrap(&self, block: &mut Block<'_>, sample: usize, point: &CurvePoint) {
        let ends = match point.curve {
            0 => None,
            curve => {
                let ends = &self.segments[curve - 1].ends;
                Some(ends.each_ref().map(PointImage::after))
            }
        };
        self.lift.unwrap(block, sample, point.s, ends);
    }
}

/// Writes the state of each sample of a block to the beginning of its slice.
fn write_states(images: &mut [&mut [f64]], block: &Block<'_>) {
    /// Samples that are taken out of the rows together: four cache lines of a row, which lie one after the other.
    const SAMPLES_TOGETHER: usize = 32;
    let tables = [block.q.as_rows(), block.p.as_rows()];
    let rows: Vec<&[f64]> = (tables.iter())
        .flat_map(|rows| (0..rows.count()).map(|i| rows.row(i)))
        .collect();
    let mut tile = [[0.0; CACHE_LINE]; SAMPLES_TOGETHER];
    for (together, images) in images.chunks_mut(SAMPLES_TOGETHER).enumerate() {
        let first = together * SAMPLES_TOGETHER;
        for (chunk, rows) in rows.chunks(CACHE_LINE).enumerate() {
            for (i, row) in rows.iter().enumerate() {
                let values = &row[first..first + images.len()];
                (tile.iter_mut().zip(values)).for_each(|(line, value)| line[i] = *value);
            }
            for (image, line) in images.iter_mut().zip(&tile) {
                let image = &mut image[chunk * CACHE_LINE..][..rows.len()];
                match image.first_chunk_mut() {
                    // Of a known length, it is two instructions.
                    Some(image) => *image = *line,
                    None => image.copy_from_slice(&line[..rows.len()]),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_have_the_coordinates_of_their_sample_at_each_stage() {
        let value = |stage: usize, c: usize, k: usize| (10_000 * stage + 100 * c + k) as f64;
        for (dof, samples) in [(1, 1), (3, 31), (4, 32), (5, 77)] {
            let numbers = 3 * 2 * dof;
            let mut images = vec![0.0; samples * numbers];
            let mut states = Ensemble::zeros(dof, samples);
            for stage in 0..3 {
                let mut block = states.block();
                for k in 0..samples {
                    for i in 0..dof {
                        block.q.row_mut(i)[k] = value(stage, i, k);
                        block.p.row_mut(i)[k] = value(stage, dof + i, k);
                    }
                }
                let images = images.chunks_mut(numbers);
                let mut images: Vec<&mut [f64]> =
                    images.map(|image| &mut image[2 * dof * stage..]).collect();
                write_states(&mut images, &block);
            }
            for (k, states) in images.chunks(numbers).enumerate() {
                let image = PointImage {
                    states: states.into(),
                    width: 2 * dof,
                    start: 0,
                };
                assert_eq!(image.stages(), 3);
                for stage in 0..3 {
                    let expected: Vec<f64> = (0..2 * dof).map(|c| value(stage, c, k)).collect();
                    assert_eq!(image.stage(stage), expected);
                }
            }
        }
    }
}

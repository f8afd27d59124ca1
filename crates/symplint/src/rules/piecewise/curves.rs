//! Curves of states under the map: the loop, and the segments that close its breaks.

use rayon::prelude::*;

use crate::error::{Error, ON_A_SEGMENT, ON_THE_LOOP};
use crate::loops::Loop;
use crate::map::Evaluator;
use crate::state::Ensemble;

/// One step of a map, and the curves that are sent through it.
pub(super) struct Curves<'a> {
    pub evaluator: &'a Evaluator<'a>,
    pub h: f64,
    pub phase_loop: &'a dyn Loop,
    /// Segments that close breaks; curve 0 is the loop, curve k is `segments[k − 1]`.
    pub segments: Vec<Segment>,
}

/// A straight segment of states, t in [0, 1], between substeps of the map.
pub(super) struct Segment {
    /// Both ends: positions, then momenta.
    pub ends: [Vec<f64>; 2],
    /// The substep that it meets first.
    pub substep: usize,
}

/// A point of a curve.
#[derive(Clone, Copy)]
pub(super) struct At {
    pub curve: usize,
    /// s of the loop, t of a segment.
    pub s: f64,
}

/// What the step makes of points of curves.
pub(super) struct Images {
    /// States after the step.
    pub after: Ensemble,
    /// States before each substep, as far as they were asked for.
    pub inputs: Vec<Ensemble>,
}

impl Curves<'_> {
    pub fn dof(&self) -> usize {
        self.phase_loop.dof()
    }

    /// The states at `points` of curves that meet `substep` first, before it.
    fn before(&self, points: &[At], substep: usize) -> Ensemble {
        let mut states = Ensemble::zeros(self.dof(), points.len());
        let width = Ensemble::block_width(self.dof());
        let blocks = states
            .blocks()
            .into_par_iter()
            .zip(points.par_chunks(width));
        blocks.for_each(|(mut block, points)| {
            if substep == 0 {
                let s: Vec<f64> = points.iter().map(|point| point.s).collect();
                self.phase_loop.sample(&s, &mut block);
                return;
            }
            for (k, point) in points.iter().enumerate() {
                let [from, to] = &self.segments[point.curve - 1].ends;
                // It must not turn back and forth, however close the ends are: a break of the force may
                // lie between them.
                let blend = |i: usize| {
                    let between = from[i] + (to[i] - from[i]) * point.s;
                    match point.s {
                        1.0 => to[i],
                        _ => between.max(from[i].min(to[i])).min(from[i].max(to[i])),
                    }
                };
                for i in 0..self.dof() {
                    block.q.row_mut(i)[k] = blend(i);
                    block.p.row_mut(i)[k] = blend(self.dof() + i);
                }
            }
        });
        states
    }

    /// Sends `points` of curves that meet `substep` first through the rest of the step.
    pub fn images(&self, points: &[At], substep: usize, keep: bool) -> Result<Images, Error> {
        let mut states = self.before(points, substep);
        let mut inputs = Vec::new();
        let place = |sample: usize| match points[sample] {
            At { curve: 0, s } => (s, ON_THE_LOOP),
            At { s, .. } => (s, ON_A_SEGMENT),
        };
        let at = |error: Error| error.on_the_way(place);
        states.check_finite(None).map_err(at)?;
        for k in substep..self.evaluator.substeps() {
            if keep {
                inputs.push(states.clone());
            }
            (self.evaluator.advance_substep(&mut states, k, self.h)).map_err(at)?;
        }
        Ok(Images {
            after: states,
            inputs,
        })
    }

    /// The states at `points` before `substep` and after each substep from there on.
    pub fn stages(&self, points: &[At], substep: usize) -> Result<Vec<Ensemble>, Error> {
        let Images { after, mut inputs } = self.images(points, substep, true)?;
        inputs.push(after);
        Ok(inputs)
    }
}

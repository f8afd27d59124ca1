//! Derivatives of one step of a map at points of a loop, from states that are advanced in large batches.

use std::ops::Range;

use super::columns::Columns;
use super::constants::CONSTANTS;
use super::derivative::Derivative;
use super::directions;
use super::evidence::{JacobianMethod, TangentRejection};
use super::frame::Frame;
use super::noise;
use super::richardson::{self, FINER_LEVELS, FIRST_LEVELS, finer_levels_help};
use crate::error::{Error, StateLocation};
use crate::loops::Loop;
use crate::map::{Evaluator, LoopSize};
use crate::signal::nearest;
use crate::signal::noise::{NODES_BESIDE, Noise, SAFETY, of_a_row};
use crate::state::{Block, Ensemble, coordinate, in_parallel};

/// A tangent vector at a point, in units of the frame.
#[derive(Clone, Copy)]
pub(super) struct TangentVector<'d> {
    /// Index of the point.
    pub point: usize,
    /// No component beyond ±1.
    pub direction: &'d [f64],
}

/// One step of a map near points of a loop.
pub(super) struct Sampler<'a> {
    pub evaluator: &'a Evaluator<'a>,
    pub h: f64,
    pub frame: Frame,
    /// Whether derivatives are those of the tangent map.
    pub uses_tangents: bool,
    /// Why they are not, if the map has one.
    pub rejected: Option<TangentRejection>,
    /// Loop parameters of the points.
    pub s: Vec<f64>,
    /// The loop at the points, one sample each.
    pub before: Ensemble,
    /// Their states after the step: point by point, positions first.
    pub after: Vec<Vec<f64>>,
    /// Noise of the map at each point.
    pub noise: Vec<Vec<f64>>,
    /// Evaluations that may be made in addition to those that every test makes.
    spare: usize,
    /// Evaluations of the evaluator before this test.
    made_before: usize,
}

impl<'a> Sampler<'a> {
    /// Samples the loop at the parameters `s` and measures the noise of the map there.
    pub fn new(
        evaluator: &'a Evaluator<'a>,
        (phase_loop, size): (&dyn Loop, &LoopSize),
        h: f64,
        s: Vec<f64>,
        seed: u64,
        spare: usize,
    ) -> Result<Self, Error> {
        let dof = phase_loop.dof();
        Ensemble::check_size(dof, s.len())?;
        let mut before = Ensemble::zeros(dof, s.len());
        phase_loop.sample(&s, &mut before.block());
        if let Some(constraint) = evaluator.constraint() {
            constraint.project(&mut before.block());
        }
        (before.check_finite(None)).map_err(|error| error.at(|k| StateLocation::Loop(s[k])))?;
        let mut sampler = Sampler {
            evaluator,
            h,
            frame: Frame::new(size, evaluator.coordinates())?,
            uses_tangents: evaluator.has_tangent(),
            rejected: None,
            before,
            after: Vec::with_capacity(s.len()),
            noise: Vec::with_capacity(s.len()),
            s,
            spare,
            made_before: evaluator.count().made(),
        };
        sampler.measure_noise(&directions::dense(2 * dof, seed))?;
        Ok(sampler)
    }

    /// How derivatives are computed.
    pub fn method(&self) -> JacobianMethod {
        match self.uses_tangents {
            true => JacobianMethod::TangentMap,
            false => JacobianMethod::CentralDifferences {
                rejected: self.rejected,
            },
        }
    }

    /// Evaluations made so far.
    pub fn made(&self) -> usize {
        self.evaluator.count().made() - self.made_before
    }

    /// Takes evaluations from those to spare, if there are as many.
    pub fn draw(&mut self, evaluations: usize) -> bool {
        let enough = evaluations <= self.spare;
        if enough {
            self.spare -= evaluations;
        }
        enough
    }

    /// Continues without the tangent map, at as many points as `budget` allows for this number of directions at each.
    pub fn fall_back(&mut self, directions: usize, budget: usize) {
        self.uses_tangents = false;
        let left = budget.saturating_sub(self.made());
        let of_point = directions * richardson::FIRST_STATES;
        self.s.truncate(left / of_point);
        self.spare = left - self.s.len() * of_point;
    }

    /// Evaluations that the derivative along a tangent vector takes.
    pub fn cost(&self) -> usize {
        match self.uses_tangents {
            true => CONSTANTS.trials,
            false => richardson::FIRST_STATES,
        }
    }

    /// Coordinates: twice the degrees of freedom.
    pub fn coordinates(&self) -> usize {
        2 * self.frame.dof()
    }

    /// Largest noise of a coordinate at any point.
    pub fn largest_noise(&self) -> f64 {
        let noise = self.noise.iter().flatten();
        noise.fold(0.0_f64, |most, x| most.max(*x)).min(f64::MAX)
    }

    /// How many times this number of states fits into one batch.
    pub fn in_a_batch(&self, states: usize) -> usize {
        (CONSTANTS.batch_values / (states * self.coordinates())).max(1)
    }

    /// The states of all points after the step, and the noise of every coordinate there, along a direction. Larger
    /// spacings are added at points where a coordinate needs them.
    fn measure_noise(&mut self, direction: &[f64]) -> Result<(), Error> {
        let of_a_row = of_a_row();
        let mut found = vec![vec![Noise::default(); self.coordinates()]; self.s.len()];
        let points: Vec<usize> = (0..self.s.len()).collect();
        for batch in points.chunks(self.in_a_batch(1 + NODES_BESIDE.len())) {
            let mut unresolved = batch.to_vec();
            for level in 0..noise::SPACINGS.len() {
                let centre = (level == 0).then_some(0.0);
                let offsets: Vec<f64> = centre.into_iter().chain(noise::offsets(level)).collect();
                let at = |&point: &usize| TangentVector { point, direction };
                let vectors: Vec<TangentVector<'_>> = unresolved.iter().map(at).collect();
                let states = self.displaced(&vectors, &offsets)?;
                let stencil = |k: usize, c: usize| {
                    &coordinate(&states, c)[k * offsets.len()..(k + 1) * offsets.len()]
                };
                for (k, &point) in unresolved.iter().enumerate() {
                    if level == 0 {
                        let centre = (0..self.coordinates()).map(|c| stencil(k, c)[0]);
                        self.after.push(centre.collect());
                    }
                    for (c, noise) in found[point].iter_mut().enumerate() {
                        let around = &stencil(k, c)[offsets.len() - NODES_BESIDE.len()..];
                        let difference = |k: usize| self.difference(point, c, around[k]);
                        noise.add(&of_a_row, std::array::from_fn(difference));
                    }
                }
                unresolved.retain(|&point| {
                    let mut of_coordinates = found[point].iter().enumerate();
                    let resolved =
                        of_coordinates.all(|(c, noise)| noise.resolved || self.is_constant(c));
                    level + 1 < noise::SPACINGS.len() && !resolved && self.draw(NODES_BESIDE.len())
                });
                if unresolved.is_empty() {
                    break;
                }
            }
        }
        self.noise = vec![vec![0.0; self.coordinates()]; points.len()];
        for c in 0..self.coordinates() {
            let is_constant = self.is_constant(c);
            let of_point = |of_point: &Vec<Noise>| match is_constant {
                true => Some(0.0),
                false => of_point[c].value().map(|shown| SAFETY * shown),
            };
            let shown: Vec<Option<f64>> = found.iter().map(of_point).collect();
            for (point, noise) in noise::at_each_place(&shown).into_iter().enumerate() {
                let before = coordinate(&self.before, c)[point].abs();
                let magnitude = before.max(self.after[point][c].abs());
                let rounding = 2.0 * f64::EPSILON * magnitude / self.frame.size[c];
                self.noise[point][c] = noise.max(rounding);
            }
        }
        Ok(())
    }

    /// Whether a coordinate has one value on the manifold of the map, as far as is known: it responds to nothing there.
    fn is_constant(&self, c: usize) -> bool {
        let before = coordinate(&self.before, c);
        self.evaluator.constraint().is_some()
            && before.iter().all(|&value| value == before[0])
            && self.after.iter().all(|after| after[c] == before[0])
    }

    /// Advances points displaced along tangent vectors by each of `distances`.
    fn displaced(
        &self,
        vectors: &[TangentVector<'_>],
        distances: &[f64],
    ) -> Result<Ensemble, Error> {
        let of_vector = |&vector| distances.iter().map(move |&by| (vector, by));
        let columns: Vec<(TangentVector<'_>, f64)> = vectors.iter().flat_map(of_vector).collect();
        let dof = self.frame.dof();
        Ensemble::check_size(dof, columns.len())?;
        let mut states = Ensemble::zeros(dof, columns.len());
        let fill = |first: usize, block: &mut Block<'_>| {
            self.fill(block, |k| {
                let (at, by) = columns[first + k];
                (at.point, at.direction, by)
            });
            Ok(())
        };
        let state = |k: usize| {
            let (vector, by) = columns[k];
            match by {
                0.0 => StateLocation::Loop(self.s[vector.point]),
                _ => StateLocation::Displaced(self.s[vector.point]),
            }
        };
        (self.evaluator.advance_from(&mut states, self.h, fill))
            .map_err(|error| error.at(state))?;
        Ok(states)
    }

    /// Measures the derivatives along the tangent vectors of all columns.
    pub fn differentiate(&mut self, columns: &mut [Columns]) -> Result<(), Error> {
        let vectors = columns.iter().flat_map(|columns| {
            let point = columns.point;
            let directions = columns.directions.iter();
            directions.map(move |direction| TangentVector { point, direction })
        });
        let mut derivatives = self.derivatives(&vectors.collect::<Vec<_>>())?.into_iter();
        for columns in columns {
            let count = columns.directions.len();
            columns.derivatives = derivatives.by_ref().take(count).collect();
        }
        Ok(())
    }

    /// The derivatives of the step along tangent vectors.
    pub fn derivatives(&mut self, vectors: &[TangentVector<'_>]) -> Result<Vec<Derivative>, Error> {
        match self.uses_tangents {
            true => self.tangent_derivatives(vectors),
            false => self.differences(vectors),
        }
    }

    /// The same by central differences.
    pub fn differences(&mut self, vectors: &[TangentVector<'_>]) -> Result<Vec<Derivative>, Error> {
        let mut found = Vec::with_capacity(vectors.len());
        for batch in vectors.chunks(self.in_a_batch(richardson::STATES)) {
            let distances = |levels| richardson::displacements(levels).collect::<Vec<f64>>();
            let first = self.displaced(batch, &distances(FIRST_LEVELS))?;
            let of_first = |k: usize| self.extrapolated(batch[k].point, &[(&first, k)]);
            let numbers = richardson::STATES * 2 * self.frame.dof();
            let mut derivatives = in_parallel(0..batch.len(), numbers, of_first);
            let mut unresolved: Vec<usize> = (0..batch.len()).collect();
            unresolved.retain(|&k| {
                let noise = self.noise[batch[k].point]
                    .iter()
                    .copied()
                    .fold(0.0, f64::max);
                finer_levels_help(&derivatives[k], noise) && self.draw(2 * FINER_LEVELS.len())
            });
            if !unresolved.is_empty() {
                let again: Vec<TangentVector<'_>> = unresolved.iter().map(|&k| batch[k]).collect();
                let finer = self.displaced(&again, &distances(FINER_LEVELS))?;
                for (j, &k) in unresolved.iter().enumerate() {
                    let states = [(&first, k), (&finer, j)];
                    derivatives[k] = self.extrapolated(batch[k].point, &states);
                }
            }
            found.append(&mut derivatives);
        }
        Ok(found)
    }

    /// The derivative at a point from states at the first levels, and at the finer ones if they are there: which
    /// ensemble, and which of its stencils.
    fn extrapolated(&self, point: usize, states: &[(&Ensemble, usize)]) -> Derivative {
        let levels: Vec<Range<usize>> = [FIRST_LEVELS, FINER_LEVELS]
            .into_iter()
            .take(states.len())
            .collect();
        let count = levels.iter().map(Range::len).sum();
        richardson::derivative(self.coordinates(), count, |c| {
            let stencils = levels
                .iter()
                .zip(states)
                .flat_map(|(levels, (states, stencil))| {
                    let width = 2 * levels.len();
                    &coordinate(states, c)[stencil * width..(stencil + 1) * width]
                });
            let mut differences = [0.0; richardson::STATES];
            for (difference, value) in differences.iter_mut().zip(stencils) {
                *difference = self.difference(point, c, *value);
            }
            (differences, self.noise[point][c])
        })
    }

    /// How far a coordinate is from that of a point after the step.
    pub fn difference(&self, point: usize, c: usize, value: f64) -> f64 {
        nearest(value - self.after[point][c], self.frame.period[c]) / self.frame.size[c]
    }
}

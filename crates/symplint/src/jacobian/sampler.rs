//! Derivatives of one step of a map at points of a loop, from states that are advanced in large batches.

use std::ops::Range;

use rayon::prelude::*;

use super::constants::CONSTANTS;
use super::derivative::Derivative;
use super::evidence::{JacobianMethod, TangentRejection};
use super::frame::Frame;
use super::richardson::{self, FINER, FIRST, Neighbourhood, finer_levels_help};
use super::{directions, noise};
use crate::error::{BESIDE_THE_LOOP, Error, ON_THE_LOOP};
use crate::loops::Loop;
use crate::map::Evaluator;
use crate::signal::nearest;
use crate::state::{Block, Ensemble, coordinate};

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
    /// Evaluations that may be made beside those that every test makes.
    spare: usize,
    /// Evaluations of the evaluator before this test.
    made_before: usize,
}

impl<'a> Sampler<'a> {
    /// Samples the loop at the parameters `s` and measures the noise of the map there.
    pub fn new(
        evaluator: &'a Evaluator<'a>,
        phase_loop: &dyn Loop,
        h: f64,
        s: Vec<f64>,
        seed: u64,
        spare: usize,
    ) -> Result<Self, Error> {
        let dof = phase_loop.dof();
        Ensemble::check_size(dof, s.len())?;
        let mut before = Ensemble::zeros(dof, s.len());
        phase_loop.sample(&s, &mut before.block());
        (before.check_finite(None)).map_err(|error| error.on_the_way(|k| (s[k], ON_THE_LOOP)))?;
        let mut sampler = Sampler {
            evaluator,
            h,
            frame: Frame::new(phase_loop, evaluator.coordinates())?,
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

    /// Goes on without the tangent map, at as many points as `budget` allows for so many directions at each.
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

    /// How many times so many states fit into one batch.
    pub fn in_a_batch(&self, states: usize) -> usize {
        (CONSTANTS.batch_values / (states * self.coordinates())).max(1)
    }

    /// The noise of every coordinate at every point, along a direction. Larger spacings are added at points where
    /// a coordinate needs them.
    fn measure_noise(&mut self, direction: &[f64]) -> Result<(), Error> {
        let sixth_differences = noise::SixthDifferences::new();
        let points: Vec<usize> = (0..self.s.len()).collect();
        let mut shown = vec![Vec::with_capacity(points.len()); self.coordinates()];
        for batch in points.chunks(self.in_a_batch(noise::STATES)) {
            let mut stencils = Stencils::default();
            let mut unresolved = batch.to_vec();
            for level in 0..noise::LEVELS {
                if level > 0 {
                    unresolved.retain(|&point| {
                        let resolved = (0..self.coordinates())
                            .all(|c| noise::is_resolved(&stencils.differences(self, point, c)));
                        !resolved && self.draw(noise::FURTHER_STATES)
                    });
                }
                if unresolved.is_empty() {
                    break;
                }
                let at = |&point: &usize| TangentVector { point, direction };
                let vectors: Vec<TangentVector<'_>> = unresolved.iter().map(at).collect();
                let offsets: Vec<f64> = noise::offsets(level).collect();
                let states = self.displaced(&vectors, &offsets)?;
                stencils.levels.push((unresolved.clone(), states));
            }
            for &point in batch {
                self.after.push(stencils.centre(point));
                for (c, shown) in shown.iter_mut().enumerate() {
                    shown.push(sixth_differences.noise(&stencils.differences(self, point, c)));
                }
            }
        }
        self.noise = vec![vec![0.0; self.coordinates()]; points.len()];
        for (c, shown) in shown.iter().enumerate() {
            for (point, noise) in noise::at_each_place(shown).into_iter().enumerate() {
                let before = coordinate(&self.before, c)[point].abs();
                let magnitude = before.max(self.after[point][c].abs());
                let rounding = 2.0 * f64::EPSILON * magnitude / self.frame.size[c];
                self.noise[point][c] = noise.max(rounding);
            }
        }
        Ok(())
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
            let columns = &columns[first..first + block.len()];
            for c in 0..2 * dof {
                let (from, size) = (coordinate(&self.before, c), self.frame.size[c]);
                for (value, (at, by)) in row_mut(block, c).iter_mut().zip(columns) {
                    *value = from[at.point] + by * at.direction[c] * size;
                }
            }
            Ok(())
        };
        (self.evaluator.advance_from(&mut states, self.h, fill))
            .map_err(|error| error.on_the_way(|k| (self.s[columns[k].0.point], BESIDE_THE_LOOP)))?;
        Ok(states)
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
            let first = self.displaced(batch, &distances(FIRST))?;
            let of_first = |k: usize| self.extrapolated(batch[k].point, &[(&first, k)]);
            let mut derivatives: Vec<Derivative> =
                (0..batch.len()).into_par_iter().map(of_first).collect();
            let mut unresolved: Vec<usize> = (0..batch.len()).collect();
            unresolved.retain(|&k| {
                let noise = self.noise[batch[k].point]
                    .iter()
                    .copied()
                    .fold(0.0, f64::max);
                finer_levels_help(&derivatives[k], noise) && self.draw(2 * FINER.len())
            });
            if !unresolved.is_empty() {
                let again: Vec<TangentVector<'_>> = unresolved.iter().map(|&k| batch[k]).collect();
                let finer = self.displaced(&again, &distances(FINER))?;
                for (j, &k) in unresolved.iter().enumerate() {
                    let states = [(&first, k), (&finer, j)];
                    derivatives[k] = self.extrapolated(batch[k].point, &states);
                }
            }
            found.append(&mut derivatives);
        }
        Ok(found)
    }

    /// The derivative at a point from the differences to states of the first levels, and of the finer ones if they
    /// are there: which ensemble, and which of its stencils.
    fn extrapolated(&self, point: usize, states: &[(&Ensemble, usize)]) -> Derivative {
        let levels = [FIRST, FINER];
        let levels: &[Range<usize>] = &levels[..states.len()];
        let count = levels.iter().map(|levels| levels.len()).sum();
        richardson::derivative(self.coordinates(), count, |c| {
            let mut values = [0.0; richardson::STATES];
            for (levels, (states, stencil)) in levels.iter().zip(states) {
                let (first, count) = (2 * stencil * levels.len(), 2 * levels.len());
                values[2 * levels.start..2 * levels.end]
                    .copy_from_slice(&coordinate(states, c)[first..first + count]);
            }
            Neighbourhood {
                values,
                levels: count,
                centre: self.after[point][c],
                period: self.frame.period[c],
                size: self.frame.size[c],
                noise: self.noise[point][c],
            }
        })
    }
}

/// Noise stencils of some points: for each spacing the points that have it, and their states.
#[derive(Default)]
struct Stencils {
    levels: Vec<(Vec<usize>, Ensemble)>,
}

impl Stencils {
    /// The state of a point after the step.
    fn centre(&self, point: usize) -> Vec<f64> {
        let (points, states) = &self.levels[0];
        let column = noise::FIRST_STATES * (point - points[0]);
        (0..2 * states.dof())
            .map(|c| coordinate(states, c)[column])
            .collect()
    }

    /// Differences of a coordinate to the state of the point, in the order of [`noise::offsets`].
    fn differences(&self, sampler: &Sampler<'_>, point: usize, c: usize) -> Vec<f64> {
        let mut differences: Vec<f64> = Vec::with_capacity(noise::STATES);
        let mut centre = 0.0;
        for (level, (points, states)) in self.levels.iter().enumerate() {
            let Ok(k) = points.binary_search(&point) else {
                break;
            };
            let count = noise::offsets(level).count();
            let values = &coordinate(states, c)[k * count..(k + 1) * count];
            if level == 0 {
                centre = values[0];
            }
            let (period, size) = (sampler.frame.period[c], sampler.frame.size[c]);
            let difference = |value: &f64| nearest(value - centre, period) / size;
            differences.extend(values.iter().map(difference));
        }
        differences
    }
}

/// Coordinate c of the samples of a block: positions first, then momenta.
pub(super) fn row_mut<'b>(block: &'b mut Block<'_>, c: usize) -> &'b mut [f64] {
    let dof = block.dof();
    if c < dof {
        block.q.row_mut(c)
    } else {
        block.p.row_mut(c - dof)
    }
}

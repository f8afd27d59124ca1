//! Where derivatives are measured: places on the loop, and the map round them, in large blocks.

use rayon::prelude::*;

use super::frame::Frame;
use super::method::JacobianMethod;
use super::richardson::{self, Derivative, Neighbourhood, derivative};
use super::{directions, noise, tangents};
use crate::error::{BESIDE_THE_LOOP, Error, ON_THE_LOOP};
use crate::loops::Loop;
use crate::map::Evaluator;
use crate::signal::nearest;
use crate::state::Ensemble;
use crate::state::coordinate;

/// Values in an ensemble of displaced states, unless one task needs more: 128 MiB.
const BATCH_VALUES: usize = 1 << 24;

/// Directions at one place.
pub(super) struct Task {
    /// Index of the place.
    pub place: usize,
    /// Tangent vectors in units of the frame, no component beyond ±1.
    pub directions: Vec<Vec<f64>>,
}

impl Task {
    /// Where the states of each task begin, with so many for each direction.
    pub fn starts(tasks: &[Self], states: usize) -> Vec<usize> {
        let of_tasks = tasks.iter().scan(0, |next, task| {
            let start = *next;
            *next += task.directions.len() * states;
            Some(start)
        });
        of_tasks.collect()
    }
}

/// One step of a map round places of a loop.
pub(super) struct Lab<'a> {
    pub evaluator: &'a Evaluator<'a>,
    pub method: JacobianMethod,
    pub h: f64,
    pub frame: Frame,
    /// Loop parameters of the places.
    pub places: Vec<f64>,
    /// The loop at the places, one sample each.
    pub before: Ensemble,
    /// What the step makes of it: place by place, positions first.
    pub after: Vec<Vec<f64>>,
    /// Noise of the map at each place, in units of the frame.
    pub noise: Vec<Vec<f64>>,
    /// States advanced.
    pub evaluations: usize,
}

/// A place displaced by `by` along a direction.
struct Displaced<'d> {
    place: usize,
    direction: &'d [f64],
    by: f64,
}

impl<'a> Lab<'a> {
    /// Samples the loop, measures the noise of the map, and checks its tangent map.
    pub fn new(
        evaluator: &'a Evaluator<'a>,
        phase_loop: &dyn Loop,
        h: f64,
        places: Vec<f64>,
        seed: u64,
    ) -> Result<Self, Error> {
        let dof = phase_loop.dof();
        Ensemble::check_size(dof, places.len())?;
        let mut before = Ensemble::zeros(dof, places.len());
        let blocks = before.blocks().into_par_iter();
        let each = blocks.zip(places.par_chunks(Ensemble::block_width(dof)));
        each.for_each(|(mut block, s)| phase_loop.sample(s, &mut block));
        (before.check_finite(None))
            .map_err(|error| error.on_the_way(|k| (places[k], ON_THE_LOOP)))?;
        let mut lab = Lab {
            evaluator,
            method: JacobianMethod::CentralDifferences { rejected: None },
            h,
            frame: Frame::new(phase_loop, evaluator.coordinates())?,
            before,
            after: Vec::with_capacity(places.len()),
            noise: Vec::with_capacity(places.len()),
            places,
            evaluations: 0,
        };
        let direction = directions::of_noise(dof, seed);
        lab.measure_noise(&direction)?;
        if evaluator.has_tangent() {
            lab.method = match lab.doubt(&direction)? {
                None => JacobianMethod::TangentMap,
                rejected => JacobianMethod::CentralDifferences { rejected },
            };
        }
        Ok(lab)
    }

    /// Coordinates: twice the degrees of freedom.
    fn coordinates(&self) -> usize {
        2 * self.frame.dof()
    }

    /// Largest noise of a coordinate at any place, in units of the frame.
    pub fn largest_noise(&self) -> f64 {
        let largest =
            (self.noise.iter().flatten()).fold(0.0_f64, |largest, noise| largest.max(*noise));
        largest.min(f64::MAX)
    }

    /// How many tasks of so many directions fit into one batch.
    pub fn tasks_in_a_batch(&self, directions: usize) -> usize {
        let columns = match self.method {
            JacobianMethod::TangentMap => 2 * tangents::TRIALS,
            JacobianMethod::CentralDifferences { .. } => richardson::STATES,
        };
        self.in_a_batch(directions * columns)
    }

    /// How many times so many columns fit into one batch.
    fn in_a_batch(&self, columns: usize) -> usize {
        (BATCH_VALUES / (columns * self.coordinates())).max(1)
    }

    fn measure_noise(&mut self, direction: &[f64]) -> Result<(), Error> {
        let count = self.in_a_batch(noise::STATES);
        let sixth_differences = noise::SixthDifferences::new();
        let mut shown = vec![Vec::with_capacity(self.places.len()); self.coordinates()];
        for first in (0..self.places.len()).step_by(count) {
            let places = first..(first + count).min(self.places.len());
            let displaced: Vec<Displaced<'_>> = (places.clone())
                .flat_map(|place| {
                    noise::offsets().map(move |by| Displaced {
                        place,
                        direction,
                        by,
                    })
                })
                .collect();
            let images = self.images(&displaced)?;
            let mut centres = vec![Vec::with_capacity(self.coordinates()); places.len()];
            for (c, shown) in shown.iter_mut().enumerate() {
                let (size, period) = (self.frame.size[c], self.frame.period[c]);
                let stencils = coordinate(&images, c).chunks_exact(noise::STATES);
                for (stencil, centre) in stencils.zip(&mut centres) {
                    let difference = |value: &f64| nearest(value - stencil[0], period) / size;
                    let differences: Vec<f64> = stencil.iter().map(difference).collect();
                    shown.push(sixth_differences.noise(&differences));
                    centre.push(stencil[0]);
                }
            }
            self.after.append(&mut centres);
        }
        self.noise = vec![vec![0.0; self.coordinates()]; self.places.len()];
        for (c, shown) in shown.iter().enumerate() {
            for (place, noise) in noise::at_each_place(shown).into_iter().enumerate() {
                let before = coordinate(&self.before, c)[place].abs();
                let magnitude = before.max(self.after[place][c].abs());
                let rounding = 2.0 * f64::EPSILON * magnitude / self.frame.size[c];
                self.noise[place][c] = noise.max(rounding);
            }
        }
        Ok(())
    }

    /// Advances displaced states.
    fn images(&mut self, displaced: &[Displaced<'_>]) -> Result<Ensemble, Error> {
        let dof = self.frame.dof();
        Ensemble::check_size(dof, displaced.len())?;
        let mut states = Ensemble::zeros(dof, displaced.len());
        let blocks = states.blocks().into_par_iter();
        let each = blocks.zip(displaced.par_chunks(Ensemble::block_width(dof)));
        each.for_each(|(mut block, displaced)| {
            for c in 0..2 * dof {
                let (from, size) = (coordinate(&self.before, c), self.frame.size[c]);
                let row = if c < dof {
                    block.q.row_mut(c)
                } else {
                    block.p.row_mut(c - dof)
                };
                for (value, state) in row.iter_mut().zip(displaced) {
                    *value = from[state.place] + state.by * state.direction[c] * size;
                }
            }
        });
        let at =
            |error: Error| error.on_the_way(|k| (self.places[displaced[k].place], BESIDE_THE_LOOP));
        self.evaluator.advance(&mut states, self.h).map_err(at)?;
        self.evaluations += displaced.len();
        Ok(states)
    }

    /// The derivatives of the step along the directions of each task, all evaluated as one ensemble.
    pub fn derivatives(&mut self, tasks: &[Task]) -> Result<Vec<Vec<Derivative>>, Error> {
        match self.method {
            JacobianMethod::TangentMap => self.tangent_derivatives(tasks),
            JacobianMethod::CentralDifferences { .. } => self.differences(tasks),
        }
    }

    /// The same by central differences.
    pub fn differences(&mut self, tasks: &[Task]) -> Result<Vec<Vec<Derivative>>, Error> {
        let displaced: Vec<Displaced<'_>> = (tasks.iter())
            .flat_map(|task| task.directions.iter().map(|d| (task.place, d)))
            .flat_map(|(place, direction)| {
                let distances = (0..richardson::LEVELS).map(richardson::distance);
                (distances.flat_map(|t| [t, -t])).map(move |by| Displaced {
                    place,
                    direction,
                    by,
                })
            })
            .collect();
        let images = self.images(&displaced)?;
        let starts = Task::starts(tasks, richardson::STATES);
        let of_task = |(task, &start): (&Task, &usize)| {
            let of_direction = |k: usize| {
                derivative(self.coordinates(), |c| {
                    let from = start + k * richardson::STATES;
                    let mut values = [0.0; richardson::STATES];
                    values
                        .copy_from_slice(&coordinate(&images, c)[from..from + richardson::STATES]);
                    Neighbourhood {
                        values,
                        centre: self.after[task.place][c],
                        period: self.frame.period[c],
                        size: self.frame.size[c],
                        noise: self.noise[task.place][c],
                    }
                })
            };
            (0..task.directions.len()).map(of_direction).collect()
        };
        Ok(tasks.par_iter().zip(&starts).map(of_task).collect())
    }
}

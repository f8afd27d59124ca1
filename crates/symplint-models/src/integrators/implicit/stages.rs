//! The slopes at all stages of one step on one block.

use symplint::Block;

use super::super::tableau::TableauPair;
use super::convergence::Convergence;
use super::field::{Place, SlopeField};

/// The unknowns of a step: velocity and force at every stage, of every sample.
///
/// A table holds 2d coordinates, positions before momenta, each as a row of samples.
pub(super) struct Stages<'a, F> {
    method: &'a TableauPair,
    field: &'a F,
    pub(super) h: f64,
    pub(super) dof: usize,
    pub(super) len: usize,
    /// The state before the step.
    pub(super) start: &'a mut [f64],
    /// Room for the state at one stage.
    pub(super) state: &'a mut [f64],
    /// Room for the slopes there.
    pub(super) fresh: &'a mut [f64],
    /// One table for each stage.
    pub(super) slopes: &'a mut [f64],
}

/// Values of scratch memory for a block of `len` samples.
pub(super) fn room(method: &TableauPair, dof: usize, len: usize) -> usize {
    (method.stages() + 3) * 2 * dof * len
}

impl<'a, F: SlopeField> Stages<'a, F> {
    /// Every stage begins with the slopes at the start of the step.
    pub(super) fn new(
        method: &'a TableauPair,
        field: &'a F,
        h: f64,
        block: &Block<'_>,
        room: &'a mut [f64],
    ) -> Self {
        let (dof, len) = (block.dof(), block.len());
        let size = 2 * dof * len;
        let (start, rest) = room.split_at_mut(size);
        let (state, rest) = rest.split_at_mut(size);
        let (fresh, slopes) = rest.split_at_mut(size);
        for i in 0..dof {
            start[i * len..][..len].copy_from_slice(block.q.row(i));
            start[(dof + i) * len..][..len].copy_from_slice(block.p.row(i));
        }
        state.copy_from_slice(start);
        let mut stages = Stages {
            method,
            field,
            h,
            dof,
            len,
            start,
            state,
            fresh,
            slopes,
        };
        stages.evaluate(Place::Start);
        for slope in stages.slopes.chunks_exact_mut(size.max(1)) {
            slope.copy_from_slice(stages.fresh);
        }
        stages
    }

    /// Values in a table.
    pub(super) fn size(&self) -> usize {
        2 * self.dof * self.len
    }

    /// Stages s.
    pub(super) fn count(&self) -> usize {
        self.method.stages()
    }

    /// The largest coordinate of every sample, or of its step by explicit Euler where that is
    /// larger.
    pub(super) fn sizes(&self) -> impl Iterator<Item = f64> + use<'_, 'a, F> {
        (0..self.len).map(|sample| {
            let coordinates = (sample..self.size()).step_by(self.len);
            coordinates.fold(0.0, |size: f64, at| {
                size.max(self.start[at].abs())
                    .max((self.h * self.fresh[at]).abs())
            })
        })
    }

    /// The coefficient with which the slope of a coordinate at stage `j` enters stage `i`.
    pub(super) fn coefficient(&self, coordinate: usize, i: usize, j: usize) -> f64 {
        if coordinate < self.dof {
            self.method.position().a(i, j)
        } else {
            self.method.momentum().a(i, j)
        }
    }

    /// Sets the state to the start plus h Σ_j (coefficient of coordinate and j) × slope j.
    pub(super) fn set_state(&mut self, coefficient: impl Fn(&Self, usize, usize) -> f64) {
        let (len, size) = (self.len, self.size());
        for coordinate in 0..2 * self.dof {
            let row = coordinate * len..(coordinate + 1) * len;
            self.state[row.clone()].copy_from_slice(&self.start[row.clone()]);
            for j in 0..self.count() {
                let factor = self.h * coefficient(self, coordinate, j);
                if factor != 0.0 {
                    let slopes = &self.slopes[j * size..][row.clone()];
                    for (state, slope) in self.state[row.clone()].iter_mut().zip(slopes) {
                        *state += factor * slope;
                    }
                }
            }
        }
    }

    /// Sets the state to that of stage `i`.
    pub(super) fn set_stage(&mut self, i: usize) {
        self.set_state(|stages, coordinate, j| stages.coefficient(coordinate, i, j));
    }

    /// Sets the state to the mean of the stages.
    pub(super) fn set_mean(&mut self) {
        let count = self.count();
        self.set_state(|stages, coordinate, j| {
            let column = (0..count).map(|i| stages.coefficient(coordinate, i, j));
            column.sum::<f64>() / count as f64
        });
    }

    /// Computes the slopes at the state, which is that at `place`.
    pub(super) fn evaluate(&mut self, place: Place) {
        let shape = (self.dof, self.len);
        self.fresh.fill(0.0);
        self.field.add_slopes(place, shape, self.state, self.fresh);
    }

    /// One fixed-point iteration: stage after stage, each with the newest slopes of the others.
    pub(super) fn sweep(&mut self, convergence: &mut Convergence<'_>) {
        let size = self.size();
        for i in 0..self.count() {
            self.set_stage(i);
            self.evaluate(Place::Stage(i));
            let slopes = &mut self.slopes[i * size..][..size];
            let rows = slopes.chunks_exact_mut(self.len.max(1));
            for (slopes, fresh) in rows.zip(self.fresh.chunks_exact(self.len.max(1))) {
                for (sample, (slope, fresh)) in slopes.iter_mut().zip(fresh).enumerate() {
                    if convergence.is_open(sample) {
                        convergence.note(sample, (self.h * (fresh - *slope)).abs());
                        *slope = *fresh;
                    }
                }
            }
        }
    }

    /// Takes the step with the slopes as they are.
    pub(super) fn finish(&mut self, block: &mut Block<'_>) {
        let weights = (self.method.position().b(), self.method.momentum().b());
        self.set_state(|stages, coordinate, j| {
            if coordinate < stages.dof {
                weights.0[j]
            } else {
                weights.1[j]
            }
        });
        for i in 0..self.dof {
            let row = |coordinate: usize| &self.state[coordinate * self.len..][..self.len];
            block.q.row_mut(i).copy_from_slice(row(i));
            block.p.row_mut(i).copy_from_slice(row(self.dof + i));
        }
    }
}

//! States that were advanced in one batch, and again in others.

use crate::error::Error;
use crate::map::{Evaluator, Witnesses};
use crate::signal::{BITS_OF_SINGLE, FEW_BITS, binary_digits, nearest};
use crate::state::{Ensemble, coordinate, coordinate_mut, period};

/// Differences below this many roundings are another order of the same arithmetic: vector instructions and
/// their remainders need not agree to the last bit.
pub(super) const MAX_ROUNDINGS_OF_ORDER: f64 = 256.0;

/// Numbers that are needed to tell.
const MIN_NUMBERS: usize = 8;

/// States, and what one call of the map made of them.
pub(super) struct Repeats {
    pub h: f64,
    /// Loop parameters, if the states are those of a loop.
    pub s: Option<Vec<f64>>,
    pub before: Ensemble,
    pub first: Ensemble,
    /// Of each row of the batch of `first`, which of the states it was, or one in its place.
    pub order: Vec<usize>,
    /// In which of these rows the states were.
    pub rows: Vec<usize>,
    /// The whole batch before the step, if other states were in other rows, and it is known.
    pub whole: Option<Ensemble>,
    /// Calls with other results.
    pub again: Vec<RepeatedCall>,
}

/// A further call.
pub(super) struct RepeatedCall {
    /// Which of the states each row was.
    pub order: Vec<usize>,
    pub after: Ensemble,
    /// How the states were advanced, as messages name it.
    pub circumstance: &'static str,
}

/// A state with two results.
#[derive(Clone, Copy)]
pub(super) struct Mismatch {
    /// Which further call.
    pub again: usize,
    /// Row of that call.
    pub row: usize,
    /// Which state.
    pub state: usize,
    /// The coordinate with the largest difference in units of its tolerance.
    pub coordinate: usize,
    pub size: f64,
    /// The difference in units of the tolerance.
    pub excess: f64,
}

impl Repeats {
    /// States of a loop, in the order of their parameters.
    pub fn of_loop(h: f64, s: Vec<f64>, before: Ensemble, first: Ensemble) -> Self {
        let order: Vec<usize> = (0..s.len()).collect();
        Repeats {
            h,
            s: Some(s),
            before,
            first,
            rows: order.clone(),
            order,
            whole: None,
            again: Vec::new(),
        }
    }

    /// States that were taken out of a batch. In other rows, one of them stands for those that were not kept.
    pub fn of_witnesses(witnesses: Witnesses) -> Self {
        let states = witnesses.rows.len();
        let mut order: Vec<usize> = (0..witnesses.batch).map(|row| row % states).collect();
        for (state, &row) in witnesses.rows.iter().enumerate() {
            order[row] = state;
        }
        Repeats {
            h: witnesses.h,
            s: None,
            before: witnesses.before,
            first: witnesses.after,
            order,
            rows: witnesses.rows,
            whole: witnesses.whole,
            again: Vec::new(),
        }
    }

    /// Advances the states in this order, in one batch.
    ///
    /// # Errors
    /// Those of the map.
    pub fn advance(&self, evaluator: &Evaluator<'_>, order: &[usize]) -> Result<Ensemble, Error> {
        let mut states = in_order(&self.before, order);
        evaluator.advance(&mut states, self.h)?;
        Ok(states)
    }

    /// The batch of the first results before the step.
    pub fn whole_batch(&self) -> Ensemble {
        match &self.whole {
            Some(whole) => whole.clone(),
            None => in_order(&self.before, &self.order),
        }
    }

    /// Advances the batch of the first results again.
    ///
    /// # Errors
    /// Those of the map.
    pub fn advance_first(&self, evaluator: &Evaluator<'_>) -> Result<Ensemble, Error> {
        let mut states = self.whole_batch();
        evaluator.advance(&mut states, self.h)?;
        Ok(states)
    }

    /// Advances the states in this order, and keeps the results if any of them differs.
    ///
    /// # Errors
    /// Those of the map.
    pub fn repeat(
        &mut self,
        evaluator: &Evaluator<'_>,
        order: Vec<usize>,
        circumstance: &'static str,
    ) -> Result<(), Error> {
        let after = self.advance(evaluator, &order)?;
        let is_same = |c: usize| {
            let first = coordinate(&self.first, c);
            let rows = coordinate(&after, c).iter().zip(&order);
            rows.into_iter().all(|(x, &state)| *x == first[state])
        };
        // Equal results take no memory: there may be millions of coordinates.
        if !(0..2 * after.dof()).all(is_same) {
            self.again.push(RepeatedCall {
                order,
                after,
                circumstance,
            });
        }
        Ok(())
    }

    /// Tells the map of a batch that will be advanced.
    pub fn prefetch(&self, evaluator: &Evaluator<'_>, order: &[usize]) {
        if evaluator.has_prefetch() {
            evaluator.prefetch(&mut in_order(&self.before, order), self.h);
        }
    }

    /// The largest value of a coordinate.
    pub fn magnitude(&self, c: usize) -> f64 {
        let row = coordinate(&self.first, c);
        row.iter().fold(0.0, |most: f64, x| most.max(x.abs()))
    }

    /// What rounding in double precision makes of each coordinate at most.
    pub fn roundings(&self) -> Vec<f64> {
        let of = |c: usize| MAX_ROUNDINGS_OF_ORDER * f64::EPSILON * self.magnitude(c);
        (0..2 * self.first.dof()).map(of).collect()
    }

    /// The relative distance of neighbouring numbers in which the map computes: as its results show it, or the search for
    /// single precision inside.
    pub fn unit(&self, evaluator: &Evaluator<'_>) -> f64 {
        match evaluator.rounding_inside() {
            Some(_) => self
                .unit_of_results()
                .max(0.5f64.powi(BITS_OF_SINGLE as i32 - 1)),
            None => self.unit_of_results(),
        }
    }

    /// The relative distance of neighbouring numbers, as results show it.
    pub fn unit_of_results(&self) -> f64 {
        let values = (0..2 * self.first.dof()).flat_map(|c| coordinate(&self.first, c));
        let digits = values
            .map(|x| binary_digits(*x))
            .filter(|digits| *digits > 0);
        let (count, most) = digits.fold((0, 0), |(count, most), digits| {
            (count + 1, digits.max(most))
        });
        match count >= MIN_NUMBERS && most <= FEW_BITS {
            true => 0.5f64.powi(most - 1),
            false => f64::EPSILON,
        }
    }

    /// States whose results differ by more than a tolerance of each coordinate, in the order of the calls.
    pub fn mismatches(&self, evaluator: &Evaluator<'_>, tolerances: &[f64]) -> Vec<Mismatch> {
        let mut found = Vec::new();
        for (again, call) in self.again.iter().enumerate() {
            for (row, &state) in call.order.iter().enumerate() {
                let of = |c: usize| {
                    let size = self.difference(evaluator, c, state, (&call.after, row));
                    (size > tolerances[c]).then_some(Mismatch {
                        again,
                        row,
                        state,
                        coordinate: c,
                        size,
                        excess: size / tolerances[c],
                    })
                };
                let differing = (0..2 * self.first.dof()).filter_map(of);
                found.extend(differing.max_by(|a, b| a.excess.total_cmp(&b.excess)));
            }
        }
        found
    }

    /// By how much a coordinate of a state differs in another call.
    pub fn difference(
        &self,
        evaluator: &Evaluator<'_>,
        c: usize,
        state: usize,
        (after, row): (&Ensemble, usize),
    ) -> f64 {
        let difference = coordinate(after, c)[row] - coordinate(&self.first, c)[state];
        nearest(difference, period(evaluator.coordinates(), c)).abs()
    }
}

/// Some states in this order.
pub(super) fn in_order(of: &Ensemble, order: &[usize]) -> Ensemble {
    let mut states = Ensemble::zeros(of.dof(), order.len());
    for c in 0..2 * of.dof() {
        let row = coordinate(of, c);
        let mut block = states.block();
        let to = coordinate_mut(&mut block, c);
        (to.iter_mut().zip(order)).for_each(|(to, &state)| *to = row[state]);
    }
    states
}

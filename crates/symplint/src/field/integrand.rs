//! A force along a loop: its power, of which the integral over s is the loop integral.
//!
//! The velocity of the loop is known exactly, so that ∮ F·dq = ∫ F(q(s))·q'(s) ds needs one number of each state. Everything
//! that follows works with these numbers, and does not depend on how many degrees of freedom there are.

use super::FieldKind;
use super::limits::MAX_VALUES_PER_CALL;
use crate::error::{Error, StateLocation};
use crate::loops::{FourierLoop, Loop};
use crate::map::Evaluator;
use crate::signal::CompensatedSum;
use crate::state::{Ensemble, coordinate};

/// The one-form F·dq, or f_q·dp − f_p·dq with the weights of the momenta, in units of the loops: component c times the radius
/// of coordinate c, over [`unit`](Self::unit).
pub(super) struct Integrand<'a> {
    pub evaluator: &'a Evaluator<'a>,
    pub kind: FieldKind,
    /// How far loops reach in each coordinate; positions first.
    pub radius: Vec<f64>,
    /// The largest component at the centre, times its radius; 1 if it is zero there.
    pub unit: f64,
}

/// Sums over the states of a loop, apart from the power.
#[derive(Clone, Default)]
pub(super) struct Moments {
    states: usize,
    /// The form at the first state.
    reference: Vec<f64>,
    /// Sums of the differences to it.
    differences: Vec<f64>,
    squared_differences: f64,
    squared_form: f64,
    squared_velocity: f64,
    squared_terms: f64,
    /// The sum of p·q' with the weights.
    action: f64,
}

impl Moments {
    /// The root mean square of the distance of the form from its mean.
    pub fn deviation(&self) -> f64 {
        let count = self.states.max(1) as f64;
        let of_mean: f64 = self.differences.iter().map(|x| (x / count).powi(2)).sum();
        (self.squared_differences / count - of_mean).max(0.0).sqrt()
    }

    /// The root mean square of the form.
    pub fn size(&self) -> f64 {
        (self.squared_form / self.states.max(1) as f64).sqrt()
    }

    /// The root mean square of the velocity of the loop.
    pub fn speed(&self) -> f64 {
        (self.squared_velocity / self.states.max(1) as f64).sqrt()
    }

    /// The root mean square over the states of √Σ (component × velocity)²: what independent roundings are relative to.
    pub fn terms(&self) -> f64 {
        (self.squared_terms / self.states.max(1) as f64).sqrt()
    }

    /// ∮ p·dq with the weights.
    pub fn action(&self) -> f64 {
        self.action / self.states.max(1) as f64
    }
}

impl Integrand<'_> {
    /// Coordinates: positions, and momenta of a field.
    pub fn coordinates(&self) -> usize {
        self.radius.len()
    }

    /// Coordinates that loops move.
    pub fn moving(&self) -> usize {
        self.radius.iter().filter(|&&radius| radius > 0.0).count()
    }

    /// The coordinate whose rate is component c of the form, and its sign with the weight.
    fn source(&self, c: usize) -> (usize, f64) {
        let dof = self.evaluator.dof();
        match self.kind {
            // A force is returned as momenta.
            FieldKind::Force => (dof + c, 1.0),
            FieldKind::Field => {
                let weight = self.evaluator.coordinates().weight(c % dof);
                match c < dof {
                    true => (dof + c, -weight),
                    false => (c - dof, weight),
                }
            }
        }
    }

    /// The form at some states, in place: the rows of the result are in units of the loops, component by component.
    ///
    /// # Errors
    /// Those of the force.
    pub fn form(&self, mut states: Ensemble) -> Result<Vec<Vec<f64>>, Error> {
        self.evaluator.advance(&mut states, 1.0)?;
        Ok(self.rows(&states))
    }

    fn rows(&self, rates: &Ensemble) -> Vec<Vec<f64>> {
        let row = |c: usize| {
            let (source, sign) = self.source(c);
            let factor = sign * self.radius[c] / self.unit;
            let row = coordinate(rates, source).iter();
            row.map(|x| factor * x).collect()
        };
        (0..self.coordinates()).map(row).collect()
    }

    /// The power at the parameters `s` of a loop; what else its states show is added to `moments`. With `velocity_at`, the
    /// velocity of the loop at that parameter is taken at all of them.
    ///
    /// # Errors
    /// Those of the force, with the parameter of the state; if the power is beyond the range of doubles.
    pub fn power(
        &self,
        phase_loop: &FourierLoop,
        s: &[f64],
        velocity_at: Option<f64>,
        mut moments: Option<&mut Moments>,
    ) -> Result<Vec<f64>, Error> {
        let dof = phase_loop.dof();
        let at_once = (MAX_VALUES_PER_CALL / (2 * dof).max(1)).max(1);
        let mut power = Vec::with_capacity(s.len());
        for s in s.chunks(at_once) {
            Ensemble::check_size(dof, s.len())?;
            let mut states = Ensemble::zeros(dof, s.len());
            phase_loop.sample(s, &mut states.block());
            let mut velocity = Ensemble::zeros(dof, s.len());
            let at = velocity_at.map_or_else(|| s.to_vec(), |at| vec![at; s.len()]);
            phase_loop.velocity(&at, &mut velocity.block());
            if let Some(moments) = moments.as_deref_mut() {
                self.add_action(&states, &velocity, moments);
            }
            (self.evaluator.advance(&mut states, 1.0))
                .map_err(|error| error.at(|sample| StateLocation::RandomLoop(s[sample])))?;
            power.extend(self.add_states(&states, &velocity, moments.as_deref_mut()));
        }
        match power.iter().find(|power| !power.is_finite()) {
            Some(&value) => Err(Error::Overflow { dof: 0, value }),
            None => Ok(power),
        }
    }

    fn add_action(&self, states: &Ensemble, velocity: &Ensemble, moments: &mut Moments) {
        if self.kind == FieldKind::Force {
            return;
        }
        for i in 0..states.dof() {
            let weight = self.evaluator.coordinates().weight(i);
            let terms = states.p().row(i).iter().zip(velocity.q().row(i));
            moments.action += weight * terms.map(|(p, q)| p * q).sum::<f64>();
        }
    }

    /// The power of each state.
    fn add_states(
        &self,
        rates: &Ensemble,
        velocity: &Ensemble,
        mut moments: Option<&mut Moments>,
    ) -> Vec<f64> {
        let count = rates.samples();
        let mut power = vec![CompensatedSum::default(); count];
        if let Some(moments) = moments.as_deref_mut() {
            moments.states += count;
            moments.reference.resize(self.coordinates(), f64::NAN);
            moments.differences.resize(self.coordinates(), 0.0);
        }
        for c in (0..self.coordinates()).filter(|&c| self.radius[c] > 0.0) {
            let (source, sign) = self.source(c);
            let factor = sign * self.radius[c] / self.unit;
            let of_form = coordinate(rates, source);
            let of_velocity = coordinate(velocity, c);
            for (sum, (rate, velocity)) in power.iter_mut().zip(of_form.iter().zip(of_velocity)) {
                sum.add(factor * rate * (velocity / self.radius[c]));
            }
            let Some(moments) = moments.as_deref_mut() else {
                continue;
            };
            if moments.reference[c].is_nan() {
                moments.reference[c] = factor * of_form[0];
            }
            for (rate, velocity) in of_form.iter().zip(of_velocity) {
                let (form, velocity) = (factor * rate, velocity / self.radius[c]);
                let difference = form - moments.reference[c];
                moments.differences[c] += difference;
                moments.squared_differences += difference * difference;
                moments.squared_form += form * form;
                moments.squared_velocity += velocity * velocity;
                moments.squared_terms += (form * velocity).powi(2);
            }
        }
        power.iter().map(CompensatedSum::total).collect()
    }
}

//! Loop integral and energy against time.

use serde::Serialize;

use crate::error::{Error, StateLocation};
use crate::loops::Loop;
use crate::map::{EvaluationCount, Evaluator, TimeAdvance};
use crate::rules::Defect;
use crate::rules::{LoopIntegral, Rule};
use crate::state::Ensemble;
use crate::state::Rows;

/// A quantity of single states, such as the energy: writes one value for each sample, from
/// positions and momenta of d rows each.
pub type Observable<'a> = &'a (dyn Fn(Rows<'_>, Rows<'_>, &mut [f64]) + Sync);

/// The orbit whose energy is followed.
#[derive(Clone, Copy)]
pub struct Orbit<'a> {
    /// Initial positions, one for each degree of freedom.
    pub q: &'a [f64],
    /// Initial momenta.
    pub p: &'a [f64],
    /// The energy.
    pub energy: Observable<'a>,
}

/// Many steps of one size: Barham & Burby, figures 1 and 2.
///
/// ```
/// use symplint::{Circle, PerSample, Rule, Trace};
///
/// let spring = PerSample::new(1, |h, q, p| {
///     q[0] += h * p[0];
///     p[0] -= h * q[0];
/// });
/// let trace = Trace { rule: Rule::Pseudospectral, samples: 64, step_size: 0.1, steps: 100, snapshots: vec![] };
/// let circle = Circle::new(vec![1.0], vec![0.0], 0.5)?;
/// let record = trace.run(&spring, &circle, None)?;
/// assert!(record.points.iter().all(|point| point.defect < 1e-13));
/// # Ok::<(), symplint::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Trace {
    /// The rule.
    pub rule: Rule,
    /// Samples N_s, 3 or more.
    pub samples: usize,
    /// Step size h.
    pub step_size: f64,
    /// Number of steps.
    pub steps: usize,
    /// Keep the whole loop after this number of steps (0 is the initial loop).
    pub snapshots: Vec<usize>,
}

/// The loop after some steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TracePoint {
    /// Steps taken.
    pub step: usize,
    /// Time: steps × h.
    pub time: f64,
    /// ∮ p·dq.
    pub integral: f64,
    /// (I(t) − I(0)) / |I(0)|.
    pub signed_defect: f64,
    /// |I(t) − I(0)| / |I(0)|.
    pub defect: f64,
    /// Estimate of the quadrature error of both integrals, relative to |I(0)|.
    pub quadrature_error: Option<f64>,
    /// Estimate of the round-off in the defect, relative to |I(0)|.
    pub roundoff: f64,
    /// Energy of the orbit, if one is followed.
    pub energy: Option<f64>,
    /// (H(t) − H(0)) / |H(0)|, or H(t) − H(0) where H(0) is 0.
    pub energy_error: Option<f64>,
}

/// The record of a [`Trace`].
#[derive(Clone, Debug)]
pub struct TraceRecord {
    /// One point for each step, the initial loop first.
    pub points: Vec<TracePoint>,
    /// The loops asked for, with the number of steps taken.
    pub snapshots: Vec<(usize, Ensemble)>,
}

impl Trace {
    /// Advances the loop step by step, on the threads of the current Rayon pool.
    ///
    /// # Errors
    /// If map, loop and orbit do not fit, the step size is zero or not finite, the loop
    /// encloses no area, or the map fails or returns states that are not finite.
    pub fn run(
        &self,
        map: &dyn TimeAdvance,
        phase_loop: &dyn Loop,
        orbit: Option<Orbit<'_>>,
    ) -> Result<TraceRecord, Error> {
        self.run_watched(map, phase_loop, orbit, &|_| {})
    }

    /// The same; `watch` receives each point.
    ///
    /// # Errors
    /// Those of [`run`](Self::run).
    pub fn run_watched(
        &self,
        map: &dyn TimeAdvance,
        phase_loop: &dyn Loop,
        orbit: Option<Orbit<'_>>,
        watch: &dyn Fn(&TracePoint),
    ) -> Result<TraceRecord, Error> {
        let count = EvaluationCount::unlimited();
        let evaluator = Evaluator::new(map, &count)?;
        self.run_with(&evaluator, phase_loop, orbit, &mut |point, _| watch(point))
    }

    /// The same with the evaluations counted by `evaluator`; `watch` receives the loop, too.
    pub(crate) fn run_with(
        &self,
        evaluator: &Evaluator<'_>,
        phase_loop: &dyn Loop,
        orbit: Option<Orbit<'_>>,
        watch: &mut dyn FnMut(&TracePoint, &Ensemble),
    ) -> Result<TraceRecord, Error> {
        if !self.step_size.is_finite() || self.step_size == 0.0 {
            return Err(Error::OutOfRange {
                what: "step size",
                value: self.step_size,
                remedy: "give a finite step size that is not zero",
            });
        }
        let coordinates = evaluator.coordinates();
        let mut follower = orbit
            .map(|orbit| Follower::new(orbit, evaluator.dof()))
            .transpose()?;
        let mut ensemble = Ensemble::sample(phase_loop, self.samples)?;
        let initial = LoopIntegral::in_coordinates(&ensemble, &self.rule, coordinates)?;
        let mut record = TraceRecord {
            points: Vec::new(),
            snapshots: Vec::new(),
        };
        for step in 0..=self.steps {
            if step > 0 {
                let in_step = |error| Error::InStep {
                    step,
                    error: Box::new(error),
                };
                (evaluator.advance(&mut ensemble, self.step_size)).map_err(in_step)?;
                if let Some(follower) = &mut follower {
                    (evaluator.advance(&mut follower.state, self.step_size))
                        .map_err(|error| in_step(error.at(|_| StateLocation::Orbit)))?;
                }
            }
            let integral = LoopIntegral::in_coordinates(&ensemble, &self.rule, coordinates)?;
            let defect = Defect::between(&initial, &integral)?;
            let energy = follower.as_ref().map(Follower::energy);
            let point = TracePoint {
                step,
                time: step as f64 * self.step_size,
                integral: integral.value,
                signed_defect: defect.signed,
                defect: defect.magnitude(),
                quadrature_error: defect.quadrature_error,
                roundoff: defect.roundoff,
                energy: energy.map(|(value, _)| value),
                energy_error: energy.map(|(_, error)| error),
            };
            watch(&point, &ensemble);
            record.points.push(point);
            if self.snapshots.contains(&step) {
                record.snapshots.push((step, ensemble.clone()));
            }
        }
        Ok(record)
    }
}

/// One state that goes along with the loop.
struct Follower<'a> {
    observable: Observable<'a>,
    state: Ensemble,
    initial: f64,
}

impl<'a> Follower<'a> {
    fn new(orbit: Orbit<'a>, dof: usize) -> Result<Self, Error> {
        Error::check_length("initial q of the orbit", dof, orbit.q.len())?;
        Error::check_length("initial p of the orbit", dof, orbit.p.len())?;
        let mut state = Ensemble::zeros(dof, 1);
        let mut block = state.block();
        for i in 0..dof {
            block.q.row_mut(i)[0] = orbit.q[i];
            block.p.row_mut(i)[0] = orbit.p[i];
        }
        (state.check_finite(None)).map_err(|error| error.at(|_| StateLocation::Orbit))?;
        let mut follower = Follower {
            observable: orbit.energy,
            state,
            initial: 0.0,
        };
        follower.initial = follower.value();
        Ok(follower)
    }

    fn value(&self) -> f64 {
        let mut value = [0.0];
        (self.observable)(self.state.q(), self.state.p(), &mut value);
        value[0]
    }

    /// The energy, and its change relative to the initial one.
    fn energy(&self) -> (f64, f64) {
        let value = self.value();
        let size = self.initial.abs();
        let change = value - self.initial;
        (value, if size > 0.0 { change / size } else { change })
    }
}

//! Properties of a map that a few samples show, apart from loop integrals.

mod held;
mod motion;
mod precision;
mod windings;

pub(crate) use precision::of_grain;
pub(crate) use windings::wound;

use crate::error::Error;
use crate::evidence::{HeldCoordinate, MIN_SAMPLES_OF_SHAPE, Motion, OutputPrecision};
use crate::loops::FEW_SAMPLES;
use crate::rules::Subject;
use crate::state::{Coordinates, Ensemble};
use held::ConstantRuns;
pub(crate) use held::is_set;
use motion::Motions;
use precision::Precision;

/// Surveys the map by samples of a loop that were advanced.
pub(crate) fn of_samples(subject: Subject<'_>, after: &Ensemble) -> SampleSurvey {
    let after_step = after.thinned(FEW_SAMPLES);
    let samples = after_step.samples();
    let every = after.samples().div_ceil(FEW_SAMPLES);
    let s: Vec<f64> = (0..samples)
        .map(|k| (k * every) as f64 / after.samples() as f64)
        .collect();
    let mut before = Ensemble::zeros(after.dof(), samples);
    subject.phase_loop.sample(&s, &mut before.block());
    let mut look = SurveySums::new(after.dof());
    look.held = Some(ConstantRuns::new(after.dof()));
    look.add(subject, &before, &after_step);
    look.seen(subject)
}

/// Surveys the map by a few samples, advanced for that alone: if there are too many degrees of freedom for samples to stay in
/// memory.
///
/// # Errors
/// Those of the map.
pub(crate) fn of_few_samples(subject: Subject<'_>, h: f64) -> Result<SampleSurvey, Error> {
    let mut look = SurveySums::new(subject.dof());
    Ensemble::in_parts(subject.phase_loop, MIN_SAMPLES_OF_SHAPE, |before| {
        let mut after = before.clone();
        subject.evaluator.advance(&mut after, h)?;
        look.add(subject, &before, &after);
        Ok(())
    })?;
    Ok(look.seen(subject))
}

/// How a step moved loops that another code advanced.
pub(crate) fn motion(
    before: &Ensemble,
    after: &Ensemble,
    coordinates: &Coordinates,
) -> Option<Motion> {
    let mut motions = Motions::new(before.dof());
    let [before, after] = [before, after].map(|ensemble| ensemble.thinned(FEW_SAMPLES));
    motions.add(&before, &after, coordinates);
    motions.value(coordinates)
}

/// What samples before and after one step show.
#[derive(Clone, Copy, Default)]
pub(crate) struct SampleSurvey {
    pub motion: Option<Motion>,
    pub output_precision: Option<OutputPrecision>,
    /// Whether all samples came out at one state.
    pub one_state: bool,
    /// A coordinate that the step sets to one value at some of them.
    pub held: Option<HeldCoordinate>,
}

struct SurveySums {
    motions: Motions,
    precision: Precision,
    /// Not of few samples: in many degrees of freedom it takes as much memory as some dozen states.
    held: Option<ConstantRuns>,
}

impl SurveySums {
    fn new(dof: usize) -> Self {
        SurveySums {
            motions: Motions::new(dof),
            precision: Precision::new(dof),
            held: None,
        }
    }

    fn add(&mut self, subject: Subject<'_>, before: &Ensemble, after: &Ensemble) {
        self.motions.add(before, after, subject.coordinates());
        self.precision.add(before, after);
        if let Some(held) = &mut self.held {
            held.add(before, after);
        }
    }

    fn seen(&self, subject: Subject<'_>) -> SampleSurvey {
        SampleSurvey {
            motion: self.motions.value(subject.coordinates()),
            output_precision: self.precision.value(),
            one_state: self.precision.is_one_state(),
            held: self.held.as_ref().and_then(ConstantRuns::value),
        }
    }
}

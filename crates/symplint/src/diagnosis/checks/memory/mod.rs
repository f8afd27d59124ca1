//! Whether results depend on earlier calls, on other rows or on random numbers, and how they are rounded.

mod ignored_step_size;
mod inner_precision;
mod periods;
mod purity;
mod repeats;
mod rounding;
mod scatter;

pub(super) use periods::wrong_period;
pub(in crate::diagnosis) use purity::cost_again;
pub(super) use purity::{Noise, check_again};

use super::{GivenLoop, Runner};
use crate::breaks::Break;
use crate::error::Error;
use crate::evidence::{LoopBreak, Scatter, ScatterKind};
use crate::map::{Difference, Evaluator};
use crate::rules::Subject;
use ignored_step_size::ignores_step_size;
use inner_precision::rounding_inside;
use purity::check_purity;

/// If a map wraps a coordinate, the other one of its degree of freedom jumps by at most this part of the jump: it is continuous, and
/// the ends of a break are a rounding apart. Conventional.
const MAX_PARTNER_JUMP_AT_WRAP: f64 = 1e-6;

impl Runner<'_> {
    /// Tests whether results depend on earlier calls, and how they are rounded. The error of the map near the given loop, if it fails
    /// there: if the given loop fails, too, its samples tell more of where that is.
    pub(super) fn look_first(&mut self, subject: Subject<'_>) -> Result<Option<Error>, Error> {
        let Subject {
            evaluator,
            phase_loop,
        } = subject;
        let (samples, witnesses) = (self.plan.purity_samples, self.plan.witnesses);
        evaluator.keep_witnesses(witnesses);
        self.count.reserve(cost_again(witnesses));
        match rounding_inside(subject, self.largest) {
            Ok(None) => {}
            Ok(Some(grains)) => {
                evaluator.note_rounding_inside(grains);
                self.evidence.survey.single_inside = true;
            }
            // Samples of the loop will show it, or miss it.
            Err(error) if error.is_of_map() => {}
            Err(error) => return Err(error),
        }
        match check_purity(evaluator, phase_loop, self.largest, samples) {
            Ok(noise) => {
                self.note_noise(evaluator, noise);
                Ok(None)
            }
            // One failure is described as well as possible, further ones at little cost.
            Err(error) if error.is_of_map() && self.failed.is_empty() => Ok(Some(error)),
            Err(error) => Err(error),
        }
    }

    /// Keeps by how much results of one state differ: the rules allow for it.
    pub(super) fn note_noise(&mut self, evaluator: &Evaluator<'_>, noise: Option<Noise>) {
        if noise == self.noise {
            return;
        }
        let scatter = noise.as_ref().and_then(Noise::scatter);
        self.evidence.survey.scatter = scatter;
        // Random numbers look like single precision.
        self.evidence.survey.single_inside &= !scatter.is_some_and(|of| of.is_random());
        if let Some(noise) = &noise {
            evaluator.note_rounding_inside(noise.units());
            if let Some(deviations) = noise.deviations() {
                evaluator.note_noise(deviations);
            }
        }
        self.noise = noise;
    }

    /// Advances states of the batches before once more, and one of them by steps of other sizes.
    pub(super) fn look_again(&mut self, evaluator: &Evaluator<'_>) -> Result<(), Error> {
        self.count.reserve(0);
        let noise = check_again(evaluator, false, self.noise.clone())?;
        self.note_noise(evaluator, noise);
        self.note_difference(evaluator);
        let sizes: Vec<f64> = self.sizes().collect();
        self.evidence.survey.ignores_step_size = ignores_step_size(evaluator, &sizes)?;
        Ok(())
    }

    /// Keeps the largest difference between results for one state that the map knows, or that a rule has met.
    fn note_difference(&mut self, evaluator: &Evaluator<'_>) {
        let known = evaluator.difference().map(|of| (of, ScatterKind::Noise));
        let met = evaluator.met_difference();
        let met = met.map(|of| (of, ScatterKind::RandomNumbers));
        for (difference, kind) in known.into_iter().chain(met) {
            let Difference {
                coordinate,
                dof,
                size,
            } = difference;
            let scatter = &mut self.evidence.survey.scatter;
            let overrides = |of: Scatter| match kind {
                ScatterKind::RandomNumbers => !of.is_random() || size > of.size,
                _ => !of.is_random() && size > of.size,
            };
            if scatter.is_none_or(overrides) {
                *scatter = Some(Scatter {
                    coordinate,
                    dof,
                    size,
                    kind,
                });
            }
        }
        // Random numbers look like single precision.
        let survey = &mut self.evidence.survey;
        survey.single_inside &= !survey.scatter.is_some_and(|of| of.is_random());
    }

    /// Checks that no loop needs a period that is not one of the map: a given loop that winds, or a loop that breaks in periodic
    /// coordinates alone, because the map wraps them by another period. (A kick, a wall or a solver also changes the other
    /// coordinate of the degree of freedom.)
    pub(super) fn check_periods(
        &mut self,
        subject: Subject<'_>,
        _: &GivenLoop<'_>,
    ) -> Result<(), Error> {
        let coordinates = subject.coordinates();
        let Some(wrong) = self.evidence.survey.wrong_period else {
            return Ok(());
        };
        let is_wrapped = |at: &LoopBreak| {
            let Break {
                dof,
                jump_q,
                jump_p,
                ..
            } = at.found;
            let alone =
                |jump: f64, other: f64| other.abs() <= MAX_PARTNER_JUMP_AT_WRAP * jump.abs();
            coordinates.period(dof) > 0.0 && alone(jump_q, jump_p)
                || coordinates.momentum_period(dof) > 0.0 && alone(jump_p, jump_q)
        };
        let winds = self.evidence.loops.iter().any(|found| found.winds);
        match winds || self.evidence.breaks.iter().any(is_wrapped) {
            true => Err(wrong.into_error()),
            false => Ok(()),
        }
    }
}

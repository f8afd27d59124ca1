//! What features that the samples of a loop do not resolve may change.

use super::constraint::singular_cost;
use super::{GivenLoop, Runner, if_possible};
use crate::diagnosis::limits::{DISPLACEMENT_AT_FEATURE, DIVISOR_OF_ROUGHNESS, MAX_FEATURES};
use crate::diagnosis::plan::fits;
use crate::diagnosis::resolve::features::roughest_sample;
use crate::diagnosis::resolve::refined_samples::RefinedSamples;
use crate::error::Error;
use crate::evidence::{LoopKind, StepEvidence};
use crate::jacobian::{JacobianEvidence, JacobianTest};
use crate::loops::FEW_SAMPLES;
use crate::map::Feature;
use crate::rules::Subject;

/// A place at which the Jacobian is tested once more.
enum JacobianPlace {
    Feature(Feature),
    /// Where samples of the loop are roughest after a step of this size.
    Roughest {
        h: f64,
    },
}

impl Runner<'_> {
    /// Keeps the features that were noted of a loop.
    pub(super) fn keep_features(&mut self, loop_index: usize, subject: Subject<'_>) {
        let noted = subject.evaluator.features().into_iter();
        self.features
            .extend(noted.map(|feature| (loop_index, feature)));
    }

    /// If the Jacobian has no defect at its points, tests it at features, and at the roughest place of a loop whose integral
    /// changes: a defect may be in a narrow strip. A test of one state clears no feature: unless a defect is found, the errors of the given
    /// loop are widened.
    pub(super) fn test_features(
        &mut self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
    ) -> Result<(), Error> {
        let jacobian = self.evidence.jacobian.as_ref();
        // A defect that the Jacobian shows needs no bound.
        if jacobian.is_some_and(JacobianEvidence::shows_defect) {
            return Ok(());
        }
        let places = match jacobian {
            Some(_) => self.places(),
            None => Vec::new(),
        };
        for (index, place) in places {
            let found = if_possible(self.jacobian_at(subject, given, index, place))?;
            if let Some(found) = found.filter(JacobianEvidence::shows_defect) {
                self.evidence.jacobian = Some(found);
                return Ok(());
            }
        }
        self.bound_by_features();
        Ok(())
    }

    /// The first feature of each loop, then others, and the roughest place of the loop that changes most, each with the number of its loop.
    fn places(&self) -> Vec<(usize, JacobianPlace)> {
        let is_first = |k: usize, is_alike: &dyn Fn(&(usize, Feature)) -> bool| {
            !self.features[..k].iter().any(is_alike)
        };
        let mut order: Vec<usize> = (0..self.features.len())
            .filter(|&k| {
                let (index, feature) = self.features[k];
                is_first(k, &|(of, other)| *of == index && other.s == feature.s)
            })
            .collect();
        order.sort_by_key(|&k| !is_first(k, &|(of, _)| *of == self.features[k].0));
        let features = order.into_iter().map(|k| self.features[k]);
        let features = features.map(|(index, feature)| (index, JacobianPlace::Feature(feature)));
        let changed = self.changed_loop();
        let roughest = changed.map(|(found, step)| {
            let h = self.size_of(step);
            (found.index, JacobianPlace::Roughest { h })
        });
        features.take(MAX_FEATURES).chain(roughest).collect()
    }

    /// The Jacobian at a place of a loop, and what a defect becomes at a second step size; `None` if too few evaluations are left.
    fn jacobian_at(
        &mut self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
        index: usize,
        place: JacobianPlace,
    ) -> Result<Option<JacobianEvidence>, Error> {
        let found = self.evidence.loops.iter().find(|of| of.index == index);
        let Some(found) = found.filter(|found| found.kind != LoopKind::Image) else {
            return Ok(None);
        };
        let samples = (found.samples / DIVISOR_OF_ROUGHNESS).max(FEW_SAMPLES);
        let (dof, has_tangent) = (subject.dof(), subject.evaluator.has_tangent());
        let left = self.left_for_features(dof);
        let Some(one) = JacobianTest::within(left, dof, has_tangent) else {
            return Ok(None);
        };
        let one = JacobianTest { points: 1, ..one };
        let cost = one.evaluations(dof, has_tangent);
        let is_affordable = match place {
            JacobianPlace::Feature(_) => cost <= left,
            JacobianPlace::Roughest { .. } => cost + samples <= left && fits(dof, samples),
        };
        if !is_affordable {
            return Ok(None);
        }
        let random = self
            .diagnostic
            .random_loop_of(found, &given.size, subject)?;
        let subject = subject.on(random.as_ref());
        subject.evaluator.begin_loop();
        let Feature { s, h } = match place {
            JacobianPlace::Feature(feature) => feature,
            JacobianPlace::Roughest { h } => {
                let refined = RefinedSamples::new(subject, samples, h)?;
                let s = roughest_sample(subject, &refined);
                Feature { s, h }
            }
        };
        // Further groups of degrees of freedom, and tracing a defect, take as much again. A tangent map that is wrong is replaced by differences.
        let of_differences = one.evaluations(dof, false);
        let further = cost * (1 + given.size.groups.len().max(1)) + of_differences;
        let left = self.left_for_features(dof);
        let one = JacobianTest {
            budget: left.clamp(cost, further),
            ..one
        };
        let (evaluator, phase_loop) = (subject.evaluator, subject.phase_loop);
        let size = given.size.times(DISPLACEMENT_AT_FEATURE);
        let found = one.run_at(evaluator, phase_loop, &size, h, vec![s])?;
        if found.shows_defect() {
            self.evidence.jacobian_decay = self.jacobian_decay(&one, subject, &size, &found);
        }
        Ok(Some(JacobianEvidence {
            loop_index: index,
            ..found
        }))
    }

    /// Evaluations left but for those that show whether the map projects onto a manifold. A loop need not be contracted if the Jacobian
    /// shows the defect.
    pub(super) fn left_for_features(&self, dof: usize) -> usize {
        self.count.left().saturating_sub(singular_cost(dof))
    }

    /// A feature that a sample has met at one step size is on the given loop at larger ones as well, whether a sample has met it or not:
    /// what it may change falls at least as h. Their errors are as large as that.
    fn bound_by_features(&mut self) {
        let steps = &mut self.evidence.loops[0].steps;
        for (_, feature) in self.features.iter().filter(|(index, _)| *index == 0) {
            let at = |step: &&StepEvidence| step.step_size == Some(feature.h);
            let Some(bound) = steps.iter().find(at).map(StepEvidence::bound) else {
                continue;
            };
            for step in steps.iter_mut() {
                let growth = step.step_size.map_or(0.0, |h| (h / feature.h).abs());
                // A change that is significant is known, whatever else the feature adds.
                if growth > 1.0 && !step.is_significant() {
                    let error = &mut step.defect.quadrature_error;
                    *error = (error.filter(|_| bound.is_finite()))
                        .map(|error| error.max(growth * bound));
                }
            }
        }
    }
}

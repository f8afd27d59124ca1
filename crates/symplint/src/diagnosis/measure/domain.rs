//! Whether what has a defect lies in the domain of the map.

use super::{Given, Run, of_the_map};
use crate::diagnosis::features::roughest_sample;
use crate::diagnosis::limits::{FEWEST_OF_ROUGHNESS, MOST_FEATURES, PART_OF_SAMPLES};
use crate::diagnosis::localise::{FEWEST_OF_HALVING, MOST_OF_A_BOUNDARY, contraction};
use crate::diagnosis::refined_samples::RefinedSamples;
use crate::error::Error;
use crate::evidence::{LoopEvidence, LoopKind, Omission, WEAKEST_BOUND};
use crate::jacobian::{JacobianEvidence, JacobianTest};
use crate::map::Feature;
use crate::rules::Subject;
use crate::survey;

/// Where the Jacobian is tested once more.
enum Place {
    Feature(Feature),
    /// Where this number of samples is roughest after a step of this size.
    Roughest {
        samples: usize,
        h: f64,
    },
}

impl Run<'_> {
    /// Where something has a defect, looks whether it lies outside the domain of the map: whether the map projects onto a
    /// manifold. If the given loop has one, its image, which lies on the manifold, is advanced, too.
    pub(super) fn look_for_manifold(
        &mut self,
        subject: Subject<'_>,
        given: &Given<'_>,
    ) -> Result<(), Error> {
        let suspect = |found: &LoopEvidence| {
            !found.winds && (found.failure.is_some() || found.shows_defect())
        };
        let by_jacobian = self.evidence.jacobian.as_ref();
        let shown = self.evidence.loops.iter().any(suspect)
            || by_jacobian.is_some_and(JacobianEvidence::shows_defect);
        let of_given = self.evidence.loops[0].shows_defect();
        // With a projection all loops lie on the manifold.
        let projected = subject.evaluator.constraint().is_some();
        if !shown || projected || given.probe.is_beyond_memory() {
            return Ok(());
        }
        if self.count.left() < survey::singular_cost(subject.dof()) {
            self.omit(Omission::ManifoldBudget);
            return Ok(());
        }
        let start = self.count.made();
        match survey::singular_jacobian(subject, &given.size, self.largest) {
            Ok(found) => self.evidence.survey.singular = found,
            // Beside the loop the map need not be defined.
            Err(error) if of_the_map(&error) => {}
            Err(error) => return Err(error),
        }
        if self.evidence.survey.singular.is_some() && of_given {
            self.image_loop(subject)?;
        }
        self.evidence.evaluations.manifold = self.count.made() - start;
        Ok(())
    }

    /// If something shows a defect, tests whether the symplectic form of non-canonical coordinates is degenerate.
    pub(super) fn look_for_leaf(
        &mut self,
        subject: Subject<'_>,
        given: &Given<'_>,
    ) -> Result<(), Error> {
        let shows = |found: &LoopEvidence| found.shows_defect() || found.is_broken();
        let by_jacobian = self.evidence.jacobian.as_ref();
        if self.evidence.loops.iter().any(shows)
            || by_jacobian.is_some_and(JacobianEvidence::shows_defect)
        {
            self.evidence.survey.degenerate_form = survey::degenerate_form(subject, &given.size)?;
        }
        Ok(())
    }

    /// Where the Jacobian has no defect at its points, tests it at features that the samples of a loop do not resolve; and where a loop
    /// integral changes, at the roughest place of that loop: a defect may be in a narrow strip.
    pub(super) fn jacobian_at_features(
        &mut self,
        subject: Subject<'_>,
        given: &Given<'_>,
    ) -> Result<(), Error> {
        let has_none = |found: &JacobianEvidence| !found.shows_defect();
        if !self.evidence.jacobian.as_ref().is_some_and(has_none) {
            // A defect that the Jacobian shows needs no bound.
            if self.evidence.jacobian.is_none() {
                self.bound_by_features();
            }
            return Ok(());
        }
        let mut is_symplectic = false;
        let start = self.count.made();
        let mut places = self.features.clone();
        places.dedup_by_key(|(index, _)| *index);
        places.truncate(MOST_FEATURES);
        let changed = self.changed_loop().map(|(found, h)| (found.index, h));
        for place in places.into_iter().map(Some).chain([None]) {
            let index = match (place, changed) {
                (Some((index, _)), _) | (None, Some((index, _))) => index,
                (None, None) => break,
            };
            let found = self.evidence.loops.iter().find(|of| of.index == index);
            let Some(found) = found.filter(|found| found.kind != LoopKind::Image) else {
                continue;
            };
            let samples = (found.samples / PART_OF_SAMPLES).max(FEWEST_OF_ROUGHNESS);
            let random = self
                .diagnostic
                .random_loop_of(found, &given.size, subject)?;
            let subject = Subject {
                phase_loop: (random.as_ref()).map_or(subject.phase_loop, |random| random),
                ..subject
            };
            let place = match (place, changed) {
                (Some((_, feature)), _) => Place::Feature(feature),
                (None, Some((_, h))) => Place::Roughest { samples, h },
                (None, None) => break,
            };
            let shown = self.jacobian_at(subject, given, place);
            match shown {
                Ok(Some(found)) if found.shows_defect() => {
                    let one = JacobianTest {
                        points: 1,
                        ..JacobianTest::default()
                    };
                    self.evidence.jacobian_decay =
                        self.jacobian_decay(&one, subject, given, &found);
                    self.evidence.jacobian = Some(JacobianEvidence {
                        loop_index: index,
                        ..found
                    });
                    break;
                }
                Ok(Some(found)) => {
                    let is_bounded = found.bound.is_some_and(|bound| bound < WEAKEST_BOUND);
                    is_symplectic |= index == 0 && found.not_differentiable == 0 && is_bounded;
                }
                Ok(None) | Err(Error::BudgetSpent { .. }) => {}
                Err(error) if of_the_map(&error) => {}
                Err(error) => return Err(error),
            }
        }
        if !is_symplectic {
            self.bound_by_features();
        }
        self.evidence.evaluations.jacobian += self.count.made() - start;
        Ok(())
    }

    /// The Jacobian at a place; `None` if too few evaluations are left.
    fn jacobian_at(
        &self,
        subject: Subject<'_>,
        given: &Given<'_>,
        place: Place,
    ) -> Result<Option<JacobianEvidence>, Error> {
        let (evaluator, phase_loop) = (subject.evaluator, subject.phase_loop);
        let left = self.count.left();
        let (dof, has_tangent) = (evaluator.dof(), evaluator.has_tangent());
        let Some(one) = JacobianTest::within(left, dof, has_tangent) else {
            return Ok(None);
        };
        let one = JacobianTest { points: 1, ..one };
        let cost = one.evaluations(dof, has_tangent);
        let Feature { s, h } = match place {
            Place::Feature(feature) if cost <= left => feature,
            Place::Roughest { samples, h } if cost + samples <= left => {
                let refined = RefinedSamples::new(subject, samples, h)?;
                let s = roughest_sample(subject, &refined);
                Feature { s, h }
            }
            _ => return Ok(None),
        };
        let one = JacobianTest {
            budget: cost,
            ..one
        };
        (one.run_at(evaluator, phase_loop, &given.size, h, vec![s])).map(Some)
    }

    /// The loop without breaks whose integral changes most, and the step size at which it does.
    fn changed_loop(&self) -> Option<(&LoopEvidence, f64)> {
        let smooth = |found: &&LoopEvidence| {
            !found.winds
                && found.steps.iter().all(|step| step.jump.is_none())
                && found.shows_defect()
        };
        let largest = |found: &LoopEvidence| {
            let changes = found.steps.iter().filter(|step| step.is_significant());
            changes
                .map(|step| (step.defect.magnitude(), step.step_size))
                .max_by(|a, b| a.0.total_cmp(&b.0))
        };
        (self.evidence.loops.iter().filter(smooth))
            .filter_map(|found| Some((found, largest(found)?)))
            .max_by(|a, b| a.1.0.total_cmp(&b.1.0))
            .map(|(found, (_, h))| (found, h.unwrap_or(self.largest)))
    }

    /// Where a loop integral changes and the Jacobian does not show why, looks whether the loop can be contracted in the
    /// domain of the map.
    pub(super) fn contract(
        &mut self,
        subject: Subject<'_>,
        given: &Given<'_>,
    ) -> Result<(), Error> {
        let of_jacobian = self.evidence.jacobian.as_ref();
        let Some((found, _)) = self.changed_loop().filter(|(found, _)| {
            !of_jacobian.is_some_and(JacobianEvidence::shows_defect)
                && self.evidence.survey.singular.is_none()
                && self.evidence.survey.degenerate_form.is_none()
                && found.kind != LoopKind::Image
                && !given.probe.is_beyond_memory()
        }) else {
            return Ok(());
        };
        if self.count.left() < FEWEST_OF_HALVING {
            self.omit(Omission::ContractionBudget);
            return Ok(());
        }
        let start = self.count.made();
        let random = self
            .diagnostic
            .random_loop_of(found, &given.size, subject)?;
        let subject = Subject {
            phase_loop: (random.as_ref()).map_or(subject.phase_loop, |random| random),
            ..subject
        };
        subject.evaluator.begin_loop();
        match contraction(subject, &given.size, self.largest) {
            // A boundary was not resolved, as no more evaluations were left.
            Ok(None) if self.count.left() < MOST_OF_A_BOUNDARY => {
                self.omit(Omission::ContractionBudget);
            }
            Ok(found) => self.evidence.contraction = found,
            Err(Error::BudgetSpent { .. }) => self.omit(Omission::ContractionBudget),
            // Within the loop the map need not be defined.
            Err(error) if of_the_map(&error) => {}
            Err(error) => return Err(error),
        }
        self.evidence.evaluations.localisation += self.count.made() - start;
        Ok(())
    }
}

//! Whether a loop whose integral changes can be contracted in the domain of the map.

use super::localise::{MAX_BOUNDARY_EVALUATIONS, MIN_HALVING_EVALUATIONS, contraction};
use super::{GivenLoop, Runner};
use crate::error::Error;
use crate::evidence::{Check, LoopEvidence, LoopKind, OmissionReason, StepEvidence};
use crate::jacobian::{JacobianEvidence, JacobianTest};
use crate::map::LoopSize;
use crate::rules::Subject;
use crate::signal::parameters;

impl Runner<'_> {
    /// The loop without breaks whose integral changes most, and the step in which it does.
    pub(super) fn changed_loop(&self) -> Option<(&LoopEvidence, &StepEvidence)> {
        let smooth = |found: &&LoopEvidence| {
            !found.winds
                && found.steps.iter().all(|step| step.jump.is_none())
                && found.shows_defect()
        };
        let by_change = |a: &(_, &StepEvidence), b: &(_, &StepEvidence)| {
            (a.1.defect.magnitude()).total_cmp(&b.1.defect.magnitude())
        };
        let changes = self.evidence.loops.iter().filter(smooth).flat_map(|found| {
            let changes = found.steps.iter().filter(|step| step.is_significant());
            changes.map(move |step| (found, step))
        });
        changes.max_by(by_change)
    }

    /// The size of a step; the largest if none was stated.
    pub(super) fn size_of(&self, step: &StepEvidence) -> f64 {
        step.step_size.unwrap_or(self.largest)
    }

    /// If a loop integral changes and the Jacobian does not show why, tests whether the loop can be contracted in the
    /// domain of the map. If the Jacobian was not tested, one point of it is.
    pub(super) fn contract(
        &mut self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
    ) -> Result<(), Error> {
        let of_jacobian = self.evidence.jacobian.as_ref();
        let Some((found, step)) = self.changed_loop().filter(|(found, _)| {
            !of_jacobian.is_some_and(JacobianEvidence::shows_defect)
                && self.evidence.survey.singular.is_none()
                && self.evidence.survey.degenerate_form.is_none()
                && found.kind != LoopKind::Image
                && !given.probe.is_beyond_memory()
        }) else {
            return Ok(());
        };
        if self.count.left() < MIN_HALVING_EVALUATIONS {
            self.omit(Check::Contraction, OmissionReason::BUDGET);
            return Ok(());
        }
        let random = self
            .diagnostic
            .random_loop_of(found, &given.size, subject)?;
        let subject = subject.on(random.as_ref());
        subject.evaluator.begin_loop();
        let h = self.size_of(step);
        if of_jacobian.is_none() && self.one_point_shows_defect(subject, &given.size, h)? {
            return Ok(());
        }
        match contraction(subject, &given.size, h, step) {
            // A boundary was not resolved, as no more evaluations were left.
            Ok(None) if self.count.left() < MAX_BOUNDARY_EVALUATIONS => {
                self.omit(Check::Contraction, OmissionReason::BUDGET);
            }
            Ok(found) => self.evidence.contraction = found,
            // Within the loop the map need not be defined.
            Err(error) if error.is_of_map() => {}
            Err(error) => return Err(error),
        }
        Ok(())
    }

    /// Whether the Jacobian has a defect at one point of the loop. If it has, the map is not symplectic near this point, and the loop need not
    /// be contracted. Returns `false` without a test if the test would leave too few evaluations for a boundary.
    fn one_point_shows_defect(
        &self,
        subject: Subject<'_>,
        size: &LoopSize,
        h: f64,
    ) -> Result<bool, Error> {
        let evaluator = subject.evaluator;
        let mut one = JacobianTest {
            points: 1,
            ..JacobianTest::default()
        };
        one.budget = one.evaluations(evaluator.dof(), evaluator.has_tangent());
        if one.budget + MAX_BOUNDARY_EVALUATIONS > self.count.left() {
            return Ok(false);
        }
        match one.run_at(evaluator, subject.phase_loop, size, h, parameters(1)) {
            Ok(found) => Ok(found.shows_defect()),
            // The map need not be defined beside the loop.
            Err(error) if error.is_of_map() => Ok(false),
            Err(error) => Err(error),
        }
    }
}

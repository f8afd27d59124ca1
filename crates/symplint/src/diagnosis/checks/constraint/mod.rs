//! Whether the map projects onto a manifold, or its form is degenerate: what leaves the manifold, or the leaf, is not evidence.

mod singular;

pub(in crate::diagnosis) use singular::cost as singular_cost;

use super::{GivenLoop, Runner};
use crate::error::Error;
use crate::evidence::{Check, LoopEvidence, MAX_BOUND_ON_DEFECT, OmissionReason};
use crate::jacobian::JacobianEvidence;
use crate::rules::Subject;
use crate::signal::{nearest, parameter};
use crate::state::{coordinate, period};
use singular::{degenerate_form, singular_jacobian};

/// States of the loop that show whether a step keeps to the manifold. Conventional.
const STATES: usize = 8;

impl Runner<'_> {
    /// Where something has a defect, looks whether it lies outside the domain of the map: whether the map projects onto a
    /// manifold. If the given loop has one, its image, which lies on the manifold, is advanced, too.
    pub(super) fn look_for_manifold(
        &mut self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
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
        if self.count.left() < singular_cost(subject.dof()) {
            self.omit(Check::Constraint, OmissionReason::BUDGET);
            return Ok(());
        }
        let found = singular_jacobian(subject, &given.size, self.largest);
        // Beside the loop the map need not be defined.
        self.evidence.survey.singular = match found {
            Err(error) if error.is_of_map() => None,
            found => found?,
        };
        if self.evidence.survey.singular.is_some() && of_given {
            self.image_loop(subject)?;
        }
        Ok(())
    }

    /// Tests whether the symplectic form of non-canonical coordinates is degenerate, and whether the largest step keeps to the manifold.
    pub(super) fn look_for_leaf(
        &mut self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
    ) -> Result<(), Error> {
        let Some(constraint) = subject.evaluator.constraint() else {
            return Ok(());
        };
        self.evidence.survey.degenerate_form = degenerate_form(subject, &given.size)?;
        if self.count.left() < STATES {
            self.omit(Check::Constraint, OmissionReason::BUDGET);
            return Ok(());
        }
        let s: Vec<f64> = (0..STATES).map(parameter).collect();
        let evaluator = subject.evaluator;
        let states = match evaluator.image(subject.phase_loop, self.largest, &s) {
            Err(error) if error.is_of_map() => return Ok(()),
            states => states?,
        };
        let mut projected = states.clone();
        constraint.project(&mut projected.block());
        // In coordinates with a one-form, positions are the coordinates, and momenta the values of the form.
        let coordinates = match constraint.is_of_one_form() {
            true => 0..subject.dof(),
            false => 0..2 * subject.dof(),
        };
        let distance = |c: usize| {
            let (radius, period) = (
                given.size.radius[c / subject.dof()][c % subject.dof()],
                period(subject.coordinates(), c),
            );
            (coordinate(&states, c).iter())
                .zip(coordinate(&projected, c))
                .map(|(of_step, on)| nearest(of_step - on, period).abs() / radius)
                .fold(0.0, f64::max)
        };
        let off = coordinates
            .map(distance)
            .filter(|of| of.is_finite())
            .fold(0.0, f64::max);
        self.evidence.survey.off_manifold = Some(off).filter(|off| *off > MAX_BOUND_ON_DEFECT);
        Ok(())
    }
}

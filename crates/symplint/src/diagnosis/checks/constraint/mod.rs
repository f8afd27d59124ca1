//! Whether the map projects onto a manifold, or its form is degenerate: what leaves the manifold, or the leaf, is not evidence.

mod singular;

pub(in crate::diagnosis) use singular::cost as singular_cost;

use super::{GivenLoop, Runner};
use crate::error::Error;
use crate::evidence::{Check, LoopEvidence, Why};
use crate::jacobian::JacobianEvidence;
use crate::rules::Subject;
use singular::{degenerate_form, singular_jacobian};

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
            self.omit(Check::Constraint, Why::BUDGET);
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

    /// If something shows a defect, tests whether the symplectic form of non-canonical coordinates is degenerate.
    pub(super) fn look_for_leaf(
        &mut self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
    ) -> Result<(), Error> {
        let shows = |found: &LoopEvidence| found.shows_defect() || found.is_broken();
        let by_jacobian = self.evidence.jacobian.as_ref();
        if self.evidence.loops.iter().any(shows)
            || by_jacobian.is_some_and(JacobianEvidence::shows_defect)
        {
            self.evidence.survey.degenerate_form = degenerate_form(subject, &given.size)?;
        }
        Ok(())
    }
}

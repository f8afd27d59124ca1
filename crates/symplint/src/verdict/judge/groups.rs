//! Groups of degrees of freedom of similar action: what is known of each.

use super::{Case, Decision};
use crate::evidence::{LoopEvidence, MAX_BOUND_ON_DEFECT, Motion, StepEvidence};
use crate::verdict::advice::Advice;
use crate::verdict::findings::{BoundFinding, Finding};

impl Case<'_> {
    /// What no defect in each group exceeds, if there are several.
    pub(super) fn groups(&self) -> Vec<Finding> {
        let groups = self.evidence.groups.iter().enumerate();
        groups.map(|(index, _)| self.group(index)).collect()
    }

    /// The bounds of groups that no loop bounds.
    pub(super) fn bounds_by_jacobian_alone(&self) -> impl Iterator<Item = f64> {
        self.groups().into_iter().filter_map(|group| match group {
            Finding::Bounds(BoundFinding::Group {
                by_loops: None,
                by_jacobian,
                ..
            }) => by_jacobian.filter(|bound| *bound <= MAX_BOUND_ON_DEFECT),
            _ => None,
        })
    }

    fn group(&self, index: usize) -> Finding {
        let group = &self.evidence.groups[index];
        let counted = |found: &&LoopEvidence| {
            found.group.unwrap_or(0) == index && !found.winds && found.is_bounded()
        };
        let loops: Vec<&LoopEvidence> = self.loops.iter().filter(counted).collect();
        let steps = || loops.iter().flat_map(|found| &found.steps);
        let by_jacobian = (self.evidence.jacobian.as_ref())
            .and_then(|jacobian| *jacobian.bounds_of_groups.get(index)?);
        Finding::Bounds(BoundFinding::Group {
            index,
            of: self.evidence.groups.len(),
            dofs: group.dofs.clone(),
            action: group.action,
            loops: loops.len(),
            by_loops: steps().map(StepEvidence::bound).reduce(f64::max),
            by_jacobian,
        })
    }

    /// A group whose motions the largest step advances too little.
    pub(super) fn slow_group(&self) -> Option<Decision> {
        (1..self.evidence.groups.len()).find_map(|index| {
            let of_group = |found: &&LoopEvidence| found.group == Some(index) && found.is_bounded();
            let loops: Vec<&LoopEvidence> = self.loops.iter().filter(of_group).collect();
            let (motion, step_size) = Motion::strongest_of(&loops)?;
            let bounds = loops.iter().flat_map(|found| &found.steps);
            let bound = bounds.map(StepEvidence::bound).fold(f64::EPSILON, f64::max);
            let of_map = !self.has_step_size() || motion.shear && motion.moves;
            (!motion.tests(bound) && !of_map).then(|| {
                let advice = self.advice_on_motion(motion, step_size, bound);
                self.little_motion(motion, Some(index), advice)
            })
        })
    }

    /// A group of which neither its loops nor the Jacobian bound a defect.
    pub(super) fn unknown_group(&self) -> Option<Decision> {
        let unknown = self.groups().into_iter().find(|group| {
            let Finding::Bounds(BoundFinding::Group {
                by_loops,
                by_jacobian,
                ..
            }) = group
            else {
                return false;
            };
            let known =
                |bound: &Option<f64>| bound.is_some_and(|bound| bound <= MAX_BOUND_ON_DEFECT);
            !known(by_loops) && !known(by_jacobian)
        })?;
        let mut decision = self.because(unknown, vec![Advice::LargerRadiiOfGroup]);
        decision
            .findings
            .retain(|finding| *finding != decision.because);
        Some(decision)
    }
}

//! The evaluations that checks to come are expected to make, for the progress of a diagnosis.

use super::constraint::singular_cost;
use super::localise::MIN_SECTOR_EVALUATIONS;
use super::memory::cost_again;
use super::random_loops::LOOPS_PER_GROUP;
use super::{GivenLoop, Runner};
use crate::diagnosis::limits::{MIN_FOLDED_SAMPLES, STATES_OF_RETURN, STATES_OF_ROUNDING};
use crate::diagnosis::plan::power_below;
use crate::evidence::{Check, LoopEvidence};
use crate::jacobian::JacobianTest;
use crate::rules::Subject;

/// Evaluations for both sides of a break, about. Calibrated on the truth set.
const EVALUATIONS_OF_BREAK_SIDES: usize = 30;

/// Evaluations of the loops that confirm a preserved form, about. Calibrated on the truth set.
const EVALUATIONS_OF_PRESERVED_FORM: usize = 150;

/// The number of remaining evaluations depends on these numbers.
#[derive(Clone, Copy)]
pub(super) struct Cost {
    /// Evaluations of one step of the given loop.
    pub(super) step: usize,
    /// Samples of the given loop.
    pub(super) samples: usize,
    /// Groups of degrees of freedom.
    pub(super) groups: usize,
}

impl GivenLoop<'_> {
    pub(super) fn costs(&self) -> Cost {
        Cost {
            step: self.cost,
            samples: self.probe.samples,
            groups: self.size.groups.len(),
        }
    }
}

impl Runner<'_> {
    /// Renews the expectation when the check with this number in [`checks`](Self::checks) begins.
    pub(super) fn expect_from(&self, first: usize, subject: Subject<'_>, cost: Cost) {
        let checks = Self::checks();
        // Later rows of the same check are rarely needed.
        let begins = |k: usize| checks[..k].iter().all(|(check, _)| *check != checks[k].0);
        let of_check = |k: usize| match begins(k) {
            true => self.expected(checks[k].0, subject, cost),
            false => 0,
        };
        let later: usize = (first + 1..checks.len()).map(of_check).sum();
        self.progress
            .expect(of_check(first), later + self.of_memory());
    }

    /// The same while the given loop has this number of steps left.
    pub(super) fn expect_steps(&self, steps: usize, subject: Subject<'_>, cost: Cost) {
        let checks = Self::checks().map(|(check, _)| check);
        let begins = |k: &usize| !checks[..*k].contains(&checks[*k]);
        let later: usize = (0..checks.len())
            .filter(begins)
            .map(|k| self.expected(checks[k], subject, cost))
            .sum();
        self.progress
            .expect(steps * cost.step, later + self.of_memory());
    }

    /// Evaluations that the last look at states from before makes.
    pub(super) fn of_memory(&self) -> usize {
        cost_again(self.plan.witnesses)
    }

    /// Evaluations that a check is expected to make, from the evidence so far.
    fn expected(&self, check: Check, subject: Subject<'_>, cost: Cost) -> usize {
        let diagnostic = self.diagnostic;
        let loops = &self.evidence.loops;
        let (dof, evaluator) = (subject.dof(), subject.evaluator);
        let shows = loops.iter().any(|of| !of.winds && of.shows_defect());
        let is_broken = loops.iter().any(|of| !of.winds && of.is_broken());
        match check {
            Check::RandomLoops => self.of_random_loops(subject, cost),
            Check::ManySteps if !is_broken && diagnostic.long_time > 0 => {
                let affordable = power_below(self.left() / diagnostic.long_time);
                let samples = cost.samples.max(MIN_FOLDED_SAMPLES / dof.max(1));
                samples.min(affordable) * diagnostic.long_time
            }
            Check::Jacobian if diagnostic.jacobian => {
                let has_tangent = evaluator.has_tangent();
                JacobianTest::within(self.plan.jacobian, dof, has_tangent)
                    .map_or(0, |test| test.evaluations(dof, has_tangent))
            }
            Check::Constraint if shows && evaluator.constraint().is_none() => singular_cost(dof),
            Check::Localisation if diagnostic.localise && shows => {
                let substeps = match evaluator.substeps() {
                    1 => 0,
                    _ if !is_broken => cost.step,
                    passes => passes * cost.step,
                };
                let of_sectors = substeps + MIN_SECTOR_EVALUATIONS;
                let has_sectors = !is_broken && self.left() > of_sectors;
                // Without a second look at each side.
                substeps + usize::from(has_sectors) * MIN_SECTOR_EVALUATIONS / 2
            }
            Check::SampleSweep => (diagnostic.sample_sweep.iter())
                .flat_map(|sweep| &sweep.counts)
                .sum(),
            Check::BreakSides if is_broken => EVALUATIONS_OF_BREAK_SIDES,
            // In one degree of freedom the Jacobian is enough.
            Check::PreservedForm if shows && !is_broken && diagnostic.properties && dof > 1 => {
                EVALUATIONS_OF_PRESERVED_FORM
            }
            Check::Structure if diagnostic.properties => {
                let ample = usize::from(!self.plan.is_tight());
                2 * (STATES_OF_RETURN[ample] + STATES_OF_ROUNDING[ample])
            }
            _ => 0,
        }
    }

    /// Evaluations of the loops besides the given one that were not measured yet: each as many as the given one.
    fn of_random_loops(&self, subject: Subject<'_>, cost: Cost) -> usize {
        let (given_loop, random) = match self.evidence.loops.split_first() {
            Some((given_loop, random)) => (Some(given_loop), random),
            None => (None, &[][..]),
        };
        let count = self.diagnostic.loops - 1;
        if count == 0 {
            return 0;
        }
        let further_groups = cost.groups.saturating_sub(1);
        let has_period = (0..subject.dof()).any(|i| subject.coordinates().period(i) != 0.0);
        let all = count + LOOPS_PER_GROUP * further_groups + usize::from(has_period);
        let of_loop = cost.step.max(self.plan.first_samples);
        let needed = self.needed_loops().min(all);
        let to_come = needed.saturating_sub(random.len()) * of_loop;
        // The first random loop that shows a defect takes all step sizes.
        let of_sweep = match given_loop.is_some_and(LoopEvidence::shows_defect)
            && !given_loop.is_some_and(LoopEvidence::is_broken)
            && !random.iter().any(LoopEvidence::shows_defect)
        {
            true => (self.sizes().count() - 1) * of_loop,
            false => 0,
        };
        to_come + of_sweep
    }
}

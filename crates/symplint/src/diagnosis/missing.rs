//! How many evaluations more would decide.
//!
//! The estimate is the smallest budget for which the plan would give the given loop as many samples, or pieces, as it
//! seems to need. It is rather too large than too small: what steep slopes need shows only where samples resolve them,
//! and a break is often found with fewer. For a step that deforms the loop by several times its size it can be too
//! small: the next budget then says more.

use super::checks::constraint::singular_cost;
use super::checks::memory::cost_again;
use super::limits::{
    DIVISOR_OF_DOMAIN, EVALUATIONS_OF_CONTRACTION, FACTOR_OF_TWO_DOUBLINGS, MAX_STRETCH,
    MIN_BUDGET_OF_PIECES, SLOPE_MARGINS,
};
use super::plan::Plan;
use super::{Diagnostic, SampleCount};
use crate::error::Error;
use crate::evidence::{
    Check, Evidence, LoopEvidence, MAX_BOUND_ON_DEFECT, MAX_CELLS_BETWEEN_SAMPLES, StepEvidence,
};
use crate::loops::MAX_SAMPLES_OF_DOUBLING;
use crate::rules::{Rule, Subject, cells_apart};
use crate::state::Ensemble;

impl Diagnostic {
    /// Evaluations beyond the budget that would resolve the loops: see
    /// [`Evaluations::wanted`](crate::evidence::Evaluations::wanted).
    pub(super) fn missing(
        &self,
        subject: Subject<'_>,
        evidence: &Evidence,
    ) -> Result<usize, Error> {
        let adaptive = matches!(self.rule, Rule::Auto | Rule::Piecewise(_));
        if !adaptive || self.must_stream(subject.dof()) {
            return Ok(0);
        }
        let budget = evidence.evaluations.budget;
        let beside = budget_for_domain(subject.dof(), evidence).saturating_sub(budget);
        let beside = beside.max(random_loops(evidence));
        let steps =
            || (evidence.loops.iter()).flat_map(|of| of.steps.iter().map(move |step| (of, step)));
        let given = evidence.loops.first().map_or(0, |given| given.samples);
        let fewer = matches!(self.samples, SampleCount::Fixed(asked) if given < asked);
        let limited = fewer || self.plan(subject, budget).is_tight();
        // Further samples do not resolve a map whose own rounding exceeds the bound that a verdict needs.
        let drowned = |step: &StepEvidence| step.defect.roundoff > MAX_BOUND_ON_DEFECT;
        let unresolved = |step: &StepEvidence| {
            let is_weak = !step.is_bounded() || step.is_unexplained();
            step.misses_the_grid() || limited && is_weak && !drowned(step)
        };
        let mut samples = 0;
        for (found, step) in steps().filter(|(_, step)| unresolved(step)) {
            samples = samples.max(resolving(subject, found, step)?);
        }
        let needed = match samples {
            0 => None,
            _ if samples > given => self.least_budget(subject, evidence, samples),
            _ => Some(MIN_BUDGET_OF_PIECES.max(2 * budget)),
        };
        Ok(needed.map_or(beside, |needed| needed.saturating_sub(budget).max(beside)))
    }

    fn plan(&self, subject: Subject<'_>, budget: usize) -> Plan {
        let of_manifold = singular_cost(subject.dof());
        Plan::new(self, budget, subject.evaluator, of_manifold)
    }

    /// The smallest budget in which the given loop gets this number of samples.
    fn least_budget(
        &self,
        subject: Subject<'_>,
        evidence: &Evidence,
        samples: usize,
    ) -> Option<usize> {
        let enough = |budget: usize| {
            let plan = self.plan(subject, budget);
            // A larger budget keeps evaluations to advance more states again.
            let looks = evidence.evaluations.of(Check::Memory) + cost_again(plan.witnesses);
            let left = budget.saturating_sub(looks + plan.jacobian + plan.domain);
            let most = match self.samples {
                SampleCount::Fixed(_) => plan.first_samples,
                SampleCount::Auto => plan
                    .most_samples(self, budget, left)
                    .max(plan.first_samples),
            };
            samples <= most
        };
        let mut low = evidence.evaluations.budget;
        let mut high = low;
        while !enough(high) {
            (low, high) = (high, high.checked_mul(2)?);
        }
        while low + 1 < high {
            let middle = low.midpoint(high);
            match enough(middle) {
                true => high = middle,
                false => low = middle,
            }
        }
        Some(high.max(MIN_BUDGET_OF_PIECES)).filter(|_| samples <= MAX_SAMPLES_OF_DOUBLING)
    }
}

/// Evaluations that the random loops would take that were left out: each as many as a step of the given loop.
fn random_loops(evidence: &Evidence) -> usize {
    let steps = evidence.loops.first().map_or(0, |given| given.steps.len());
    let missing = evidence.missing(Check::RandomLoops);
    missing * evidence.evaluations.of(Check::GivenLoop) / steps.max(1)
}

/// The budget in which enough is kept to find out whether what shows a defect lies in the domain of the map; 0 where that
/// is known.
fn budget_for_domain(dof: usize, evidence: &Evidence) -> usize {
    let manifold = singular_cost(dof);
    if evidence.missing(Check::Contraction) > 0 {
        let of_more = 2 * evidence.evaluations.budget;
        (DIVISOR_OF_DOMAIN * (manifold + EVALUATIONS_OF_CONTRACTION)).max(of_more)
    } else if evidence.missing(Check::Constraint) > 0 {
        DIVISOR_OF_DOMAIN * manifold
    } else {
        0
    }
}

/// About how many samples resolve the grid of the map, or half periods, after a step that misses them.
fn resolving(
    subject: Subject<'_>,
    found: &LoopEvidence,
    step: &StepEvidence,
) -> Result<usize, Error> {
    let steeper = match step.misses_the_grid() {
        true => (SLOPE_MARGINS.iter()).find(|(samples, _)| found.samples <= *samples),
        false => None,
    };
    let steeper = steeper.map_or(FACTOR_OF_TWO_DOUBLINGS, |(_, factor)| *factor);
    let mut apart = steeper * step.cells_apart;
    // Pieces that resolve a step would have found its breaks.
    if !step.is_bounded() {
        let before = Ensemble::sample(subject.phase_loop, found.samples)?;
        apart = apart.min(MAX_STRETCH * cells_apart(&before, subject.coordinates()));
    }
    let finer = (apart / MAX_CELLS_BETWEEN_SAMPLES)
        .ceil()
        .clamp(1.0, MAX_SAMPLES_OF_DOUBLING as f64) as usize;
    Ok(found.samples.saturating_mul(finer.next_power_of_two()))
}

//! How a budget of evaluations is spent.

use super::limits::{
    BUDGET_PER_WITNESS, DEFAULT_BUDGET, DIVISOR_OF_DOMAIN, DIVISOR_OF_FIRST_SAMPLES,
    DIVISOR_OF_GIVEN_SAMPLES, DIVISOR_OF_JACOBIAN, DIVISOR_OF_LARGE_JACOBIAN,
    DIVISOR_OF_TIGHT_SAMPLES, EVALUATIONS_OF_CONTRACTION, FINE_SAMPLES, MAX_BYTES,
    MAX_JACOBIAN_COORDINATES, MAX_LARGE_JACOBIAN, MAX_SMALL_JACOBIAN, MAX_WITNESSES,
    MIN_FOLDED_SAMPLES, PURITY_SAMPLES, TIGHT_BUDGET, TIGHT_TOLERANCE,
};
use super::{Diagnostic, SampleCount};
use crate::evidence::MIN_SAMPLES_OF_SHAPE;
use crate::jacobian::JacobianTest;
use crate::loops::FEW_SAMPLES;
use crate::map::Evaluator;

/// The budget if none is given. It allows the many steps that are asked for and, if the number of samples is
/// given, the sweeps.
pub(super) fn default_budget(diagnostic: &Diagnostic) -> usize {
    let measurements = diagnostic.step_sizes.len() + diagnostic.loops;
    let of_steps = match diagnostic.samples {
        SampleCount::Fixed(samples) => samples.saturating_mul(2 * measurements),
        SampleCount::Auto => 0,
    };
    let of_each_step = match diagnostic.samples {
        SampleCount::Fixed(samples) => samples.max(MIN_FOLDED_SAMPLES),
        SampleCount::Auto => MIN_FOLDED_SAMPLES,
    };
    let of_long_time = diagnostic.long_time.saturating_mul(of_each_step);
    let of_sweep = (diagnostic.sample_sweep.iter()).flat_map(|sweep| &sweep.counts);
    let of_sweep = of_sweep.fold(0, |sum: usize, &count| sum.saturating_add(count));
    of_steps
        .saturating_add(of_sweep)
        .saturating_add(of_long_time)
        .saturating_add(DEFAULT_BUDGET)
}

/// The plan, made before the first measurement.
pub(super) struct Plan {
    /// Samples from which doubling begins.
    pub first_samples: usize,
    /// States that are advanced again at the beginning, to see whether results depend on earlier calls or on the batch.
    pub purity_samples: usize,
    /// States of the largest batches of a loop that are advanced again.
    pub witnesses: usize,
    /// Evaluations that are kept for the Jacobian, which may take no more.
    pub jacobian: usize,
    /// Evaluations that are kept for the domain of the map.
    pub domain: usize,
    /// What interpolants of the piecewise rule may be off, at least.
    pub tolerance: f64,
}

impl Plan {
    /// The plan for a diagnosis, in which the test for a constraint manifold takes `of_manifold` evaluations.
    pub fn new(
        diagnostic: &Diagnostic,
        budget: usize,
        evaluator: &Evaluator<'_>,
        of_manifold: usize,
    ) -> Self {
        let dof = evaluator.dof();
        let measurements = diagnostic.step_sizes.len() + diagnostic.loops;
        let share = power_below(budget / (DIVISOR_OF_FIRST_SAMPLES * measurements.max(1)));
        let fine = power_below(FINE_SAMPLES / dof.max(1)).max(FEW_SAMPLES);
        let tight = budget < TIGHT_BUDGET;
        let ample = usize::from(!tight && fits(dof, FEW_SAMPLES));
        Plan {
            first_samples: match diagnostic.samples {
                SampleCount::Fixed(samples) if samples <= budget / DIVISOR_OF_GIVEN_SAMPLES => {
                    samples
                }
                SampleCount::Fixed(samples) => {
                    power_below(samples).min(share.max(MIN_SAMPLES_OF_SHAPE))
                }
                SampleCount::Auto => share.clamp(MIN_SAMPLES_OF_SHAPE, fine),
            },
            purity_samples: PURITY_SAMPLES[ample],
            witnesses: match fits(dof, FEW_SAMPLES) {
                true => (budget / BUDGET_PER_WITNESS).clamp(1, MAX_WITNESSES),
                false => 1,
            },
            jacobian: match diagnostic.jacobian {
                true => {
                    let all = JacobianTest::default().evaluations(dof, evaluator.has_tangent());
                    let most = (MAX_JACOBIAN_COORDINATES / dof.max(1)).max(MAX_LARGE_JACOBIAN);
                    let part = MAX_SMALL_JACOBIAN.max(budget / DIVISOR_OF_LARGE_JACOBIAN);
                    all.min(most).min(budget / DIVISOR_OF_JACOBIAN).min(part)
                }
                false => 0,
            },
            domain: (of_manifold + EVALUATIONS_OF_CONTRACTION).min(budget / DIVISOR_OF_DOMAIN),
            tolerance: if tight { TIGHT_TOLERANCE } else { 0.0 },
        }
    }

    /// Whether the first samples of all loops and step sizes are a large part of the budget.
    pub fn is_tight(&self) -> bool {
        self.tolerance > 0.0
    }

    /// The most samples of the given loop, if this many evaluations are left for loops.
    pub fn most_samples(&self, diagnostic: &Diagnostic, budget: usize, left: usize) -> usize {
        if !self.is_tight() {
            return share(diagnostic, budget).min(left);
        }
        // Two more step sizes, and a random loop, should be possible with as many samples.
        let further = (diagnostic.step_sizes.len() - 1).min(2) + (diagnostic.loops - 1).min(1);
        tight_samples(left).min(left / (1 + further))
    }
}

/// The most samples of a loop in a tight budget of which this number of evaluations is left.
pub(super) fn tight_samples(left: usize) -> usize {
    (left / DIVISOR_OF_TIGHT_SAMPLES).max(FEW_SAMPLES)
}

/// Samples of one loop in an ample budget: as many as the given loop at all step sizes, the random loops at the
/// largest, and one that winds, can have as many.
pub(super) fn share(diagnostic: &Diagnostic, budget: usize) -> usize {
    let measurements = diagnostic.step_sizes.len() + diagnostic.loops + 1;
    budget / measurements
}

/// The largest power of two that is not above `count`; 0 if that is 0.
pub(super) fn power_below(count: usize) -> usize {
    count.checked_ilog2().map_or(0, |exponent| 1 << exponent)
}

/// Whether an ensemble of this number of samples may be made if the user did not ask for it.
pub(super) fn fits(dof: usize, samples: usize) -> bool {
    samples.saturating_mul(dof) <= MAX_BYTES / 16
}

//! The verdict on a force or a vector field, from the evidence alone.

use serde::{Deserialize, Serialize};

use super::evidence::{FieldEvidence, FieldKind, FieldLoopKind, LoopWork};
use super::limits::{
    ALLOWANCE_OF_ONE_LOOP, MAX_CURL_OVER_JUMPS, MAX_JUMP_OF_SOLVER, MAX_SOLVER_TOLERANCE,
    MIN_DIGITS,
};

/// The answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FieldVerdict {
    /// The force is a gradient on the loops, to the stated digits.
    Gradient,
    /// The force does work around a loop.
    NotAGradient,
    /// The vector field is Hamiltonian on the loops, to the stated digits.
    Hamiltonian,
    /// The vector field changes the loop integral of a loop.
    NotHamiltonian,
    /// There is not enough evidence.
    Undecided,
}

impl FieldVerdict {
    /// As reports write it.
    pub fn name(self) -> &'static str {
        match self {
            FieldVerdict::Gradient => "gradient",
            FieldVerdict::NotAGradient => "not-a-gradient",
            FieldVerdict::Hamiltonian => "hamiltonian",
            FieldVerdict::NotHamiltonian => "not-hamiltonian",
            FieldVerdict::Undecided => "undecided",
        }
    }
}

impl std::fmt::Display for FieldVerdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// The reason of a verdict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Certainty {
    /// All loop integrals are zero within their errors.
    Closed,
    /// The force is the same everywhere on the loops.
    Constant,
    /// There is one position, without a period: every force is a gradient.
    OnePosition,
    /// A loop integral is not zero; the index of the loop that shows it best.
    Work(usize),
    /// The same, on loops across which the force jumps.
    WorkAcrossJumps(usize),
    /// Loops that can be contracted close, and one around a period does not.
    WorkAroundPeriod(usize),
    /// A loop integral is not zero, and no larger than jumps of a solver's tolerance make it.
    Tolerance(usize),
    /// The same of a smooth force, and the budget was too small to search for such jumps.
    Small(usize),
    /// A loop integral is not zero, and the force has a part that is too steep for the samples.
    Steep(usize),
    /// A loop integral of a force of one position is not zero: the force is not a function of the position.
    NoFunction(usize),
    /// The force is different when it is evaluated again.
    Repetitions,
    /// The noise of the force is too large; the index of the loop with the largest error.
    Noise(usize),
    /// Samples do not resolve the force.
    Unresolved(usize),
}

/// A verdict on a force or a vector field, with everything that it rests on.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FieldReport {
    /// The answer.
    pub verdict: FieldVerdict,
    /// −log10 of what the antisymmetric part of the Jacobian does not exceed, relative to the Jacobian, if the force is a gradient and
    /// not constant.
    pub digits: Option<f64>,
    /// The reason.
    pub certainty: Certainty,
    /// The measurements.
    pub evidence: FieldEvidence,
}

impl FieldReport {
    /// The verdict on this evidence.
    pub fn of(evidence: FieldEvidence) -> Self {
        let (certainty, digits) = judge(&evidence);
        let is_force = evidence.kind == FieldKind::Force;
        let verdict = match certainty {
            Certainty::Closed | Certainty::Constant | Certainty::OnePosition => match is_force {
                true => FieldVerdict::Gradient,
                false => FieldVerdict::Hamiltonian,
            },
            Certainty::Work(_) | Certainty::WorkAcrossJumps(_) | Certainty::WorkAroundPeriod(_) => {
                match is_force {
                    true => FieldVerdict::NotAGradient,
                    false => FieldVerdict::NotHamiltonian,
                }
            }
            _ => FieldVerdict::Undecided,
        };
        FieldReport {
            verdict,
            digits,
            certainty,
            evidence,
        }
    }

    /// Whether the force is a gradient, or the field Hamiltonian; `None` if the evidence is not enough.
    pub fn holds(&self) -> Option<bool> {
        match self.verdict {
            FieldVerdict::Gradient | FieldVerdict::Hamiltonian => Some(true),
            FieldVerdict::NotAGradient | FieldVerdict::NotHamiltonian => Some(false),
            FieldVerdict::Undecided => None,
        }
    }
}

/// The loop of some that has the largest value.
fn largest<'e>(
    loops: impl Iterator<Item = (usize, &'e LoopWork)>,
    value: impl Fn(&LoopWork) -> f64,
) -> Option<usize> {
    loops
        .max_by(|a, b| value(a.1).total_cmp(&value(b.1)))
        .map(|(index, _)| index)
}

/// `otherwise`, unless an iteration that stops at a tolerance may have made the integral of a loop.
fn unless_of_solver(evidence: &FieldEvidence, index: usize, otherwise: Certainty) -> Certainty {
    let jumps = evidence.jumps();
    let relative = evidence.loops[index].relative();
    match () {
        () if !evidence.is_small() => otherwise,
        () if jumps > 0.0
            && jumps < MAX_JUMP_OF_SOLVER
            && relative <= MAX_CURL_OVER_JUMPS * jumps =>
        {
            Certainty::Tolerance(index)
        }
        () if !evidence.is_searched && jumps == 0.0 => Certainty::Small(index),
        () => otherwise,
    }
}

fn judge(evidence: &FieldEvidence) -> (Certainty, Option<f64>) {
    let loops = || evidence.loops.iter().enumerate();
    let winds = |work: &LoopWork| matches!(work.kind, FieldLoopKind::Winding { .. });
    let certainty = |work: &LoopWork| work.integral.abs() / work.error();
    let one_position = evidence.kind == FieldKind::Force && evidence.moving == 1;
    // Results that differ for the same state may be anything.
    let differs = evidence.repetitions > 10_f64.powf(-MIN_DIGITS);
    let significant = || loops().filter(|(_, work)| work.is_clear() && !winds(work));
    // A loop without jumps is the best witness.
    let smooth = significant().filter(|(_, work)| work.jumps.is_none() && !work.is_steep);
    if let Some(index) = largest(smooth, certainty) {
        let found = match () {
            () if one_position => Certainty::NoFunction(index),
            () if differs => Certainty::Repetitions,
            () => unless_of_solver(evidence, index, Certainty::Work(index)),
        };
        return (found, None);
    }
    if let Some(index) = largest(significant(), certainty) {
        let found = match () {
            () if one_position => Certainty::NoFunction(index),
            () if differs => Certainty::Repetitions,
            () if evidence.loops[index].is_steep => Certainty::Steep(index),
            () if evidence.jumps() < MAX_SOLVER_TOLERANCE => Certainty::Tolerance(index),
            () => Certainty::WorkAcrossJumps(index),
        };
        return (found, None);
    }
    let around = || loops().filter(|(_, work)| winds(work));
    if let Some(index) = largest(around().filter(|(_, work)| work.is_clear()), certainty) {
        let found = match differs {
            true => Certainty::Repetitions,
            false => unless_of_solver(evidence, index, Certainty::WorkAroundPeriod(index)),
        };
        return (found, None);
    }
    if differs {
        return (Certainty::Repetitions, None);
    }
    let contractible = || loops().filter(|(_, work)| work.kind == FieldLoopKind::Random);
    let enough = |bound: f64| bound <= 10_f64.powf(-MIN_DIGITS);
    let of_periods = around().map(|(_, work)| work.bound()).fold(0.0, f64::max);
    if contractible().all(|(_, work)| work.is_constant) && enough(of_periods) {
        return (Certainty::Constant, None);
    }
    let not_constant = || contractible().filter(|(_, work)| !work.is_constant);
    // A loop shows λ times a random number of the order of 1: the fewer there are, the more likely all of these are small.
    let loops_made = contractible().count().max(1) as f64;
    let allowance = 1.0 + ALLOWANCE_OF_ONE_LOOP / (loops_made * loops_made);
    let bound = not_constant()
        .map(|(_, work)| work.bound())
        .fold(of_periods, f64::max)
        * allowance;
    if one_position && !evidence.is_periodic {
        let digits = enough(bound).then(|| digits(bound));
        return (Certainty::OnePosition, digits);
    }
    // If all loops are smooth, an ellipse that samples do not resolve shows a part of the force that they missed.
    let is_smooth = contractible().all(|(_, work)| work.is_resolved);
    let is_rough = |work: &LoopWork| is_smooth && !work.is_resolved && !enough(work.bound());
    let rough = loops().filter(|(_, work)| is_rough(work));
    match largest(rough, LoopWork::bound) {
        Some(index) => return (Certainty::Unresolved(index), None),
        None if enough(bound) => return (Certainty::Closed, Some(digits(bound))),
        None => {}
    }
    let weakest = largest(not_constant().chain(around()), LoopWork::bound).unwrap_or(0);
    match evidence.loops[weakest].is_resolved {
        true => (Certainty::Noise(weakest), None),
        false => (Certainty::Unresolved(weakest), None),
    }
}

/// With one decimal, rounded down; no more than double precision has.
fn digits(bound: f64) -> f64 {
    (-bound.max(f64::EPSILON).log10() * 10.0).floor() / 10.0
}

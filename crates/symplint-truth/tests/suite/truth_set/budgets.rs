//! The same members with small budgets: undecided, perhaps, and never wrong.

use std::fmt::Write;

use rayon::prelude::*;

use symplint::Verdict;
use symplint::verdict::{BoundFinding, Finding};

use crate::book::grouped;
use crate::truth_set::member::{Expected, Member, Subject};
use crate::truth_set::outcome::{Outcome, diagnose, outcome, outcome_of_error};
use crate::truth_set::{FAMILIES, Family};

/// Evaluations; the last is the default of maps that are called through other languages.
const BUDGETS: [usize; 4] = [200, 1_000, 5_000, 20_000];

/// What came of a member in a budget.
#[derive(Clone)]
pub struct Found {
    pub budget: usize,
    label: String,
    /// `None` for an error.
    outcome: Option<Outcome>,
}

/// Every `part`-th member, from `first` on, of the families named, in all budgets.
pub fn run(part: usize, first: usize, named: impl Fn(&str) -> bool) -> Vec<Found> {
    let families = FAMILIES.iter().filter(|family| named(family.name));
    let members = families.flat_map(|family| {
        (first..family.count)
            .step_by(part)
            .map(move |index| (family, index))
    });
    let all: Vec<(&Family, usize, usize)> = members
        .flat_map(|(family, index)| BUDGETS.map(|budget| (family, index, budget)))
        .collect();
    (all.par_iter())
        .filter_map(|(family, index, budget)| found(family, *index, *budget))
        .collect()
}

/// `None` for loops of another code, which have no budget, and for solvers of other families.
fn found(family: &Family, index: usize, budget: usize) -> Option<Found> {
    let mut member = (family.member)(index);
    // Jumps of solvers have their own table.
    let of_solver = matches!(member.truth.expected, Expected::Tolerance { .. });
    if of_solver && family.name != "tolerance" {
        return None;
    }
    let Subject::Map { diagnostic, .. } = &mut member.subject else {
        return None;
    };
    diagnostic.budget = Some(budget);
    let found = match diagnose(&member.subject) {
        Ok(found) => found,
        Err(error) => {
            let outcome = outcome_of_error(&member, &error);
            return Some(Found {
                budget,
                label: format!("{} {index}: {}", family.name, member.label),
                outcome: (outcome != Outcome::Undecided).then_some(outcome),
            });
        }
    };
    let outcome = match (member.truth.expected, found.verdict.digits) {
        // A small budget need not find it, as long as the digits that it states are not too many.
        (Expected::SmallDefect(defect), Some(digits)) if digits <= -defect.log10() => {
            Outcome::Right
        }
        // Nor errors that the verdict says it may have missed.
        (Expected::Symplectic { .. }, Some(_)) if may_miss(&member, &found.verdict) => {
            Outcome::Right
        }
        _ => outcome(&member, &found),
    };
    Some(Found {
        budget,
        label: format!("{} {index}: {}", family.name, member.label),
        outcome: Some(outcome),
    })
}

/// Whether the errors of the member are rarer than the rarest errors that the verdict excludes.
fn may_miss(member: &Member, verdict: &Verdict) -> bool {
    let stated = verdict.findings.iter().find_map(|finding| match finding {
        Finding::Bounds(BoundFinding::Resolution { one_in, .. }) => *one_in,
        _ => None,
    });
    let known = member.truth.one_in.zip(stated);
    known.is_some_and(|(known, stated)| known > stated)
}

/// The mistake in words.
pub fn wrong(found: &[Found]) -> Vec<String> {
    let wrong = found.iter().filter_map(|found| match &found.outcome {
        Some(Outcome::Wrong(text)) => Some(format!("{}, {}: {text}", found.label, found.budget)),
        _ => None,
    });
    wrong.collect()
}

/// The number of wrong verdicts with this budget.
pub fn wrong_of(found: &[Found], budget: usize) -> usize {
    let is_wrong =
        |found: &&Found| found.budget == budget && matches!(found.outcome, Some(Outcome::Wrong(_)));
    found.iter().filter(is_wrong).count()
}

/// Outcomes by budget, as markdown: of most families, and of those in which a small budget can miss what a map does.
pub fn table(most: &[Found], hard: &[Found]) -> String {
    let mut text =
        "| families | budget | members | right | undecided | refused | wrong |\n|---|---|---|---|---|---|---|\n"
            .to_owned();
    for (families, found) in [
        ("the other families", most),
        ("tolerance, strips, memory", hard),
    ] {
        for budget in BUDGETS {
            let of = || found.iter().filter(|found| found.budget == budget);
            let count = |outcome| of().filter(|found| found.outcome == outcome).count();
            writeln!(
                text,
                "| {families} | {} | {} | {} | {} | {} | {} |",
                grouped(budget),
                grouped(of().count()),
                grouped(count(Some(Outcome::Right))),
                grouped(count(Some(Outcome::Undecided))),
                grouped(count(None)),
                wrong_of(found, budget),
            )
            .unwrap();
        }
    }
    text
}

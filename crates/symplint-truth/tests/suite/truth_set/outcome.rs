//! Right, undecided or wrong.

use symplint::evidence::Scatter;
use symplint::verdict::{Finding, MapFinding};
use symplint::{Diagnosis, Ensemble, Error, Snapshot, VerdictKind, measure};

use crate::truth_set::member::{Expected, Member, Subject, Truth};
use crate::truth_set::ratios::given_breaks;
use crate::truth_set::rounding::Rounding;

/// Defects below this need not be found, as long as the digits that are stated are not too many: round-off of a step of
/// a hundred operations.
pub const FAINT: f64 = 1e-12;

/// The outcome of a verdict.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    Right,
    Undecided,
    /// Why.
    Wrong(String),
}

/// The order that was stated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    Right,
    /// None.
    Open,
    Wrong(f64),
}

/// Diagnoses a member.
pub fn diagnose(subject: &Subject) -> Result<Diagnosis, symplint::Error> {
    match subject {
        Subject::Map {
            map,
            on,
            diagnostic,
            ..
        } => diagnostic.run(map, on),
        Subject::Samples {
            map,
            on,
            samples,
            spacing,
            step_sizes,
            rounding,
        } => {
            let s = spacing.parameters(*samples);
            let mut before = Ensemble::zeros(on.dof(), s.len());
            on.sample(&s, &mut before.block());
            let unit = match rounding {
                Rounding::Single => Snapshot::SINGLE,
                Rounding::Digits(count) => 0.5 * 10f64.powi(1 - *count as i32),
                Rounding::None | Rounding::Decimals(_) | Rounding::Multiples(_) => Snapshot::DOUBLE,
            };
            let snapshot = |mut states: Ensemble| {
                let mut block = states.block();
                for i in 0..block.dof() {
                    rounding.state(block.q.row_mut(i));
                    rounding.state(block.p.row_mut(i));
                }
                Snapshot::new(states).with_unit_roundoff(unit)
            };
            let after: Vec<Snapshot> = (step_sizes.iter())
                .map(|&h| {
                    let mut states = before.clone();
                    map.advance(h, &mut states.block())
                        .expect("a step that works");
                    snapshot(states).after_step(h)
                })
                .collect();
            measure(&snapshot(before), &after, &map.capabilities().coordinates)
        }
    }
}

/// What an error is: right, if the map is to be refused.
pub fn outcome_of_error(member: &Member, error: &Error) -> Outcome {
    match (member.truth.expected, error) {
        (Expected::Refused, Error::Memory { .. }) => Outcome::Right,
        (_, Error::Memory { .. }) => Outcome::Wrong(error.to_string()),
        // Others say what to do, and decide nothing.
        _ => Outcome::Undecided,
    }
}

/// Whether the verdict is that the step draws random numbers.
fn is_random(diagnosis: &Diagnosis) -> bool {
    let first = diagnosis.verdict.findings.first();
    matches!(first, Some(Finding::Map(MapFinding::Scatter(scatter))) if Scatter::is_random(scatter))
}

/// Whether the verdict is the right one.
pub fn outcome(member: &Member, diagnosis: &Diagnosis) -> Outcome {
    let verdict = &diagnosis.verdict;
    let wrong = || Outcome::Wrong(format!("{}: {}", verdict.headline(), verdict.summary()));
    let right = |is: bool| if is { Outcome::Right } else { wrong() };
    let digits = verdict.digits.unwrap_or(0.0);
    // Digits are rounded down to a tenth.
    let honest = |defect: f64| digits <= -defect.log10();
    match (member.truth.expected, verdict.kind) {
        (Expected::Noisy { .. }, VerdictKind::Undecided) if is_random(diagnosis) => Outcome::Right,
        (_, VerdictKind::Undecided) => Outcome::Undecided,
        (Expected::Refused, _) => wrong(),
        (Expected::Noisy { most_digits }, VerdictKind::Symplectic) => right(digits <= most_digits),
        (Expected::Noisy { .. }, _) => wrong(),
        (Expected::Symplectic { most_digits }, VerdictKind::Symplectic) => {
            right(digits <= most_digits)
        }
        (Expected::WrongPeriod, VerdictKind::Symplectic) => Outcome::Right,
        (Expected::Symplectic { .. } | Expected::WrongPeriod, _) => wrong(),
        (Expected::NotSymplectic, kind) => right(kind == VerdictKind::NotSymplectic),
        (Expected::SmallDefect(_), VerdictKind::NotSymplectic) => Outcome::Right,
        (Expected::SmallDefect(defect), VerdictKind::Symplectic) => {
            right(defect < FAINT && honest(defect))
        }
        (Expected::Hidden(_), VerdictKind::NotSymplectic) => Outcome::Right,
        (Expected::Hidden(defect), VerdictKind::Symplectic) => right(honest(defect)),
        (Expected::SmallDefect(_) | Expected::Hidden(_), VerdictKind::BrokenLoops) => wrong(),
        (Expected::Broken { closed }, VerdictKind::BrokenLoops) => {
            let said = verdict.conserved_once_closed;
            right(said.is_none() || closed.is_none() || said == closed)
        }
        // A loop whose integral changes even once it is closed is not symplectic between its breaks.
        (Expected::Broken { closed }, VerdictKind::NotSymplectic) => right(closed == Some(false)),
        (Expected::Broken { .. }, VerdictKind::Symplectic) => wrong(),
        // If the given loop is whole, random loops may break.
        (Expected::Tolerance { breaks, .. }, VerdictKind::BrokenLoops) => {
            right(breaks > 0 || given_breaks(diagnosis).is_none_or(|found| found.is_empty()))
        }
        (Expected::Tolerance { whole, .. }, VerdictKind::NotSymplectic) => right(!whole),
        (Expected::Tolerance { defect, .. }, VerdictKind::Symplectic) => right(honest(defect)),
    }
}

/// Whether the order is the right one, if one is known.
pub fn order(truth: &Truth, diagnosis: &Diagnosis) -> Option<Order> {
    if truth.orders.is_empty() || diagnosis.verdict.kind != VerdictKind::NotSymplectic {
        return None;
    }
    Some(match diagnosis.verdict.order {
        None => Order::Open,
        Some(order) if truth.orders.contains(&order) => Order::Right,
        Some(order) => Order::Wrong(order),
    })
}

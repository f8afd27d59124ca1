//! Follows the advice of an undecided verdict until it is decided.

use std::sync::Arc;

use symplint::diagnosis::SampleCount;
use symplint::map::balanced_radii;
use symplint::verdict::{Advice, BoundFinding, Finding};
use symplint::{Block, Circle, Diagnosis, Diagnostic, Ensemble, Loop, Rule};

use crate::truth_set::member::{Member, Subject};
use crate::truth_set::outcome::{Outcome, diagnose, outcome};
use crate::truth_set::rounding::Rounding;

/// Advice is followed this number of times.
const ROUNDS: usize = 3;

/// What came of it.
#[derive(Clone, Debug, PartialEq)]
pub enum Followed {
    /// The right verdict.
    Decides,
    /// The right verdict of the same map in double precision, or solved to round-off, as the advice says.
    InFullPrecision,
    /// Still undecided, and after which advice.
    Open(String),
    /// A wrong verdict.
    Wrong(String),
}

/// A loop, larger or smaller round its centre in some degrees of freedom.
struct Stretched {
    of: Arc<dyn Loop>,
    factor: f64,
    dofs: Vec<usize>,
    centre: [Vec<f64>; 2],
}

impl Stretched {
    fn new(of: &Arc<dyn Loop>, factor: f64) -> Self {
        Self::in_dofs(of, factor, (0..of.dof()).collect())
    }

    fn in_dofs(of: &Arc<dyn Loop>, factor: f64, dofs: Vec<usize>) -> Self {
        let samples = Ensemble::sample(of, 64).expect("a loop that can be sampled");
        let mean = |rows: symplint::state::Rows<'_>| {
            (0..rows.count())
                .map(|i| rows.row(i).iter().sum::<f64>() / 64.0)
                .collect()
        };
        Stretched {
            of: of.clone(),
            factor,
            dofs,
            centre: [mean(samples.q()), mean(samples.p())],
        }
    }
}

impl Loop for Stretched {
    fn dof(&self) -> usize {
        self.of.dof()
    }

    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        self.of.sample(s, block);
        for &i in &self.dofs {
            for (rows, centre) in [
                (&mut block.q, &self.centre[0]),
                (&mut block.p, &self.centre[1]),
            ] {
                for x in rows.row_mut(i) {
                    *x = centre[i] + self.factor * (*x - centre[i]);
                }
            }
        }
    }
}

/// The member as the advice wants it, and whether it is in full precision now; `None` where the advice cannot be
/// followed.
fn changed(subject: &Subject, advice: &Advice, found: &Diagnosis) -> Option<(Subject, bool)> {
    let mut changed = subject.clone();
    let mut exact = false;
    match &mut changed {
        Subject::Map {
            map,
            on,
            diagnostic,
            full,
            projected,
        } => {
            let largest = found
                .points()
                .iter()
                .map(|at| at.step_size.abs())
                .fold(0.0, f64::max);
            match advice {
                Advice::LargerSteps { factor, .. } => {
                    **diagnostic = larger_steps(diagnostic, largest, factor.unwrap_or(100.0));
                }
                Advice::LoopWithForces | Advice::ReturnStates => {
                    **diagnostic = larger_steps(diagnostic, largest, 1e4);
                }
                Advice::SmallerSteps { .. } => {
                    **diagnostic = larger_steps(diagnostic, largest, 0.1);
                }
                Advice::BalancedRadii { .. } => {
                    let [q0, p0] = Stretched::new(on, 1.0).centre;
                    let h = diagnostic.typical_step.unwrap_or(largest);
                    let radii = balanced_radii(map, &q0, &p0, h).ok()?;
                    let circle = Circle::with_radii(q0, p0, radii.q, radii.p).ok()?;
                    *on = Arc::new(circle);
                }
                Advice::LargerLoopOrMoreSamples => *on = Arc::new(Stretched::new(on, 3.0)),
                Advice::LoopBesidePoint => *on = Arc::new(Stretched::new(on, 0.1)),
                Advice::ContractibleLoops | Advice::MoreLoops => diagnostic.loops = 8,
                Advice::MoreEvaluations { wanted } => {
                    diagnostic.budget = Some(found.evidence.evaluations.budget + wanted);
                }
                Advice::LargerRadii { factor } => *on = Arc::new(Stretched::new(on, *factor)),
                Advice::LargerLoop => *on = Arc::new(Stretched::new(on, 10.0)),
                Advice::LargerRadiiOfGroup => {
                    let group = found
                        .verdict
                        .findings
                        .iter()
                        .find_map(|finding| match finding {
                            Finding::Bounds(BoundFinding::Group { dofs, .. }) => Some(dofs.clone()),
                            _ => None,
                        });
                    *on = Arc::new(Stretched::in_dofs(on, 3.0, group?));
                }
                Advice::SmallerLoop { .. } => *on = Arc::new(Stretched::new(on, 0.1)),
                Advice::SmallerLoopInDomain => *on = Arc::new(Stretched::new(on, 0.3)),
                Advice::MoreSamplesOrSmallerLoop | Advice::SamplesInCells => more(diagnostic),
                Advice::MoreSamplesAndLargerSteps => {
                    **diagnostic = larger_steps(diagnostic, largest, 1.5);
                    more(diagnostic);
                }
                Advice::OtherLoops => (diagnostic.seed, diagnostic.loops) = (77, 24),
                Advice::RuleAuto => {
                    (diagnostic.rule, diagnostic.samples) = (Rule::Auto, SampleCount::Auto);
                }
                Advice::Project | Advice::LoopOnManifold | Advice::KeepToLeaf => {
                    *map = projected.clone()?;
                }
                Advice::MoreDigits
                | Advice::TightenSolver
                | Advice::SameRandomNumbers
                | Advice::LetStepConverge { .. } => {
                    *map = full.clone()?;
                    exact = true;
                }
                Advice::Remedy { text } if tightens(text) => {
                    *map = full.clone()?;
                    exact = true;
                }
                Advice::UseStepSize => diagnostic.has_step_size = false,
                Advice::StepsAtOnce { repeat, .. } => {
                    diagnostic.repeat *= repeat;
                    diagnostic.budget = None;
                }
                other => return not_here(other),
            }
        }
        Subject::Samples {
            samples,
            step_sizes,
            rounding,
            ..
        } => match advice {
            // A larger loop "and states in double precision".
            Advice::MoreDigits | Advice::LargerLoop => {
                *rounding = Rounding::None;
                exact = true;
            }
            Advice::MoreSamplesOfFile => *samples *= 4,
            Advice::LargerSteps {
                factor: Some(factor),
                ..
            } => {
                step_sizes.iter_mut().for_each(|h| *h *= factor);
            }
            other => return not_here(other),
        },
    }
    Some((changed, exact))
}

/// Advice that no member can follow: it belongs to verdicts that are decided, to a force of another shape, or to files.
/// Other advice has to be followed.
fn not_here(advice: &Advice) -> Option<(Subject, bool)> {
    let known = matches!(
        advice,
        Advice::MeasureLoop
            | Advice::StatePeriod
            | Advice::PeriodIfPeriodic
            | Advice::OrderOfSamples
            | Advice::MoreSamplesOfFile
            | Advice::MoreLoopsOfFile
            | Advice::SmootherForce
            | Advice::Remedy { .. }
            | Advice::LookForCause { .. }
            | Advice::LookBeyondFriction
            | Advice::StateStepSizes
            | Advice::CheckCopies
            | Advice::MoreStepSizes { .. }
            | Advice::NoOrder { .. }
            // Of files.
            | Advice::TightenSolver
            | Advice::LargerSteps { factor: None, .. }
            | Advice::LoopWithForces
            | Advice::SamplesInCells
    );
    assert!(known, "no member follows {advice:?}");
    None
}

fn larger_steps(diagnostic: &Diagnostic, largest: f64, factor: f64) -> Diagnostic {
    Diagnostic {
        step_sizes: (0..10).map(|m| factor * largest * 0.5f64.powi(m)).collect(),
        typical_step: None,
        ..diagnostic.clone()
    }
}

/// Four times the samples, and the budget for them.
fn more(diagnostic: &mut Diagnostic) {
    diagnostic.samples = match diagnostic.samples {
        SampleCount::Fixed(count) => SampleCount::Fixed(4 * count),
        SampleCount::Auto => SampleCount::Fixed(1 << 16),
    };
    diagnostic.budget = Some(20_000_000);
}

/// A map that fails on the given loop: its error wants a smaller one.
pub fn follow_error(member: &Member, error: &symplint::Error) -> Followed {
    let mut member = member.clone();
    for _ in 0..5 {
        if let Subject::Map { on, .. } = &mut member.subject {
            *on = Arc::new(Stretched::new(on, 0.1));
        }
        let Ok(found) = diagnose(&member.subject) else {
            continue;
        };
        return match outcome(&member, &found) {
            Outcome::Right => Followed::Decides,
            Outcome::Undecided => follow(&member, &found),
            Outcome::Wrong(why) => Followed::Wrong(why),
        };
    }
    Followed::Open(format!("error: {error}"))
}

/// Follows advice, again and again: first what the same map can do, then more digits or a tighter solver.
pub fn follow(member: &Member, diagnosis: &Diagnosis) -> Followed {
    let of_map = followed(member, diagnosis, |advice| !lifts_a_limit(advice));
    match of_map {
        Followed::Open(why) => match followed(member, diagnosis, |_| true) {
            Followed::Open(_) => Followed::Open(why),
            other => other,
        },
        other => other,
    }
}

/// Whether an advice is to change the precision of the map.
fn lifts_a_limit(advice: &Advice) -> bool {
    match advice {
        Advice::Remedy { text } => tightens(text),
        _ => matches!(
            advice,
            Advice::MoreDigits
                | Advice::TightenSolver
                | Advice::SameRandomNumbers
                | Advice::LetStepConverge { .. }
        ),
    }
}

/// Whether a remedy is to tighten the tolerance of a solver.
fn tightens(remedy: &str) -> bool {
    remedy.starts_with("Tighten the tolerance")
}

fn followed(member: &Member, diagnosis: &Diagnosis, wanted: impl Fn(&Advice) -> bool) -> Followed {
    let (mut member, mut found) = (member.clone(), diagnosis.clone());
    let mut exact = false;
    for _ in 0..ROUNDS {
        // What lifts a limit comes first, if it is wanted.
        let mut advice: Vec<Advice> = found.verdict.advice.clone();
        advice.retain(&wanted);
        advice.sort_by_key(|advice| !lifts_a_limit(advice));
        let next = advice
            .iter()
            .find_map(|advice| changed(&member.subject, advice, &found));
        let Some((subject, now_exact)) = next else {
            return Followed::Open(format!(
                "{} Advice {:?}",
                found.verdict, found.verdict.advice
            ));
        };
        exact |= now_exact;
        member.subject = subject;
        member.truth.expected = if exact {
            member.truth.expected.in_full_precision()
        } else {
            member.truth.expected
        };
        found = match diagnose(&member.subject) {
            Ok(found) => found,
            Err(error) => return Followed::Open(format!("{advice:?}: {error}")),
        };
        match outcome(&member, &found) {
            Outcome::Right if exact => return Followed::InFullPrecision,
            Outcome::Right => return Followed::Decides,
            Outcome::Wrong(why) => return Followed::Wrong(format!("{why} Advice {advice:?}")),
            Outcome::Undecided => {}
        }
    }
    let (verdict, first) = (&found.verdict, &diagnosis.verdict);
    Followed::Open(format!(
        "{} Advice {:?}; after three rounds {verdict}",
        first, first.advice
    ))
}

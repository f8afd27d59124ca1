//! Broken loops.

use std::fmt::{Display, Formatter, Result};

use serde::Serialize;

use super::{Change, Step, plural};
use crate::breaks::Break;
use crate::text::{capitalised, jumping, loop_name, significant, two_digits};

/// Broken loops.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
#[non_exhaustive]
pub enum BreakFinding {
    /// The map is discontinuous: an advanced loop jumps, by more than the rounding of the map, where no double lies
    /// between the two sides, and the jump stands out of the noise next to it.
    Discontinuous {
        /// The largest jump of the loop that shows it.
        jump: Break,
        /// Whether the closed integrals are conserved, if that is known.
        conserved: Option<bool>,
    },
    /// The place of the largest jump.
    Jump {
        /// Which loop.
        loop_index: usize,
        /// The step.
        step: Step,
        /// Breaks of that loop that were found, if they can be closed.
        breaks: Option<usize>,
        /// Whether there may be more: if a solver stops at a tolerance, two may be too close to each other to be seen.
        at_least: bool,
        /// The largest jump.
        jump: Break,
        /// Whether only samples are known.
        sampled: bool,
    },
    /// How many loops are broken.
    BrokenCount {
        /// Broken ones.
        broken: usize,
        /// Advanced loops.
        of: usize,
    },
    /// All loop integrals are conserved once breaks are closed.
    ClosedConserved {
        /// No closed defect exceeds this.
        bound: f64,
        /// Whether they are closed by straight chords, as substeps are not known.
        #[serde(default)]
        straight: bool,
        /// The loop with the largest.
        loop_index: usize,
        /// The step.
        step: Step,
    },
    /// A closed loop integral changes.
    ClosedChanges {
        /// By how much.
        change: Change,
        /// Whether it is closed by straight chords, as substeps are not known: this does not count as evidence.
        #[serde(default)]
        straight: bool,
        /// If the change does not count as evidence: what other curves that close the breaks could contribute.
        #[serde(default)]
        bend: Option<f64>,
        /// Which loop.
        loop_index: usize,
        /// The step.
        step: Step,
    },
}

impl Display for BreakFinding {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            BreakFinding::Discontinuous { jump, conserved } => {
                let closed = match conserved {
                    Some(true) => " With the breaks closed its loop integrals are conserved.",
                    Some(false) => " Its loop integrals change even with the breaks closed.",
                    None => "",
                };
                write!(
                    f,
                    "The map is discontinuous: {} between two neighbouring states, at s = {:.6}.{closed}",
                    jumping(jump.dof, jump.jump_q, jump.jump_p),
                    jump.s
                )
            }
            BreakFinding::Jump {
                loop_index,
                step,
                breaks,
                at_least,
                jump,
                sampled,
            } => match sampled {
                true => fmt_sampled_jump(f, step, jump),
                false => fmt_jump(f, *loop_index, step, (*breaks, *at_least), jump),
            },
            BreakFinding::BrokenCount { broken, of } => {
                write!(
                    f,
                    "{broken} of {of} advanced loops are broken (your loop at each step size, and random loops)."
                )
            }
            BreakFinding::ClosedConserved {
                bound,
                straight,
                loop_index,
                step,
            } => write!(
                f,
                "With their breaks closed{} all loop integrals are conserved to {bound:.1e} (worst case: {}, {step}).",
                by_chords(*straight),
                loop_name(*loop_index)
            ),
            BreakFinding::ClosedChanges {
                change,
                straight,
                bend,
                loop_index,
                step,
            } => {
                let (by_chords, name) = (by_chords(*straight), loop_name(*loop_index));
                match (straight, bend) {
                    (false, None) => write!(
                        f,
                        "With its breaks closed the integral of {name} still changes by {change} {step}."
                    ),
                    (false, Some(bend)) => write!(
                        f,
                        "If straight lines close its breaks, the integral of {name} changes by {change} {step}. This does not count as \
                         evidence: q and p of a degree of freedom jump together, and other curves across the breaks contribute about as \
                         much as {bend:.1e}."
                    ),
                    (true, _) => write!(
                        f,
                        "With its breaks closed{by_chords} the integral of {name} changes by {change} {step}. This does not count as \
                         evidence: the curve that closes a break depends on the substeps, which are not known."
                    ),
                }
            }
        }
    }
}

fn fmt_jump(
    f: &mut Formatter<'_>,
    loop_index: usize,
    step: &Step,
    (breaks, at_least): (Option<usize>, bool),
    jump: &Break,
) -> Result {
    let times = breaks.map_or(String::new(), |count| {
        let at_least = if at_least { "at least " } else { "" };
        format!(" in {at_least}{count} place{}", plural(count))
    });
    write!(
        f,
        "{} {} breaks{times}; the largest jump, by {}, is at s = {}",
        capitalised(&step.to_string()),
        loop_name(loop_index),
        sizes(jump),
        significant(jump.s)
    )?;
    match jump.substep {
        Some(substep) => write!(
            f,
            ", made by substep {} of the map.",
            substep.saturating_add(1)
        ),
        None => f.write_str("."),
    }
}

/// The sizes of a jump. A coordinate whose jump is a thousandth of the other one is left out.
fn sizes(jump: &Break) -> String {
    let dof = jump.dof;
    let (q, p) = (jump.jump_q, jump.jump_p);
    let (of_q, of_p) = (two_digits(q), two_digits(p));
    if q.abs() > 1e3 * p.abs() {
        format!("{of_q} in q[{dof}]")
    } else if p.abs() > 1e3 * q.abs() {
        format!("{of_p} in p[{dof}]")
    } else {
        format!("{of_q} in q[{dof}] and {of_p} in p[{dof}]")
    }
}

/// How breaks are closed, if it is not in the substeps that cause them.
fn by_chords(straight: bool) -> &'static str {
    match straight {
        true => " by straight chords",
        false => "",
    }
}

fn fmt_sampled_jump(f: &mut Formatter<'_>, step: &Step, jump: &Break) -> Result {
    write!(
        f,
        "The largest jump {step}, near s = {:.6}, is {} in q[{dof}] and {} in p[{dof}]. It is as large among every second and every fourth \
         sample, as a true jump is.",
        jump.s,
        two_digits(jump.jump_q),
        two_digits(jump.jump_p),
        dof = jump.dof
    )
}

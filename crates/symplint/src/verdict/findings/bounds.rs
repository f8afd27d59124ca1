//! Bounds on the change of loop integrals.

use std::fmt::{Display, Formatter, Result};

use serde::Serialize;

use super::{Step, StepRange, coordinates, plural};
use crate::text::{capitalised, loop_name, short, size};

/// Bounds on the change of loop integrals.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
#[non_exhaustive]
pub enum BoundFinding {
    /// No defect was found, on loops that bound it to 1e-6 or better and that a step moves enough to show one.
    Conserved {
        /// No defect exceeds this.
        bound: f64,
        /// Step sizes of the given loop.
        range: StepRange,
        /// Step sizes at which the map failed.
        failed: usize,
        /// Random loops that bound the defect as well.
        random: usize,
        /// Whether the given loop counts: a loop that winds does not.
        given: bool,
        /// The largest radii of a position and of a momentum, if the verdict is about loops of this size: the map has no
        /// step size, or moves them little.
        radii: Option<[f64; 2]>,
    },
    /// How large the defects of a loop may be.
    Bound {
        /// Which loop.
        loop_index: usize,
        /// Samples; `None` by the piecewise rule.
        samples: Option<usize>,
        /// The bound; `None` where nothing is known.
        bound: Option<f64>,
        /// |E| as measured.
        measured: f64,
        /// Its uncertainty.
        uncertainty: Option<f64>,
        /// The step.
        step: Step,
    },
    /// The given loop, or every random one, bounds the defect by no more than 1e-6.
    WeakBound {
        /// Which loop.
        loop_index: usize,
        /// The bound.
        bound: f64,
        /// The step.
        step: Step,
        /// Whether round-off makes most of it.
        roundoff: bool,
    },
    /// How large the defects in a group of degrees of freedom of similar action may be.
    Group {
        /// Which group, the one with the largest actions first.
        index: usize,
        /// All groups.
        of: usize,
        /// Its degrees of freedom.
        dofs: Vec<usize>,
        /// Its largest action, as a part of the largest of all.
        action: f64,
        /// Loops that move it.
        loops: usize,
        /// The bound of these loops.
        by_loops: Option<f64>,
        /// The bound of the Jacobian.
        by_jacobian: Option<f64>,
    },
    /// Features narrower than the distance of samples are not resolved, and errors at few states need not be met.
    Resolution {
        /// Samples of the given loop.
        samples: usize,
        /// The loops that bound the defect may miss errors at fewer than 1 in this number of states; `None` without such a loop.
        one_in: Option<usize>,
    },
    /// The loop of the verdict moves degrees of freedom that your loop leaves at rest.
    MovesRest {
        /// Which loop.
        loop_index: usize,
    },
    /// Neighbouring samples are more than half a cell of the map's grid, or a quarter of a period, apart.
    MissesGrid {
        /// Which loop.
        loop_index: usize,
        /// Cells, or half periods, between neighbouring samples.
        cells_apart: f64,
        /// The step.
        step: Step,
    },
    /// All samples came out at one state, which may be rounding: if its numbers are 0, or larger than the loop is wide.
    OneState,
    /// The map fails on every random loop.
    RandomLoopsFail,
    /// The budget left no random loop, and a symmetric given loop can hide a defect.
    NoRandomLoop,
    /// The map failed on a loop.
    LoopFailed {
        /// Which loop.
        loop_index: usize,
        /// Its error.
        reason: String,
    },
}

impl Display for BoundFinding {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            BoundFinding::Conserved {
                bound,
                range,
                failed,
                random,
                given,
                radii,
            } => write!(
                f,
                "No change above {bound:.1e}: {}{}.",
                on_loops(*given, *random, range, *failed),
                with_radii(*radii)
            ),
            BoundFinding::Bound {
                loop_index,
                samples,
                bound,
                measured,
                uncertainty,
                step,
            } => {
                let by = samples.map_or("piecewise".into(), |samples| format!("{samples} samples"));
                let name = capitalised(&loop_name(*loop_index));
                match (bound, uncertainty) {
                    (Some(bound), Some(uncertainty)) => write!(
                        f,
                        "{name} ({by}) {step}: |E| ≤ {bound:.1e}; measured {} ± {uncertainty:.1e}.",
                        short(*measured)
                    ),
                    _ => write!(f, "{name} ({by}) {step}: E is not known."),
                }
            }
            BoundFinding::WeakBound {
                loop_index,
                bound,
                step,
                ..
            } => write!(
                f,
                "All that is known {step} is that the change of {} is below {bound:.1e}. A verdict needs a bound of 1e-6.",
                loop_name(*loop_index)
            ),
            BoundFinding::Group {
                index,
                of,
                dofs,
                action,
                loops,
                by_loops,
                by_jacobian,
            } => group(
                f,
                [*index, *of],
                dofs,
                *action,
                (*loops, *by_loops),
                *by_jacobian,
            ),
            BoundFinding::Resolution { samples, one_in } => resolution(f, *samples, *one_in),
            BoundFinding::MovesRest { loop_index } => write!(
                f,
                "{} also moves degrees of freedom that your loop leaves at rest.",
                capitalised(&loop_name(*loop_index))
            ),
            BoundFinding::MissesGrid {
                loop_index,
                cells_apart,
                step,
            } => write!(
                f,
                "Neighbouring samples of {} are {} grid cells (or half periods) apart {step}: there are too few samples to resolve the \
                 loop.",
                loop_name(*loop_index),
                short(*cells_apart)
            ),
            BoundFinding::OneState => f.write_str(
                "The step returns one state for all samples of the loop: it has no other results, or rounds them to more than \
                 the loop's size.",
            ),
            BoundFinding::RandomLoopsFail => {
                f.write_str("The map fails on every random loop of the size of your loop.")
            }
            BoundFinding::NoRandomLoop => f.write_str(
                "The budget was too small for more than your loop, and a symmetric loop can hide a defect.",
            ),
            BoundFinding::LoopFailed { loop_index, reason } => write!(
                f,
                "{} was not measured, the map fails on it: {reason}.",
                capitalised(&loop_name(*loop_index))
            ),
        }
    }
}

fn resolution(f: &mut Formatter<'_>, samples: usize, one_in: Option<usize>) -> Result {
    write!(
        f,
        "Other regions of phase space and details finer than 1/{samples} of a loop were not tested"
    )?;
    match one_in {
        Some(one_in) => write!(
            f,
            ", and an error that affects fewer than 1 in {one_in} states can be missed."
        ),
        None => f.write_str("."),
    }
}

/// `on your loop for h from 0.1 to 0.5, and on 7 random ones at h = 0.5`.
fn on_loops(given: bool, random: usize, range: &StepRange, failed: usize) -> String {
    let but_failed = but_failed(failed);
    match given {
        true => {
            let random = random_loops(random, range);
            format!("on your loop{range}{but_failed}{random}")
        }
        false => format!(
            "on {random} random loop{}{range}{but_failed}; your loop winds around a period",
            plural(random)
        ),
    }
}

/// `, with radii up to 0.1 in q and 2 in p`.
fn with_radii(radii: Option<[f64; 2]>) -> String {
    radii.map_or(String::new(), |[q, p]| {
        format!(", with radii up to {} in q and {} in p", short(q), short(p))
    })
}

/// `, and the bound of a range`, for random loops.
fn random_loops(count: usize, range: &StepRange) -> String {
    let high = match range {
        StepRange::Unknown | StepRange::Map => String::new(),
        StepRange::One(h) => format!(" at h = {}", size(*h)),
        StepRange::Between(low, high) => {
            let largest = if low.abs() > high.abs() { low } else { high };
            format!(" at h = {}", size(*largest))
        }
    };
    match count {
        0 => String::new(),
        1 => format!(", and on a random one{high}"),
        others => format!(", and on {others} random ones{high}"),
    }
}

/// ` (the map failed at 2 others)`, after a range of step sizes.
fn but_failed(count: usize) -> String {
    match count {
        0 => String::new(),
        1 => " (the map failed at another one)".to_owned(),
        others => format!(" (the map failed at {others} others)"),
    }
}

fn group(
    f: &mut Formatter<'_>,
    [index, of]: [usize; 2],
    dofs: &[usize],
    action: f64,
    (loops, by_loops): (usize, Option<f64>),
    by_jacobian: Option<f64>,
) -> Result {
    write!(
        f,
        "Group {} of {of} ({} and their momenta), ",
        index + 1,
        coordinates('q', dofs)
    )?;
    match index {
        0 => f.write_str("with the largest actions: ")?,
        _ => write!(
            f,
            "whose actions (areas of the loop in the planes of q[i] and p[i]) are {action:.0e} of the largest or less: "
        )?,
    }
    match by_loops {
        Some(bound) => write!(f, "|E| ≤ {bound:.1e} on {loops} loops")?,
        None => f.write_str("no loop bounds its change")?,
    }
    match by_jacobian {
        Some(bound) => write!(f, "; the Jacobian bounds it by {bound:.1e}."),
        None => f.write_str("."),
    }
}

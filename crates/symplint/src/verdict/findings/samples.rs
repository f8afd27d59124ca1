//! Loops of another code.

use std::fmt::{Display, Formatter, Result};

use serde::Serialize;

use super::{Change, Step};
use crate::breaks::Break;
use crate::text::{capitalised, short};

/// Loops of another code.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
#[non_exhaustive]
pub enum SampleFinding {
    /// A position without a stated period jumps by its whole range, before the step or after it, as samples show it.
    Wrapped {
        /// Degree of freedom.
        dof: usize,
        /// The range.
        period: f64,
        /// `None` before the step.
        step: Option<Step>,
    },
    /// The samples before the step jump: they form no closed loop.
    NotClosed {
        /// The jump.
        jump: Break,
    },
    /// Loops that are known by their samples only jump between neighbouring samples, by more than 1e-6 of a coordinate's
    /// range, and by as much with every second and every fourth sample.
    JumpingSamples {
        /// Loops that jump.
        loops: usize,
        /// Loops in all.
        of: usize,
        /// Confirmed jumps of the loop that has most of them.
        jumps: usize,
        /// Which loop that is.
        step: Step,
        /// Samples of each loop.
        samples: usize,
    },
    /// Jumps too small to be told from the output precision of the map.
    SmallJumps {
        /// As a part of the range of the coordinate.
        size: f64,
        /// The step.
        step: Step,
    },
    /// Cells that look like jumps and are not confirmed with fewer samples: too few to tell.
    TooFewForJumps {
        /// Cells.
        cells: usize,
        /// The step.
        step: Step,
        /// Samples.
        samples: usize,
    },
    /// The quadrature error of a sampled loop is not known.
    UnknownIntegral {
        /// Samples.
        samples: usize,
        /// The step.
        step: Step,
        /// Whether there are too few samples to tell at all.
        too_few: bool,
    },
    /// Rows look shuffled: sorted along the loop, neighbours are four times nearer to each other, or more.
    Shuffled {
        /// Mean distance of neighbouring samples over that of sorted ones.
        ratio: f64,
    },
    /// The last row of a loop of another code repeats the first one.
    RepeatedRow {
        /// Its number, counted from 0.
        row: usize,
    },
    /// The rows of a loop of another code are not equally spaced.
    UnequalRows {
        /// The widest gap between neighbours, as a part of the loop.
        widest: f64,
        /// The same in units of the mean gap.
        over_mean: f64,
    },
    /// The integral of a sampled loop with and without chords across its jumps.
    SampledBreaks {
        /// The step.
        step: Step,
        /// Cells that look like jumps.
        cells: usize,
        /// Confirmed ones.
        confirmed: usize,
        /// Without the jumping cells.
        open: Change,
        /// With chords across them.
        closed: Change,
    },
    /// Samples cannot prove a jump.
    SamplesAreNoProof {
        /// Samples.
        samples: usize,
    },
}

impl Display for SampleFinding {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            SampleFinding::Wrapped { dof, period, step } => {
                let when = step.map_or("before the step".into(), |step| step.to_string());
                write!(
                    f,
                    "q[{dof}] jumps by its whole range of {} {when}, as a position in a \
                     periodic box does.",
                    short(*period)
                )
            }
            SampleFinding::NotClosed { jump } => write!(
                f,
                "q[{dof}] and p[{dof}] jump before the step, by {} and {} near s = {:.6}: the samples form no closed loop.",
                short(jump.jump_q),
                short(jump.jump_p),
                jump.s,
                dof = jump.dof
            ),
            SampleFinding::JumpingSamples {
                loops,
                of,
                jumps,
                step,
                samples,
            } => write!(
                f,
                "{loops} of {of} advanced loops jump between neighbouring samples, {jumps} times {step}: the map \
                 is discontinuous at the resolution of {samples} samples."
            ),
            SampleFinding::SmallJumps { size, step } => write!(
                f,
                "Jumps of {} of a coordinate's range {step} may be breaks, or the output precision of single \
                 precision or of a solver inside the step.",
                short(*size)
            ),
            SampleFinding::TooFewForJumps {
                cells,
                step,
                samples,
            } => write!(
                f,
                "{cells} cells look like jumps {step}, but {samples} samples are too few to tell a jump from a \
                 steep slope."
            ),
            SampleFinding::UnknownIntegral {
                samples,
                step,
                too_few,
            } => match too_few {
                true => write!(
                    f,
                    "The integral of the loop is not known: {samples} samples are too few to show whether a loop is smooth. Give {} or more.",
                    crate::evidence::MIN_SAMPLES_OF_SHAPE
                ),
                false => write!(
                    f,
                    "{samples} samples do not resolve the loop {step}: its integral is not known."
                ),
            },
            SampleFinding::Shuffled { ratio } => write!(
                f,
                "The rows do not seem to be in order along the loop: if they were sorted, neighbouring samples would be {} times closer.",
                short(*ratio)
            ),
            SampleFinding::RepeatedRow { row } => write!(
                f,
                "Row {row} repeats row 0, as if both ends of the loop were included: it was left out."
            ),
            SampleFinding::UnequalRows { widest, over_mean } => write!(
                f,
                "The rows are not equally spaced: the widest gap is {} times the mean, {:.2}% of the loop. The integrals \
                 are interpolated, and their errors include the gaps.",
                short(*over_mean),
                100.0 * widest
            ),
            SampleFinding::SampledBreaks {
                step,
                cells,
                confirmed,
                open,
                closed,
            } => write!(
                f,
                "{}: {cells} cells jump, {confirmed} confirmed. The relative change of the loop integral is \
                 {open} without them, {closed} with chords across them.",
                capitalised(&step.to_string())
            ),
            SampleFinding::SamplesAreNoProof { samples } => write!(
                f,
                "Samples do not prove a jump: a slope steeper than 1/{samples} of the loop looks the same."
            ),
        }
    }
}

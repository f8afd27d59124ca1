//! The action of the map on states, apart from loop integrals.

use std::fmt::{Display, Formatter, Result};

use serde::Serialize;

use super::Step;
use crate::evidence::{
    Motion, OutputFormat, OutputPrecision, Reach, Scatter, ScatterKind, WrongPeriod,
    defect_of_order_4,
};
use crate::text::{capitalised, given, one_digit, short, size, two_digits};

/// The action of the map on states, apart from loop integrals.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
#[non_exhaustive]
pub enum MapFinding {
    /// The map rounds what it returns.
    Precision(OutputPrecision),
    /// The map works in single precision inside.
    SingleInside,
    /// Results of one state differ, by rounding or at random.
    Scatter(Scatter),
    /// A state has the same result at all step sizes.
    IgnoresStepSize,
    /// A stated period is not one of the map.
    WrongPeriod(WrongPeriod),
    /// The decay of the Fourier coefficients of the advanced loop.
    Regularity {
        /// Sobolev exponent.
        exponent: f64,
        /// The step.
        step: Step,
    },
    /// The largest step advances the motions of no loop by 0.05 rad, or by too little for the bound on the defect: a method of
    /// order 4 would not show one; and a larger step shows a defect, or was not tried. (In loops that another code advanced,
    /// also a kick or a free flight alone that deforms none by 0.2 of its size.)
    LittleMotion {
        /// The strongest motion of a loop.
        motion: Motion,
        /// The group of degrees of freedom whose loops these are, if it is not all.
        #[serde(default)]
        group: Option<usize>,
    },
    /// How the largest step moves the loops.
    Moves {
        /// The strongest motion of a loop.
        motion: Motion,
        /// Whether the map has a step size.
        has_step_size: bool,
    },
    /// The result of a larger step, or of a larger loop of a map without a step size, if the map moves loops little.
    Beyond {
        /// The loop.
        reach: Box<Reach>,
        /// Whether it moves more than the other loops.
        more: bool,
    },
}

impl Display for MapFinding {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            MapFinding::Precision(precision) => fmt_precision(f, precision),
            MapFinding::SingleInside => f.write_str(
                "States that are a few units of single precision apart scatter by as much after the step: the map \
                 appears to compute in single precision.",
            ),
            MapFinding::Scatter(scatter) => fmt_scatter(f, scatter),
            MapFinding::IgnoresStepSize => f.write_str(
                "The step ignores h: a state has the same result at all step sizes.",
            ),
            MapFinding::WrongPeriod(wrong) => write!(
                f,
                "{} is not a period of {}[{}]: after the step, two states that differ by it are {} further apart. No random loop \
                 winds around it. Correct the period, or leave it out.",
                given(wrong.period),
                wrong.coordinate,
                wrong.dof,
                two_digits(wrong.difference)
            ),
            MapFinding::Regularity { exponent, step } => {
                write!(
                    f,
                    "{} your advanced loop is not smooth: its Fourier coefficients decay as for H^{exponent:.1}",
                    capitalised(&step.to_string())
                )?;
                match roughness(*exponent) {
                    Some(roughness) => write!(
                        f,
                        ". It has {roughness}, or slopes that the samples do not resolve."
                    ),
                    None => f.write_str("."),
                }
            }
            MapFinding::LittleMotion { motion, group } => little_motion(f, motion, *group),
            MapFinding::Moves {
                motion,
                has_step_size,
            } => moves(f, motion, *has_step_size),
            MapFinding::Beyond { reach, more } => beyond(f, reach, *more),
        }
    }
}

fn fmt_scatter(f: &mut Formatter<'_>, scatter: &Scatter) -> Result {
    let Scatter {
        coordinate,
        dof,
        size,
        kind,
    } = scatter;
    match kind {
        ScatterKind::Rounding => write!(
            f,
            "Results of one state differ from batch to batch, by up to {size:.0e} in {coordinate}[{dof}]. That is rounding, as \
             in matrix products that add up in another order."
        ),
        ScatterKind::Noise => write!(
            f,
            "Results of one state differ at random, by {size:.0e} in {coordinate}[{dof}], as in parallel sums or after a \
             solver that starts at random. Results differ from run to run by this noise."
        ),
        ScatterKind::RandomNumbers => write!(
            f,
            "Results of one state differ at random, by {size:.0e} in {coordinate}[{dof}], and rounding is smaller: the step \
             draws random numbers, or keeps something from earlier calls."
        ),
    }
}

fn fmt_precision(f: &mut Formatter<'_>, precision: &OutputPrecision) -> Result {
    let format = match precision.format {
        OutputFormat::Decimal { digits } => format!("has no more than {digits} decimal digits"),
        OutputFormat::Multiples => "takes values at equal distances".into(),
        OutputFormat::Single => "is a number of single precision".into(),
        OutputFormat::Binary { digits: 11 } => "is a number of half precision".into(),
        OutputFormat::Binary { digits: 8 } => "is a number of bfloat16".into(),
        OutputFormat::Binary { digits } => format!("has no more than {digits} binary digits"),
    };
    write!(
        f,
        "After the step {}[{}] {format}, at every sample: the map rounds what it returns, to about {:.0e}. Each state has this error. The \
         loop integral averages over many states, and is more accurate.",
        precision.coordinate, precision.dof, precision.unit
    )
}

/// The meaning of a Sobolev exponent for a loop that is not smooth.
pub(in crate::verdict) fn roughness(exponent: f64) -> Option<&'static str> {
    match exponent {
        0.25..1.0 => Some("jumps"),
        1.0..2.0 => Some("kinks"),
        2.0..4.5 => Some("higher derivatives that jump"),
        _ => None,
    }
}

/// The defect of a method of order 4 is the first term of a series, which holds up to about this phase advance.
const MAX_PHASE_ADVANCE_OF_SERIES: f64 = 1.0;

fn moves(f: &mut Formatter<'_>, motion: &Motion, has_step_size: bool) -> Result {
    let subject = match has_step_size {
        true => "The largest step",
        false => "The map",
    };
    if motion.deformation == 0.0 && !motion.moves {
        write!(f, "{subject} leaves every state of the loops where it is.")
    } else if motion.is_rounding() {
        write!(
            f,
            "{subject} deforms the loop by little more than rounding errors."
        )
    } else if motion.shear {
        write!(
            f,
            "{subject} is a kick or a free flight alone, and deforms a loop by {} of its size.",
            short(motion.deformation)
        )
    } else {
        write!(
            f,
            "{subject} rotates the loop by up to {} rad (phase advance).",
            short(motion.phase_advance)
        )?;
        match has_step_size && motion.phase_advance <= MAX_PHASE_ADVANCE_OF_SERIES {
            true => write!(
                f,
                " In such a step, a Runge–Kutta method of order 4 changes ∮p·dq by about {}.",
                one_digit(defect_of_order_4(motion.phase_advance))
            ),
            false => Ok(()),
        }
    }
}

fn beyond(f: &mut Formatter<'_>, reach: &Reach, more: bool) -> Result {
    let step = &reach.step;
    match step.step_size {
        Some(_) if !more => {
            f.write_str("Larger step sizes move the loops no further: a random loop")?
        }
        Some(h) => write!(f, "Beyond it, at h = {}, a random loop", size(h))?,
        None => write!(f, "A random loop {} times as large", short(reach.factor))?,
    }
    let moved = step.motion.filter(|moved| more && !moved.shear);
    if let Some(moved) = moved {
        write!(f, " is rotated by {} rad, and", short(moved.phase_advance))?;
    }
    match reach.shows_defect() {
        true => write!(
            f,
            " changes its integral by {:+.3e}, with an uncertainty of {:.1e}.",
            step.defect.signed,
            step.defect.uncertainty()
        ),
        false => write!(f, " is conserved to {:.1e}.", step.bound()),
    }
}

fn little_motion(f: &mut Formatter<'_>, motion: &Motion, group: Option<usize>) -> Result {
    if motion.deformation == 0.0 {
        f.write_str(match motion.moves {
            true => "The step moved all states of the loop by the same amount.",
            false => "The step moved no state of the loop.",
        })
    } else if motion.is_rounding() {
        f.write_str("The step deforms a loop by little more than rounding errors, too little to show a change.")
    } else if motion.shear {
        write!(
            f,
            "The largest step is a kick or a free flight alone, and deforms a loop by only {:.1e} of its size, too little to show a \
             change.",
            motion.deformation
        )
    } else {
        write!(
            f,
            "The largest step rotates a loop{} by only {:.1e} rad, too little to show a change.",
            match group {
                None => String::new(),
                Some(index) => format!(" of group {}", index + 1),
            },
            motion.phase_advance
        )
    }
}

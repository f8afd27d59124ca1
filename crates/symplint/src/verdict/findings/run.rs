//! Measurements besides the loops, and omissions.

use std::fmt::{Display, Formatter, Result};

use serde::Serialize;

use crate::evidence::{LongTime, Omission};
use crate::text::{two_digits, with_uncertainty};
use crate::verdict::jacobian::JacobianFinding;
use crate::verdict::long_time::Growth;

/// Measurements besides the loops, and omissions.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
#[non_exhaustive]
pub enum RunFinding {
    /// No evidence: no loop was advanced, and none failed.
    NothingMeasured,
    /// What becomes of the defect in many steps.
    ManySteps {
        /// The measurement.
        steps: LongTime,
        /// What follows.
        growth: Growth,
    },
    /// The Jacobian of a step, compared with the loops.
    Jacobian {
        /// Its verdict.
        finding: JacobianFinding,
    },
    /// Loops are conserved, but the Jacobian has a defect of more than ten times its uncertainty.
    JacobianRefutes,
    /// Something was left out.
    Omitted {
        /// What.
        omission: Omission,
    },
    /// The cost of the verdict.
    Evaluations {
        /// Made.
        made: usize,
        /// Allowed.
        budget: usize,
    },
}

impl Display for RunFinding {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            RunFinding::NothingMeasured => f.write_str("No loop was measured."),
            RunFinding::ManySteps { steps, growth } => fmt_long_time(f, steps, *growth),
            RunFinding::Jacobian { finding } => finding.fmt(f),
            RunFinding::JacobianRefutes => f.write_str(
                "The loops are conserved, but the Jacobian of a step is not symplectic.",
            ),
            RunFinding::Omitted { omission } => omission.fmt(f),
            RunFinding::Evaluations { made, budget } => {
                write!(f, "Evaluations of the map: {made}, of at most {budget}.")
            }
        }
    }
}

fn fmt_long_time(f: &mut Formatter<'_>, found: &LongTime, growth: Growth) -> Result {
    let LongTime {
        asked,
        steps,
        samples,
        early,
        late,
        least,
        exponent,
        change,
        predicted,
        ..
    } = found;
    if *steps == 0 {
        return write!(
            f,
            "The change in {asked} steps was not measured: after the first step, {samples} samples do not resolve the loop. Take a smaller \
             loop or more samples."
        );
    }
    match growth {
        Growth::None => write!(f, "No change adds up in {steps} steps.")?,
        Growth::Bounded => write!(
            f,
            "In {steps} steps the change stays bounded: it reaches {early:.1e} in the first quarter and {late:.1e} in the last, and falls \
             back to {least:.1e}. Methods that are conjugate to a symplectic one do this."
        )?,
        Growth::Grows => {
            let law = exponent.map_or(String::new(), |exponent| match exponent {
                0.35..0.65 => " in proportion to √n".to_owned(),
                0.85..1.15 => " in proportion to n".to_owned(),
                _ => format!(" in proportion to n^{exponent:.1}"),
            });
            write!(
                f,
                "In {steps} steps the change adds up{law}, from {early:.1e} in the first quarter to {late:.1e} in the last."
            )?;
            if let Some([value, error]) = predicted {
                let half = steps / 2;
                write!(
                    f,
                    " The first {half} steps predict a change of the area by {} after {steps} steps; {} was measured.",
                    with_uncertainty(*value, *error),
                    two_digits(*change)
                )?;
            }
        }
        Growth::Undecided => write!(f, "{steps} steps do not show whether the change adds up.")?,
    }
    if steps < asked {
        write!(
            f,
            " After step {steps} of {asked}, the loop is folded too finely for {samples} samples. Take a smaller loop or more samples."
        )?;
    }
    Ok(())
}

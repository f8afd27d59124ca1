//! The origin of a defect.

use std::fmt::{Display, Formatter, Result};

use serde::Serialize;

use super::Step;
use crate::evidence::{SIGNIFICANT, Sector, SubstepDefect};

/// The origin of a defect.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
#[non_exhaustive]
pub enum LocalisationFinding {
    /// The effect of the substeps of the map on the loop.
    Substeps {
        /// All of them.
        substeps: Vec<SubstepDefect>,
        /// The step.
        step: Step,
    },
    /// Which part of the disc within the loop carries the defect.
    Sectors {
        /// All of them.
        sectors: Vec<Sector>,
        /// The step.
        step: Step,
    },
}

impl Display for LocalisationFinding {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            LocalisationFinding::Substeps { substeps, step } => fmt_substeps(f, substeps, step),
            LocalisationFinding::Sectors { sectors, step } => fmt_sectors(f, sectors, step),
        }
    }
}

/// Substeps that are named, those with the largest changes.
const NAMED: usize = 5;

fn fmt_substeps(f: &mut Formatter<'_>, substeps: &[SubstepDefect], step: &Step) -> Result {
    let uncertainty = |of: &SubstepDefect| of.uncertainty.unwrap_or(f64::INFINITY);
    let changes = |of: &SubstepDefect| of.change.abs() > SIGNIFICANT * uncertainty(of);
    let (mut guilty, others): (Vec<&SubstepDefect>, Vec<&SubstepDefect>) =
        (substeps.iter()).partition(|of| changes(of) || of.new_breaks > 0);
    let count = substeps.len();
    if guilty.is_empty() {
        return write!(
            f,
            "None of the {count} substeps {step} changes the loop integral significantly."
        );
    }
    let least = others.iter().map(|of| of.change.abs() + uncertainty(of));
    let conserved = least.fold(0.0, f64::max);
    let all = guilty.len();
    if all > NAMED {
        guilty.sort_by(|a, b| b.change.abs().total_cmp(&a.change.abs()));
        guilty.truncate(NAMED);
        guilty.sort_by_key(|of| of.substep);
    }
    let texts = guilty.iter().map(|of| {
        let mut text = format!("substep {} ({})", of.substep.saturating_add(1), of.name);
        if of.new_breaks > 0 {
            text += " breaks the loop";
        }
        if changes(of) {
            let and = if of.new_breaks > 0 { " and" } else { "" };
            text += &format!("{and} changes the loop integral by {:+.2e}", of.change);
        }
        text
    });
    let mut named = texts.collect::<Vec<String>>().join(", ");
    if all > NAMED {
        named += &format!(", and {} more change it by less", all - NAMED);
    }
    let rest = match others.is_empty() {
        true => String::new(),
        false if conserved.is_finite() => format!("; the others conserve it to {conserved:.1e}"),
        false => "; the changes by the others are not known".into(),
    };
    write!(f, "Of the {count} substeps {step}, {named}{rest}.")
}

/// A sector that makes this part of all changes is named. Conventional.
const LARGE_SHARE: f64 = 0.4;

/// The sector that changes most, if that is more than its uncertainty.
pub(in crate::verdict) fn largest_sector(sectors: &[Sector]) -> Option<&Sector> {
    (sectors.iter())
        .max_by(|a, b| a.change.abs().total_cmp(&b.change.abs()))
        .filter(|sector| sector.uncertainty.is_some_and(|u| sector.change.abs() > u))
}

fn fmt_sectors(f: &mut Formatter<'_>, sectors: &[Sector], step: &Step) -> Result {
    let Some(largest) = largest_sector(sectors) else {
        return write!(
            f,
            "No sector of the disc within the loop stands out {step}."
        );
    };
    let all: f64 = sectors.iter().map(|sector| sector.change.abs()).sum();
    let share = largest.change.abs() / all;
    let (count, percent) = (sectors.len(), (100.0 * share).round());
    if share >= LARGE_SHARE {
        write!(
            f,
            "Of {count} sectors of the disc within the loop, that from s = {} to {} changes most {step}: by \
             {:+.2e}, {percent}% of the sum of all absolute changes.",
            largest.from, largest.to, largest.change
        )
    } else {
        write!(
            f,
            "The defect {step} is spread over the disc within the loop: of {count} sectors none makes more than \
             {percent}% of the sum of all absolute changes."
        )
    }
}

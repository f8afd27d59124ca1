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

fn fmt_substeps(f: &mut Formatter<'_>, substeps: &[SubstepDefect], step: &Step) -> Result {
    let mut found = Vec::new();
    let mut others = 0.0f64;
    for substep in substeps {
        let uncertainty = substep.uncertainty.unwrap_or(f64::INFINITY);
        let changes = substep.change.abs() > SIGNIFICANT * uncertainty;
        let breaks = substep.new_breaks > 0;
        if !(changes || breaks) {
            others = others.max(substep.change.abs() + uncertainty);
            continue;
        }
        let mut text = format!(
            "substep {} ({})",
            substep.substep.saturating_add(1),
            substep.name
        );
        if breaks {
            text += " breaks the loop";
        }
        if changes {
            let and = if breaks { " and" } else { "" };
            text += &format!("{and} changes the loop integral by {:+.2e}", substep.change);
        }
        found.push(text);
    }
    let count = substeps.len();
    if found.is_empty() {
        return write!(
            f,
            "None of the {count} substeps {step} changes the loop integral significantly."
        );
    }
    let rest = match found.len() == count {
        true => String::new(),
        false if others.is_finite() => format!("; the others conserve it to {others:.1e}"),
        false => "; the changes by the others are not known".into(),
    };
    write!(
        f,
        "Of the {count} substeps {step}, {}{rest}.",
        found.join(", ")
    )
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

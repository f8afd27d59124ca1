//! The origin of a defect.

use std::fmt::{Display, Formatter, Result};

use serde::Serialize;

use super::Step;
use crate::evidence::{Sector, SubstepDefect};
use crate::jacobian::{BlockDefects, DefectBlocks};
use crate::signal::SIGNIFICANT;
use crate::text::{one_digit, significant, two_digits};

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
    /// The defect of the Jacobian by blocks.
    Blocks {
        /// The blocks.
        blocks: DefectBlocks,
    },
}

impl Display for LocalisationFinding {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self {
            LocalisationFinding::Substeps { substeps, step } => fmt_substeps(f, substeps, step),
            LocalisationFinding::Sectors { sectors, step } => fmt_sectors(f, sectors, step),
            LocalisationFinding::Blocks { blocks } => write!(
                f,
                "Largest entries of MᵀJM − J, between two positions (qq), a position and a momentum (qp), and two momenta (pp): {}. The \
                 same for the Poisson brackets after the step: {}.",
                blocks_text(&blocks.before),
                blocks_text(&blocks.after)
            ),
        }
    }
}

/// Substeps that are named, those with the largest changes.
const MAX_NAMED: usize = 5;

fn uncertainty(of: &SubstepDefect) -> f64 {
    of.uncertainty.unwrap_or(f64::INFINITY)
}

fn changes(of: &SubstepDefect) -> bool {
    of.change.abs() > SIGNIFICANT * uncertainty(of)
}

/// The substeps that change or break the loop, and the others.
pub(in crate::verdict) fn culprits(
    substeps: &[SubstepDefect],
) -> (Vec<&SubstepDefect>, Vec<&SubstepDefect>) {
    (substeps.iter()).partition(|of| changes(of) || of.new_breaks > 0)
}

fn fmt_substeps(f: &mut Formatter<'_>, substeps: &[SubstepDefect], step: &Step) -> Result {
    let (mut guilty, others) = culprits(substeps);
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
    if all > MAX_NAMED {
        guilty.sort_by(|a, b| b.change.abs().total_cmp(&a.change.abs()));
        guilty.truncate(MAX_NAMED);
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
    if all > MAX_NAMED {
        named += &format!(", and {} more change it by less", all - MAX_NAMED);
    }
    let rest = match others.is_empty() {
        true => String::new(),
        false if conserved.is_finite() => format!("; the others conserve it to {conserved:.1e}"),
        false => "; the changes by the others are not known".into(),
    };
    write!(f, "Of the {count} substeps {step}, {named}{rest}.")
}

/// `qq 0.031, qp 0.0041, pp 0 (to 2e-12), all in q[1], p[1]`.
pub(in crate::verdict) fn blocks_text(side: &BlockDefects) -> String {
    let zeros = side.zeros();
    let block = |k: usize| {
        let (name, bound) = (["qq", "qp", "pp"][k], side.bounds[k]);
        match (zeros[k], side.sizes[k] == 0.0) {
            (true, _) => format!("{name} 0 (to {})", one_digit(bound)),
            (_, true) => format!("{name} below {}", one_digit(bound)),
            _ => format!("{name} {}", two_digits(side.sizes[k])),
        }
    };
    let text = [0, 1, 2].map(block).join(", ");
    match side.carriers() {
        Some(dofs) => {
            let names = dofs.iter().map(|i| format!("q[{i}], p[{i}]"));
            format!("{text}, all in {}", names.collect::<Vec<_>>().join(", "))
        }
        None => text,
    }
}

/// A sector that makes this part of all changes is named. Conventional.
const MIN_NAMED_SHARE: f64 = 0.4;

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
            "No part of the loop contributes much more than the others {step}."
        );
    };
    let all: f64 = sectors.iter().map(|sector| sector.change.abs()).sum();
    let share = largest.change.abs() / all;
    let (count, percent) = (sectors.len(), (100.0 * share).round());
    if share >= MIN_NAMED_SHARE {
        write!(
            f,
            "Of {count} sectors of the loop, the one from s = {} to {} contributes most {step}: {:+.2e}, {percent}% of the sum of all \
             absolute changes.",
            significant(largest.from),
            significant(largest.to),
            largest.change
        )
    } else {
        write!(
            f,
            "The change {step} comes from all parts of the loop: none of {count} sectors contributes more than {percent}%."
        )
    }
}

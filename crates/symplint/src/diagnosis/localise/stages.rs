//! Which substep of a composition changes or breaks a loop.

use serde::Serialize;

use super::super::probe::{Method, Probe, Subject};
use crate::error::Error;
use crate::rules::Defect;
use crate::verdict::BEYOND_DOUBT;

/// What one substep of the map does to the loop.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stage {
    /// Which substep, 0 for the first.
    pub substep: usize,
    /// Its name.
    pub name: String,
    /// Signed change of the loop integral, with its breaks closed, relative to that before the step.
    pub change: f64,
    /// How far off `change` may be; `None` where that is not known.
    pub uncertainty: Option<f64>,
    /// Breaks of the loop after this substep.
    pub breaks: usize,
    /// Those of them that were not there before it.
    pub new_breaks: usize,
}

/// Breaks nearer than this part of the loop are one: a later substep moves states, and no parameter. Twice
/// the cell that a break is located to, with room for the rounding of its ends.
const SAME_PLACE: f64 = 5e-14;

/// Whether two places of the loop are one; it ends where it begins.
fn same_place(a: f64, b: f64) -> bool {
    let distance = (a - b).abs();
    distance.min(1.0 - distance) <= SAME_PLACE
}

/// Integrates the loop after every substep.
pub(super) fn stages(subject: Subject<'_>, method: Method, h: f64) -> Result<Vec<Stage>, Error> {
    let mut before: Option<Defect> = None;
    let mut broken_at: Vec<f64> = Vec::new();
    (0..subject.evaluator.substeps())
        .map(|substep| {
            let prefix = subject.evaluator.prefix(substep + 1);
            let subject = Subject {
                evaluator: &prefix,
                ..subject
            };
            let name = subject.evaluator.substep_name(substep);
            let measured = Probe::new(0, subject, method)?.measure(h)?;
            let defect = measured.closing.map_or(measured.defect, |c| c.closed);
            let places: Vec<f64> = measured.breaks.iter().map(|found| found.s).collect();
            let is_new = |s: &&f64| !broken_at.iter().any(|old| same_place(**s, *old));
            let (breaks, new_breaks) = (places.len(), places.iter().filter(is_new).count());
            broken_at = places;
            let since = before.map_or(0.0, |before| before.signed);
            let doubt = before.map_or(0.0, |before| before.uncertainty());
            before = Some(defect);
            // A broken loop has no integral, unless its breaks are closed.
            let open = breaks > 0 && measured.closing.is_none();
            let uncertainty = match open {
                true => f64::INFINITY,
                false => doubt + defect.uncertainty(),
            };
            Ok(Stage {
                substep,
                name,
                change: defect.signed - since,
                uncertainty: uncertainty.is_finite().then_some(uncertainty),
                breaks,
                new_breaks,
            })
        })
        .collect()
}

/// What the substeps do, in a sentence.
pub(super) fn line(stages: &[Stage], h: &str) -> Option<String> {
    let mut culprits = Vec::new();
    let mut others = 0.0f64;
    for stage in stages {
        let uncertainty = stage.uncertainty.unwrap_or(f64::INFINITY);
        let changes = stage.change.abs() > BEYOND_DOUBT * uncertainty;
        let tears = stage.new_breaks > 0;
        if !(changes || tears) {
            others = others.max(stage.change.abs() + uncertainty);
            continue;
        }
        let mut text = format!("substep {} ({})", stage.substep + 1, stage.name);
        if tears {
            text += " breaks the loop";
        }
        if changes {
            let and = if tears { " and" } else { "" };
            text += &format!("{and} changes the loop integral by {:+.2e}", stage.change);
        }
        culprits.push(text);
    }
    if stages.is_empty() {
        return None;
    }
    let count = stages.len();
    if culprits.is_empty() {
        return Some(format!(
            "None of the {count} substeps at h = {h} changes the loop integral beyond doubt."
        ));
    }
    let rest = match culprits.len() == count {
        true => String::new(),
        false if others.is_finite() => format!("; the others conserve it to {others:.1e}"),
        false => "; of the others nothing is known".into(),
    };
    Some(format!(
        "Of the {count} substeps at h = {h}, {}{rest}.",
        culprits.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loop_ends_where_it_begins() {
        assert!(same_place(0.3, 0.3 + 2e-14) && !same_place(0.3, 0.3 + 1e-12));
        assert!(same_place(0.0, 1.0 - 1e-14) && same_place(1.0 - 1e-14, 0.0));
        assert!(!same_place(0.0, 0.5));
    }
}

//! Which substep of a composition changes or breaks a loop.

use crate::diagnosis::resolve::initial_samples::InitialSamples;
use crate::diagnosis::resolve::probe::Probe;
use crate::error::Error;
use crate::evidence::SubstepDefect;
use crate::rules::{Defect, LoopIntegral, Rule, Subject};
use crate::state::Ensemble;

/// Breaks nearer than this part of the loop are one: a later substep moves states, and no parameter. They are known to
/// the last double, and to what the rounding of a substep makes of a threshold.
const MAX_DISTANCE_OF_SAME_BREAK: f64 = 5e-14;

/// Whether two parameters of the loop are one; it ends where it begins.
fn is_one(a: f64, b: f64) -> bool {
    let distance = (a - b).abs();
    distance.min(1.0 - distance) <= MAX_DISTANCE_OF_SAME_BREAK
}

/// Integrates the loop after every substep, in one pass of its samples through all of them.
pub(super) fn defects_in_one_pass(
    subject: Subject<'_>,
    rule: Rule,
    samples: usize,
    h: f64,
) -> Result<Vec<SubstepDefect>, Error> {
    let (evaluator, coordinates) = (subject.evaluator, subject.coordinates());
    let mut states = Ensemble::sample(subject.phase_loop, samples)?;
    let integral = |states: &Ensemble| LoopIntegral::in_coordinates(states, &rule, coordinates);
    let initial = integral(&states)?;
    let mut before = Defect::between(&initial, &initial)?;
    (0..evaluator.substeps())
        .map(|substep| {
            evaluator.advance_substep(&mut states, substep, h)?;
            let after = Defect::between(&initial, &integral(&states)?)?;
            let uncertainty = before.uncertainty() + after.uncertainty();
            let change = after.signed - before.signed;
            before = after;
            Ok(SubstepDefect {
                substep,
                name: evaluator.substep_name(substep),
                change,
                uncertainty: uncertainty.is_finite().then_some(uncertainty),
                breaks: 0,
                new_breaks: 0,
            })
        })
        .collect()
}

/// Integrates the loop after every substep, each time from the beginning: breaks are followed there.
pub(super) fn defects(
    subject: Subject<'_>,
    rule: Rule,
    samples: usize,
    h: f64,
) -> Result<Vec<SubstepDefect>, Error> {
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
            let initial = &mut InitialSamples::new(subject);
            let known = Probe::new(initial, rule, samples)?.measure(initial, h, &mut |_| {})?;
            let measured = known.advanced;
            let defect = measured
                .closed
                .map_or(measured.defect, |closed| closed.defect);
            let breaks_at: Vec<f64> = measured.breaks.iter().map(|found| found.s).collect();
            let is_new = |s: &&f64| !broken_at.iter().any(|old| is_one(**s, *old));
            let (breaks, new_breaks) = (breaks_at.len(), breaks_at.iter().filter(is_new).count());
            broken_at = breaks_at;
            let since = before.map_or(0.0, |before| before.signed);
            let uncertainty_before = before.map_or(0.0, |before| before.uncertainty());
            before = Some(defect);
            // A broken loop has no integral, unless its breaks are closed.
            let open = breaks > 0 && measured.closed.is_none();
            let uncertainty = match open {
                true => f64::INFINITY,
                false => uncertainty_before + defect.uncertainty(),
            };
            Ok(SubstepDefect {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loop_ends_where_it_begins() {
        assert!(is_one(0.3, 0.3 + 2e-14) && !is_one(0.3, 0.3 + 1e-12));
        assert!(is_one(0.0, 1.0 - 1e-14) && is_one(1.0 - 1e-14, 0.0));
        assert!(!is_one(0.0, 0.5));
    }
}

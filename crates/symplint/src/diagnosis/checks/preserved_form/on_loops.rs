//! Loop integrals of a constant two-form: ∮ Σ Ω_ab z_a dz_b.

use super::limits::{FIRST_SAMPLES, KNOWN, MOST_SAMPLES};
use crate::error::Error;
use crate::evidence::{FormEntry, FormOnLoop};
use crate::map::states_at;
use crate::rules::{LoopIntegral, Rule, Subject};
use crate::signal::unwrap_row;
use crate::state::{Coordinates, Ensemble, coordinate, period};

/// The change of the integrals of the canonical form and of another one round a loop in one step. `None` if the loop winds round a
/// period, or the error of an integral is not known. Samples are doubled while `evaluations` allow it.
pub(super) fn change(
    subject: Subject<'_>,
    loop_index: usize,
    h: f64,
    entries: &[FormEntry],
    evaluations: usize,
) -> Result<Option<FormOnLoop>, Error> {
    let (evaluator, coordinates) = (subject.evaluator, subject.coordinates());
    let canonical: Vec<FormEntry> = (0..subject.dof())
        .map(|i| FormEntry {
            coordinates: [i, subject.dof() + i],
            value: coordinates.weight(i),
            error: 0.0,
            group: 0,
        })
        .collect();
    let mut before = Ensemble::sample(subject.phase_loop, FIRST_SAMPLES)?;
    let mut after = before.clone();
    evaluator.advance(&mut after, h)?;
    loop {
        let states = [&before, &after];
        let [canonical_change, preserved] = [&canonical[..], entries]
            .map(|form| relative_change(states.map(|of| integral(of, form, coordinates))));
        let samples = before.samples();
        let is_known = preserved.is_some_and(|[_, uncertainty]| uncertainty < KNOWN);
        if is_known || 2 * samples > MOST_SAMPLES.min(evaluations) {
            return Ok(canonical_change
                .zip(preserved)
                .map(|(canonical, preserved)| FormOnLoop {
                    loop_index,
                    canonical,
                    preserved,
                }));
        }
        let between: Vec<f64> = (0..samples)
            .map(|k| (k as f64 + 0.5) / samples as f64)
            .collect();
        before.interleave(&states_at(subject.phase_loop, &between));
        after.interleave(&evaluator.image(subject.phase_loop, h, &between)?);
    }
}

/// The change between two integrals and its uncertainty, relative to the sum of the sizes of the terms of the first.
fn relative_change([before, after]: [Option<LoopIntegral>; 2]) -> Option<[f64; 2]> {
    let (before, after) = (before?, after?);
    let quadrature = before.quadrature_error? + after.quadrature_error?;
    let change = [
        (after.value - before.value) / before.scale,
        (quadrature + before.roundoff + after.roundoff) / before.scale,
    ];
    change.iter().all(|x| x.is_finite()).then_some(change)
}

/// ∮ Σ Ω_ab z_a dz_b, as the integral of one degree of freedom for each b, with the momentum Σ_a Ω_ab z_a. `None` if a coordinate winds
/// or the integral is beyond the range of doubles.
fn integral(
    states: &Ensemble,
    form: &[FormEntry],
    coordinates: &Coordinates,
) -> Option<LoopIntegral> {
    let mut seconds: Vec<usize> = form.iter().map(|entry| entry.coordinates[1]).collect();
    seconds.sort_unstable();
    seconds.dedup();
    let mut rows = Ensemble::zeros(seconds.len(), states.samples());
    let mut block = rows.block();
    let unwrapped = |c: usize| {
        let mut row = coordinate(states, c).to_vec();
        let winding = unwrap_row(&mut row, period(coordinates, c));
        (winding == 0).then_some(row)
    };
    for (k, &second) in seconds.iter().enumerate() {
        block.q.row_mut(k).copy_from_slice(&unwrapped(second)?);
        for entry in form.iter().filter(|entry| entry.coordinates[1] == second) {
            let row = unwrapped(entry.coordinates[0])?;
            let momenta = block.p.row_mut(k).iter_mut().zip(row);
            momenta.for_each(|(p, z)| *p += entry.value * z);
        }
    }
    LoopIntegral::of(&rows, &Rule::Pseudospectral).ok()
}

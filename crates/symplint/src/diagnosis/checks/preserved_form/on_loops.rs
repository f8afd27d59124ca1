//! Loop integrals of a closed two-form: ∮ Σ Ω_ab z_a dz_b, with polynomials in q instead of z_a if it varies.

use super::limits::{MAX_LOOP_ERROR, MIN_GAIN_OF_DOUBLING};
use crate::error::Error;
use crate::evidence::{FormEntry, FormOnLoop, monomial};
use crate::loops::FEW_SAMPLES;
use crate::map::states_at;
use crate::rules::{LoopIntegral, Rule, Subject};
use crate::signal::unwrap_row;
use crate::state::{Coordinates, Ensemble, coordinate, period};

/// A loop before and after a step.
pub(super) struct AdvancedLoop {
    before: Ensemble,
    after: Ensemble,
}

/// The change of the integral of a form in one step.
pub(super) struct Change {
    /// The parts of the entries; the change is their sum.
    pub parts: Vec<f64>,
    /// Half the width of the interval in which the change lies.
    pub uncertainty: f64,
    /// The sum of the sizes of all terms of the integral.
    pub scale: f64,
}

impl AdvancedLoop {
    /// The loop after a step of size `h`, with the fewest samples.
    pub fn new(subject: Subject<'_>, h: f64) -> Result<Self, Error> {
        let before = Ensemble::sample(subject.phase_loop, FEW_SAMPLES)?;
        let mut after = before.clone();
        subject.evaluator.begin_loop();
        subject.evaluator.advance(&mut after, h)?;
        Ok(AdvancedLoop { before, after })
    }

    fn doubled(&mut self, subject: Subject<'_>, h: f64) -> Result<(), Error> {
        let samples = self.before.samples();
        let middle = |k: usize| (k as f64 + 0.5) / samples as f64;
        let between: Vec<f64> = (0..samples).map(middle).collect();
        let after = subject.evaluator.image(subject.phase_loop, h, &between)?;
        (self.before).interleave(&states_at(subject.phase_loop, &between));
        self.after.interleave(&after);
        Ok(())
    }

    /// The change of the integral of a form. `None` if the loop winds round a period, or an error is not known.
    pub fn change(&self, form: &[FormEntry], coordinates: &Coordinates) -> Option<Change> {
        let before = integral(&self.before, form, coordinates)?;
        let after = integral(&self.after, form, coordinates)?;
        let quadrature = before.quadrature_error? + after.quadrature_error?;
        let parts = after.contributions.iter().zip(&before.contributions);
        let change = Change {
            parts: parts.map(|(after, before)| after - before).collect(),
            uncertainty: quadrature + before.roundoff + after.roundoff,
            scale: before.scale,
        };
        let numbers = [change.uncertainty, change.scale, change.parts.iter().sum()];
        (numbers.iter().all(|x| x.is_finite()) && change.scale > 0.0).then_some(change)
    }
}

impl Change {
    /// The change and its uncertainty, relative to the scale.
    fn relative(&self) -> [f64; 2] {
        let change: f64 = self.parts.iter().sum();
        [change / self.scale, self.uncertainty / self.scale]
    }
}

/// The change of the integrals of the canonical form and of another one round a loop in one step. `None` as of [`AdvancedLoop::change`].
/// Samples are doubled up to `most` while that helps.
pub(super) fn change(
    subject: Subject<'_>,
    loop_index: usize,
    h: f64,
    form: &[FormEntry],
    most: usize,
) -> Result<Option<FormOnLoop>, Error> {
    let coordinates = subject.coordinates();
    let canonical: Vec<FormEntry> = (0..subject.dof())
        .map(|i| FormEntry {
            coordinates: [i, subject.dof() + i],
            powers: [0; 3],
            value: coordinates.weight(i),
            error: 0.0,
            group: 0,
        })
        .collect();
    let mut advanced = AdvancedLoop::new(subject, h)?;
    let mut last = f64::INFINITY;
    loop {
        let of = |form| advanced.change(form, coordinates);
        let found = of(&canonical).zip(of(form));
        let uncertainty = (found.as_ref()).map_or(f64::MAX, |of| of.1.relative()[1]);
        let is_enough = uncertainty < MAX_LOOP_ERROR || uncertainty > last / MIN_GAIN_OF_DOUBLING;
        if is_enough || 2 * advanced.before.samples() > most {
            return Ok(found.map(|(canonical, preserved)| FormOnLoop {
                loop_index,
                canonical: canonical.relative(),
                preserved: preserved.relative(),
            }));
        }
        last = uncertainty;
        advanced.doubled(subject, h)?;
    }
}

/// ∮ Σ Ω_ab z_a dz_b, as the integral of one degree of freedom z_b with the momentum z_a, times powers of q, for each entry. `None` if a
/// coordinate winds or the integral is beyond the range of doubles.
fn integral(
    states: &Ensemble,
    form: &[FormEntry],
    coordinates: &Coordinates,
) -> Option<LoopIntegral> {
    let mut rows = Ensemble::zeros(form.len(), states.samples());
    let mut block = rows.block();
    for (k, entry) in form.iter().enumerate() {
        let [a, b] = entry.coordinates;
        for (c, row) in [(a, block.p.row_mut(k)), (b, block.q.row_mut(k))] {
            row.copy_from_slice(coordinate(states, c));
            if unwrap_row(row, period(coordinates, c)) != 0 {
                return None;
            }
        }
        let powers = entry.powers;
        let of_a = powers.get(a).map_or(0, |power| *power);
        for (j, x) in block.p.row_mut(k).iter_mut().enumerate() {
            *x *= monomial(powers, |i| coordinate(states, i)[j]) / f64::from(1 + of_a);
        }
    }
    let values = form.iter().map(|entry| entry.value).collect();
    let weighted = Coordinates::plain(form.len()).with_weights(values).ok()?;
    LoopIntegral::in_coordinates(&rows, &Rule::Pseudospectral, &weighted).ok()
}
